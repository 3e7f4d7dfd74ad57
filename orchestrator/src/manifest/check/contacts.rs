//! Checks of `[[scene.contacts]]`: the law of each pair of materials.

use super::super::document::{ContactTable, SceneTable};
use super::super::path;
use super::super::read::Findings;
use super::{chen, materials};
use std::collections::{BTreeMap, BTreeSet};
use tremie_messages::scene::{
    BodySet, ContactLaw, Damping, DeformableSurface, Domain, Face, Motion, PairLaw, Part, Plane,
    Spring,
};
use tremie_messages::units::Dashpot;

/// Surroundings that contacts depend on.
pub(super) struct Surroundings<'a> {
    pub domain: &'a Domain,
    pub planes: &'a [Plane],
    pub parts: &'a [Part],
    pub surfaces: &'a [DeformableSurface],
    pub bodies: &'a [BodySet],
}

/// A law as written; Hertz's springs are known only with the materials.
#[derive(Clone)]
struct Written {
    hertz: bool,
    /// [J/m²]
    work_of_adhesion: Option<f64>,
    law: ContactLaw,
}

/// The laws of all pairs that may touch, and of those that the manifest names besides. Without
/// `around`, because something there is wrong, only the tables themselves are checked.
pub(super) fn contacts(
    scene: &SceneTable,
    around: Option<&Surroundings<'_>>,
    findings: &mut Findings,
) -> Option<Vec<PairLaw>> {
    let known = materials::known(scene);
    let mut named: BTreeMap<[String; 2], Option<Written>> = BTreeMap::new();
    let mut other: Option<Option<Written>> = None;
    for (i, table) in scene.contacts.iter().enumerate() {
        let at = path::item("scene.contacts", i);
        let written = written(scene, table, &at, findings);
        let key = path::join(&at, "between");
        let Some(between) = &table.between else {
            if findings.is_unreadable(&key) {
                continue;
            }
            if other.replace(written).is_some() {
                findings.problem_with_help(
                    &at,
                    "a second law for all pairs that no other entry names",
                    "say which pair it is for, as between = [\"glass\", \"steel\"]",
                );
            }
            continue;
        };
        for (k, name) in between.iter().enumerate() {
            if !materials::is_known(name, &path::item(&key, k), &known, findings) {
                // It may be the one that a pair lacks.
                findings.spoil("scene.contacts".into());
            }
        }
        if named.insert(in_order(between), written).is_some() {
            let message = format!("a second law between \"{}\" and \"{}\"", between[0], between[1]);
            findings.problem(&key, message);
        }
    }
    let pairs = touching(around?);
    let mut told = BTreeSet::new();
    let mut laws = Vec::new();
    for (pair, may_meet) in pairs {
        let found = named.remove(&in_order(&pair)).or_else(|| other.clone());
        match found {
            Some(written) => laws.push(pair_law(scene, pair, written?, &mut told, findings)),
            None if may_meet && !scene.contacts.is_empty() => {
                let [one, two] = &pair;
                if !findings.is_unreadable("scene.contacts") {
                    findings.problem_with_help(
                        "scene.contacts",
                        format!("there is no law between \"{one}\" and \"{two}\", which may meet"),
                        format!("add [[scene.contacts]] with between = [\"{one}\", \"{two}\"], or one without between"),
                    );
                }
            }
            None => {}
        }
    }
    // Laws of pairs that never touch are checked alike, and taken over.
    for (pair, written) in named {
        laws.push(pair_law(scene, pair, written?, &mut told, findings));
    }
    laws.into_iter().collect()
}

/// Two names, the lesser first.
fn in_order(pair: &[String; 2]) -> [String; 2] {
    let [a, b] = pair.clone();
    if a <= b { [a, b] } else { [b, a] }
}

/// All pairs of materials that bodies make with each other and with walls, each once, and whether
/// any of those contacts has a body that moves freely.
fn touching(around: &Surroundings<'_>) -> Vec<([String; 2], bool)> {
    let mut pairs: Vec<([String; 2], bool)> = Vec::new();
    let mut add = |one: &str, two: &str, free: bool| {
        let pair = [one.to_string(), two.to_string()];
        match pairs.iter_mut().find(|(other, _)| in_order(other) == in_order(&pair)) {
            Some((_, may_meet)) => *may_meet |= free,
            None => pairs.push((pair, free)),
        }
    };
    let is_free = |set: &BodySet| set.motion == Motion::Free;
    let is_closed = (0..3).any(|a| around.domain.faces[a][0] != Face::Periodic);
    let walls = (is_closed.then_some(&around.domain.material).into_iter())
        .chain(around.planes.iter().map(|plane| &plane.material))
        .chain(around.parts.iter().map(|part| &part.material))
        .chain(around.surfaces.iter().map(|surface| &surface.material));
    let walls: Vec<&String> = walls.collect();
    for (i, set) in around.bodies.iter().enumerate() {
        for other in &around.bodies[i..] {
            add(&set.material, &other.material, is_free(set) || is_free(other));
        }
    }
    for set in around.bodies {
        for wall in &walls {
            add(&set.material, wall, is_free(set));
        }
    }
    pairs
}

