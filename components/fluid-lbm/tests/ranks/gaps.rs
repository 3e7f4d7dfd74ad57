//! Gaps that the scene declares, and surfaces that deform, across the cuts between ranks.

use crate::common::*;
use crate::story::Story;
use tremie_fluid_lbm::{Precision, Refill};
use tremie_geometry::Turned;
use tremie_messages::BodyState;
use tremie_messages::SurfaceVertex;
use tremie_messages::scene::{
    Course, Face, Gap, GapRegion, GapRule, GapSide, GapWeight, Geometry, Motion, Outflow, Probe,
    ProbeShape,
};

/// Layers of 640 cells: a block has 6.4 of them.
const CELLS: [usize; 3] = [160, 4, 72];

fn open(pressure: f64) -> Face {
    Face::Pressure { pressure, course: Course::default(), outflow: Outflow::Absorbing }
}

/// A plate beside a wall, along which it shuts all but both ends of a channel, moves off it, or on to it. Where `radii`
/// leave the middle out, it is a pocket while the rest is shut.
fn slot(
    [height, speed]: [f64; 2],
    rule: GapRule,
    slip_below: f64,
    radii: Option<[f64; 2]>,
) -> Story {
    let mut case = Case::new(CELLS, [WALL, SYMMETRY, WALL], 0.504);
    case.refill = Refill::Mass;
    case.average_force = true;
    case.smagorinsky = 0.2;
    let mut scene = case.scene();
    scene.domain.faces[2] = [open(3e-4), open(0.0)];
    let mut plate = part("plate", Geometry::Box { size: [40.0, 20.0, 50.0] }, [0.0; 3]);
    plate.motion = Motion::Prescribed(Vec::new());
    scene.parts.push(plate);
    for (name, z) in [("before", 6.2), ("behind", 66.3)] {
        let shape = ProbeShape::Point([3.1, 2.0, z]);
        scene.probes.push(Probe { name: name.into(), shape });
    }
    scene.gaps.push(Gap {
        name: "slot".into(),
        between: [GapSide::Part("plate".into()), GapSide::Face { axis: 0, side: 0 }],
        open_at: 1.5,
        close_at: 1.2,
        pressure: rule,
        slip_below,
        region: radii.map(|radii| GapRegion::Ring { axis: 1, through: [0.0, 0.0, 36.0], radii }),
    });
    let mut story = Story::of(scene, case);
    story.events.push(added_part(0, 0));
    let (velocity, angular_velocity) = ([speed, 0.0, 0.0], [0.0, 3e-5, 0.0]);
    let still = BodyState::at_rest(0, [20.0 + height, 2.0, 36.0]);
    story.bodies.push(BodyState { velocity, angular_velocity, ..still });
    story.steps = 60;
    story.with(1.3, [2.2, 2.1, 7.3], [-0.01, 0.0, 0.05]).with(
        1.4,
        [70.4, 1.9, 33.0],
        [0.0, 0.01, 0.04],
    )
}

fn probes() -> GapRule {
    let weight = |(probe, weight): (&str, f64)| GapWeight { probe: probe.into(), weight };
    GapRule::Probes([("before", 0.7), ("behind", 0.3)].map(weight).to_vec())
}

/// Radii that leave 52 cells of the middle out.
const MIDDLE: [f64; 2] = [6.6, 50.0];

/// Most frozen cells in a step of the story, and those at its end.
fn frozen(story: &Story) -> [usize; 2] {
    let mut fluid = story.case.fluid_of(&story.scene);
    story.begin(&mut fluid);
    let mut most = 0;
    for step in 0..story.steps {
        story.go(&mut fluid, step..step + 1);
        most = most.max(fluid.diagnostics().frozen);
    }
    [most, fluid.diagnostics().frozen]
}