/// The law of a pair, with moduli from its materials. `told` are materials without, so that each
/// is told once.
fn pair_law(
    scene: &SceneTable,
    between: [String; 2],
    written: Written,
    told: &mut BTreeSet<String>,
    findings: &mut Findings,
) -> Option<PairLaw> {
    let Written { hertz, work_of_adhesion, mut law } = written;
    if hertz {
        let [effective_modulus, effective_shear_modulus] =
            effective_moduli(scene, &between, told, findings)?;
        law.spring = match work_of_adhesion {
            None => Spring::Hertz { effective_modulus, effective_shear_modulus },
            Some(work_of_adhesion) => {
                Spring::Jkr { effective_modulus, effective_shear_modulus, work_of_adhesion }
            }
        };
    }
    Some(PairLaw { between, law })
}

/// Effective moduli of a pair: `1/E* = sum (1 - nu^2)/E`, `1/G* = sum (2 - nu)/G` with the shear
/// modulus `G = E/(2 (1 + nu))`.
fn effective_moduli(
    scene: &SceneTable,
    between: &[String; 2],
    told: &mut BTreeSet<String>,
    findings: &mut Findings,
) -> Option<[f64; 2]> {
    let mut moduli = |name: &String| {
        let table = scene.materials.get(name).cloned().unwrap_or_default();
        let at = path::join("scene.materials", name);
        for (key, is_there) in [
            ("youngs_modulus", table.youngs_modulus.is_some()),
            ("poisson_ratio", table.poisson_ratio.is_some()),
        ] {
            let key = path::join(&at, key);
            if !is_there && !findings.is_unreadable(&key) && told.insert(key.clone()) {
                let [one, two] = between;
                let message = format!(
                    "missing: the material \"{name}\" needs it, because contacts of \"{one}\" and \"{two}\" are Hertz's"
                );
                let help = format!(
                    "add it to [scene.materials.{name}], or give the pair stiffnesses in place of hertz"
                );
                findings.problem_with_help(&key, message, help);
            }
        }
        Some((table.youngs_modulus?.0, table.poisson_ratio?))
    };
    let pair = [moduli(&between[0]), moduli(&between[1])];
    let [one, two] = pair;
    let pair = [one?, two?];
    let compliance = pair.map(|(e, nu)| (1.0 - nu * nu) / e);
    let shear = pair.map(|(e, nu)| (2.0 - nu) * 2.0 * (1.0 + nu) / e);
    let effective = [compliance, shear].map(|[one, two]| 1.0 / (one + two));
    // A modulus that cannot be is a problem of its material.
    pair.iter().all(|(e, nu)| *e > 0.0 && *nu > -1.0 && *nu <= 0.5).then_some(effective)
}

fn written(
    scene: &SceneTable,
    table: &ContactTable,
    at: &str,
    findings: &mut Findings,
) -> Option<Written> {
    if let Some(law) = &table.chen {
        return chen::law(scene, table, law, at, findings).map(|law| Written {
            hertz: false,
            work_of_adhesion: None,
            law,
        });
    }
    let spring = spring(table, at, findings);
    let mut coefficient = |value: Option<f64>, key: &str| {
        value.filter(|value| findings.not_negative(*value, &path::join(at, key)))
    };
    let friction = coefficient(table.friction, "friction");
    let rolling_friction = coefficient(table.rolling_friction, "rolling_friction");
    let damping = damping(table, at, findings);
    Some(Written {
        hertz: table.hertz?,
        work_of_adhesion: table.work_of_adhesion.as_ref().map(|work| work.0),
        law: ContactLaw {
            spring: spring?,
            friction: friction?,
            rolling_friction: rolling_friction?,
            damping: damping?,
            tension: table.tension?,
        },
    })
}