#[test]
fn a_slot_that_opens_and_one_that_shuts() {
    let opens = slot([0.9, 0.02], probes(), 4.0, None);
    let [most, end] = frozen(&opens);
    assert!(most > 180 && end == 0, "{most} {end}");
    opens.holds_for(&[2, 5]);
    let shuts = slot([1.6, -0.012], GapRule::Nearest, 4.0, None);
    let [_, end] = frozen(&shuts);
    assert!(end > 180, "{end}");
    shuts.holds_for(&[2, 5]);
}

/// The pocket in the middle lies across a cut, and is larger than the copies on either side.
#[test]
fn a_pocket_across_a_cut() {
    let opens = slot([0.9, 0.02], GapRule::Nearest, 0.0, Some(MIDDLE));
    let shuts = slot([1.6, -0.012], probes(), 0.0, Some(MIDDLE));
    // As many as without the region: the middle is a pocket, or else it would stay fluid.
    let whole = frozen(&slot([0.9, 0.02], GapRule::Nearest, 0.0, None))[0];
    assert_eq!(frozen(&opens)[0], whole);
    for story in [opens, shuts] {
        story.holds_for(&[2, 11]);
    }
}

#[test]
fn gaps_are_put_back() {
    slot([0.9, 0.02], probes(), 4.0, None).goes_on(25);
    slot([0.9, 0.02], GapRule::Nearest, 0.0, Some(MIDDLE)).goes_on(20);
}

/// A ring of rubber on its carrier, whose axis crosses the cuts; its foot widens over a wall, with a gap that slips.
fn ring(precision: Precision) -> Story {
    let mut case = Case::new([30, 40, 40], [WALL, WALL, PERIODIC], 0.51);
    case.precision = precision;
    case.average_force = true;
    case.refill = Refill::Mass;
    case.velocity = [0.01, 0.005, 0.0];
    let mut scene = case.scene();
    let carrier = Geometry::Box { size: [3.0, 16.2, 16.2] };
    let mut carrier = part("carrier", carrier, [0.0; 3]);
    carrier.motion = Motion::Prescribed(Vec::new());
    scene.parts.push(carrier);
    let points = vec![[4.0, -1.7], [8.2, -1.9], [8.0, 1.6], [4.2, 1.6]];
    let surface = seal(&points);
    let turned = Turned::of(&surface);
    scene.surfaces.push(surface);
    scene.gaps.push(Gap {
        name: "foot".into(),
        between: [GapSide::Part("seal".into()), GapSide::Face { axis: 0, side: 0 }],
        open_at: 2.0,
        close_at: 0.5,
        pressure: GapRule::Nearest,
        slip_below: 4.0,
        region: None,
    });
    let mut story = Story::of(scene, case);
    story.events.push(added_part(0, 0));
    let velocity = [0.02, 0.0, 0.0];
    story.bodies.push(BodyState { velocity, ..BodyState::at_rest(0, [6.7, 20.0, 20.0]) });
    story.steps = 50;
    // The section's axis is the third: along the domain's first here.
    story.vertices = Some(Box::new(move |step| {
        let vertex = |[y, z, x]: [f64; 3]| {
            let rate = 2e-3 * (1.6 - x) / 3.5;
            let wider = 1.0 + rate * step as f64;
            SurfaceVertex {
                position: [3.6 + x + 0.02 * step as f64, 20.0 + wider * y, 20.0 + wider * z],
                velocity: [0.02, rate * y, rate * z],
            }
        };
        turned.places(&points).into_iter().map(|place| vertex(place.into())).collect()
    }));
    story.with(2.0, [4.0, 30.4, 21.0], [0.0, -0.01, 0.02])
}

#[test]
fn a_ring_that_deforms_across_the_cuts() {
    for precision in [Precision::F64, Precision::F32] {
        let story = ring(precision);
        let [most, end] = frozen(&story);
        assert!(most > 0 && end < most, "{most} {end}");
        story.holds_for(&[2, 4]);
    }
}

#[test]
fn a_ring_is_put_back() {
    ring(Precision::F64).goes_on(17);
}