/// The springs; with `hertz`, ones that are replaced when the materials are known.
fn spring(table: &ContactTable, at: &str, findings: &mut Findings) -> Option<Spring> {
    if table.friction_history == Some(false) && table.hertz == Some(true) {
        let message = "is for linear springs, and this law is Hertz's";
        findings.problem(&path::join(at, "friction_history"), message);
        return None;
    }
    if table.hertz? {
        let keys = [
            ("normal_stiffness", table.normal_stiffness.is_some()),
            ("tangential_stiffness", table.tangential_stiffness.is_some()),
        ];
        for (key, _) in keys.iter().filter(|(_, is_there)| *is_there) {
            let message = "found hertz = true too, which takes its stiffness from the materials";
            findings.problem(&path::join(at, key), message);
        }
        if table.work_of_adhesion.is_some() {
            findings.positive(&table.work_of_adhesion, at, "work_of_adhesion")?;
        }
        return Some(Spring::Linear { normal_stiffness: 0.0, tangential_stiffness: 0.0 });
    }
    if table.work_of_adhesion.is_some() {
        let message = "goes with hertz = true, and this law has linear springs";
        findings.problem(&path::join(at, "work_of_adhesion"), message);
    }
    let normal = findings.positive(&table.normal_stiffness, at, "normal_stiffness");
    if table.friction_history == Some(false) {
        return without_history(table, at, findings)
            .then_some(Spring::LinearNoHistory { normal_stiffness: normal? });
    }
    let tangential = findings.required(&table.tangential_stiffness, at, "tangential_stiffness");
    let tangential =
        tangential.filter(|k| findings.not_negative(*k, &path::join(at, "tangential_stiffness")));
    Some(Spring::Linear { normal_stiffness: normal?, tangential_stiffness: tangential?.0 })
}

/// True if a table without history of friction has no key that needs it; a problem for each.
fn without_history(table: &ContactTable, at: &str, findings: &mut Findings) -> bool {
    let others = [
        ("tangential_stiffness", table.tangential_stiffness.is_some()),
        ("normal_damping", table.normal_damping.is_some()),
        ("tangential_damping", table.tangential_damping.is_some()),
        ("rolling_friction", table.rolling_friction.is_some_and(|rolling| rolling != 0.0)),
    ];
    let message = "found friction_history = false too, a law that has no place for it";
    let help = "leave out one of them; damping is by restitution";
    none_of(&others, at, (message, help), findings)
}

/// True if none of the keys that a law has no place for is there; a problem for each that is.
pub(super) fn none_of(
    keys: &[(&str, bool)],
    at: &str,
    (message, help): (&str, &str),
    findings: &mut Findings,
) -> bool {
    let found = keys.iter().filter(|(_, is_there)| *is_there);
    for (key, _) in found.clone() {
        findings.problem_with_help(&path::join(at, key), message, help);
    }
    found.count() == 0
}

fn damping(table: &ContactTable, at: &str, findings: &mut Findings) -> Option<Damping> {
    let dashpots = table.normal_damping.is_some() || table.tangential_damping.is_some();
    let key = path::join(at, "restitution");
    match table.restitution {
        _ if dashpots && table.hertz == Some(true) => {
            let message =
                "dashpots of fixed coefficients are for linear springs, and this law is Hertz's";
            findings.problem_with_help(at, message, "give the coefficient of restitution");
            None
        }
        Some(_) if dashpots => {
            let message = "found dashpots too, expected either restitution or normal_damping and tangential_damping";
            findings.problem(&key, message);
            None
        }
        Some(e) if e > 0.0 && e <= 1.0 => Some(Damping::Restitution(e)),
        Some(e) => {
            findings.problem(&key, format!("found {e}, expected more than 0 and at most 1"));
            None
        }
        None if dashpots => coefficients(table, at, findings),
        None => {
            let keys = ["restitution", "normal_damping", "tangential_damping"];
            if !keys.iter().any(|key| findings.is_unreadable(&path::join(at, key))) {
                findings.problem(
                    at,
                    "missing: damping, as restitution, or as normal_damping and tangential_damping",
                );
            }
            None
        }
    }
}

fn coefficients(table: &ContactTable, at: &str, findings: &mut Findings) -> Option<Damping> {
    let mut read = |value: &Option<Dashpot>, key: &str| {
        let value = findings.required(value, at, key)?;
        findings.not_negative(value, &path::join(at, key)).then_some(value.0)
    };
    let normal = read(&table.normal_damping, "normal_damping");
    let tangential = read(&table.tangential_damping, "tangential_damping");
    Some(Damping::Coefficients { normal: normal?, tangential: tangential? })
}
