//! Defaults filled in, and the manifest written out again as it was understood.

use super::document::{
    Arrangement, AxisEntry, AxisName, BodiesTable, ComponentEntry, Document, DomainTable,
    FaceEntry, FaceName, InletTable, MaterialTable, MotionCourseEntry, MotionName, PartMotionEntry,
    PartMotionTable, PartTable, SurfaceTable,
};
use super::spec::is_lossless_by_default;
use super::{Manifest, spec};
use crate::registry::BUILT_IN;
use schemars::generate::SchemaSettings;
use std::collections::BTreeMap;
use std::path::Path;
use tremie_messages::Role;
use tremie_messages::scene::{Domain, Inlet, InputFiles, Profile, Tangential};
use tremie_messages::units::{
    Acceleration, Angle, AngularVelocity, Force, Length, Pressure, Temperature, Time, Velocity,
};

/// Frames that a run gives to observers unless told otherwise.
const FRAMES: f64 = 200.0;
/// Steps in which the section of a surface is turned unless told otherwise: its polygons have a
/// radius that is 0.1 % off at most.
const SECTORS: u32 = 60;

impl Manifest {
    /// The manifest as it was understood, in TOML: overrides and defaults filled in, all in SI
    /// units. It reads back as an equal [`super::Spec`]. Numbers of threads stay open where they
    /// were, because they belong to the machine and change no result.
    pub fn resolved(&self) -> String {
        text_of(&self.document)
    }

    /// The same with the places of copies in the folder of a run instead of the files that it names.
    pub fn with_copies(&self) -> String {
        let (files, mut document) = (self.input_files(), self.document.clone());
        for path in document.paths() {
            *path = files.place(path).unwrap_or(path).to_string();
        }
        text_of(&document)
    }

    /// The files that the manifest names: those of the scene as components know it, and those of shapes.
    pub fn input_files(&self) -> InputFiles {
        let mut files = self.spec.scene.input_files();
        let shapes = self.document.scene.shapes.iter();
        shapes.filter_map(|shape| shape.file.as_ref()).for_each(|file| files.add(file));
        files
    }
}

/// A document in TOML.
fn text_of(document: &Document) -> String {
    // Plain tables, strings and finite numbers: TOML has a form for each of them.
    toml::to_string(document).expect("a manifest that was read can be written")
}

/// The JSON schema of manifests, with the settings of the built-in components.
pub(super) fn schema() -> serde_json::Value {
    use serde_json::{Value, json};
    let mut generator = SchemaSettings::draft2020_12().into_generator();
    let mut schema = Value::from(generator.root_schema_for::<Document>());
    drop_null(&mut schema, false);
    let settings: serde_json::Map<_, _> = (BUILT_IN.iter())
        .map(|component| (component.name.to_string(), (component.settings)(&mut generator).into()))
        .collect();
    let mut settings = json!({ "properties": settings, "$defs": generator.take_definitions(true) });
    // Of settings, no description tells the default.
    drop_null(&mut settings, true);
    schema["properties"]["settings"]["properties"] = settings["properties"].take();
    if let (Value::Object(all), Value::Object(more)) =
        (&mut schema["$defs"], settings["$defs"].take())
    {
        for (name, definition) in more {
            all.entry(name).or_insert(definition);
        }
    }
    schema
}

/// A key that may be left out is not one that may be null: TOML has no null.
fn drop_null(schema: &mut serde_json::Value, keep_defaults: bool) {
    use serde_json::Value;
    match schema {
        Value::Array(items) => items.iter_mut().for_each(|item| drop_null(item, keep_defaults)),
        Value::Object(map) => {
            if let Some(Value::Array(types)) = map.get_mut("type") {
                types.retain(|name| name != "null");
                if let [only] = types.as_slice() {
                    let only = only.clone();
                    map.insert("type".into(), only);
                }
            }
            if let Some(Value::Array(options)) = map.get_mut("anyOf") {
                options.retain(|option| option.get("type") != Some(&Value::from("null")));
            }
            // Defaults of the manifest stand in the descriptions; those that serde knows are only
            // "nothing".
            if !keep_defaults || map.get("default") == Some(&Value::Null) {
                map.remove("default");
            }
            map.values_mut().for_each(|value| drop_null(value, keep_defaults));
        }
        _ => {}
    }
}

impl Document {
    /// Fills in what the user left open. Paths of files are relative to `folder`.
    pub(super) fn fill(&mut self, folder: &Path) {
        self.fill_run();
        self.fill_scene();
        self.paths().for_each(|path| make_absolute(path, folder));
        for (name, entry) in &mut self.components {
            fill_component(name, entry);
        }
        for stop in &mut self.stop_when {
            stop.after.get_or_insert(Time(0.0));
            stop.hold.get_or_insert(Time(0.0));
        }
    }

    /// Paths of the files that it names.
    fn paths(&mut self) -> impl Iterator<Item = &mut String> {
        let scene = &mut self.scene;
        let of_parts = scene.parts.iter_mut().filter_map(|part| part.file.as_mut());
        let of_surfaces = scene.surfaces.iter_mut().filter_map(|surface| surface.table.as_mut());
        let of_shapes = scene.shapes.iter_mut().filter_map(|shape| shape.file.as_mut());
        of_parts.chain(of_surfaces).chain(of_shapes)
    }

    fn fill_run(&mut self) {
        let run = &mut self.run;
        run.schedule.get_or_insert_default();
        run.deadline.get_or_insert(Time(30.0));
        run.seed.get_or_insert(1);
        self.outputs.record.get_or_insert(true);
        self.outputs.messages.get_or_insert(false);
        if let Some(until) = run.until.filter(|until| until.0 > 0.0) {
            self.outputs.frames.get_or_insert(Time(until.0 / FRAMES));
        }
    }

    fn fill_scene(&mut self) {
        let scene = &mut self.scene;
        scene.gravity.get_or_insert([Acceleration(0.0); 3]);
        // First, because planes, parts and surfaces take over the domain's material.
        fill_domain(&mut scene.domain);
        if let Some(fluid) = &mut scene.fluid {
            fluid.acceleration.get_or_insert([Acceleration(0.0); 3]);
            fluid.velocity.get_or_insert([Velocity(0.0); 3]);
            fluid.pressure.get_or_insert(Pressure(0.0));
            if let Some(gas) = &mut fluid.gas {
                // Those of air.
                gas.temperature.get_or_insert(Temperature(293.15));
                gas.heat_ratio.get_or_insert(1.4);
                gas.prandtl.get_or_insert(0.72);
                gas.sutherland.get_or_insert(Temperature(110.4));
            }
        }
        for plane in &mut scene.planes {
            plane.material = plane.material.take().or_else(|| scene.domain.material.clone());
        }
        for part in &mut scene.parts {
            part.material = part.material.take().or_else(|| scene.domain.material.clone());
            fill_part(part);
        }
        for hopper in &mut scene.hoppers {
            hopper.material = hopper.material.take().or_else(|| scene.domain.material.clone());
        }
        for surface in &mut scene.surfaces {
            surface.material = surface.material.take().or_else(|| scene.domain.material.clone());
            fill_surface(surface);
        }
        for set in &mut scene.bodies {
            fill_bodies(set, self.run.seed, &scene.materials);
        }
        for inlet in &mut scene.inlets {
            fill_inlet(inlet, self.run.seed, &scene.materials);
        }
        for profile in &mut scene.profiles {
            profile.from.get_or_insert(Time(0.0));
            profile.velocity.get_or_insert_default();
        }
        for law in &mut scene.contacts {
            law.hertz.get_or_insert(false);
            law.friction.get_or_insert(if law.chen.is_some() { 0.3 } else { 0.0 });
            law.friction_history.get_or_insert(true);
            law.rolling_friction.get_or_insert(0.0);
            law.tension.get_or_insert(law.chen.is_some());
            if let Some(chen) = &mut law.chen {
                chen.gap.get_or_insert(Length(0.0));
                chen.theta.get_or_insert(0.01);
                chen.alpha.get_or_insert(0.4);
                chen.psi.get_or_insert(0.3);
                chen.tangential.get_or_insert(Tangential::Spring);
            }
        }
    }
}

fn fill_domain(domain: &mut DomainTable) {
    domain.origin.get_or_insert([Length(0.0); 3]);
    domain.material.get_or_insert_with(|| Domain::MATERIAL.into());
    for axis in [&mut domain.x, &mut domain.y, &mut domain.z] {
        let AxisEntry::Sides(sides) = axis.get_or_insert(AxisEntry::Both(FaceName::Wall)) else {
            continue;
        };
        for face in [&mut sides.lower, &mut sides.upper] {
            let face = face.get_or_insert(FaceEntry::Name(FaceName::Wall));
            if let FaceEntry::Table(table) = face
                && table.velocity.is_some()
            {
                table.profile.get_or_insert(Profile::Uniform);
            }
        }
    }
}

fn fill_part(part: &mut PartTable) {
    part.position.get_or_insert([Length(0.0); 3]);
    part.cavity.get_or_insert(false);
    let motion = part.motion.get_or_insert(PartMotionEntry::Name(MotionName::Fixed));
    if let PartMotionEntry::Table(PartMotionTable { slider: Some(slider) }) = motion {
        slider.lift.get_or_insert(Length(0.0));
        slider.velocity.get_or_insert(Velocity(0.0));
        slider.force.get_or_insert(Force(0.0));
    }
    fill_course(&mut part.course);
}

fn fill_surface(surface: &mut SurfaceTable) {
    surface.position.get_or_insert([Length(0.0); 3]);
    surface.sectors.get_or_insert(SECTORS);
    surface.start.get_or_insert(Length(0.0));
}

/// The resolved manifest is read back from another folder.
fn make_absolute(file: &mut String, folder: &Path) {
    let full = folder.join(&*file);
    *file = std::path::absolute(&full).unwrap_or(full).to_string_lossy().into_owned();
}

fn fill_bodies(
    set: &mut BodiesTable,
    seed: Option<u64>,
    materials: &BTreeMap<String, MaterialTable>,
) {
    set.motion.get_or_insert(MotionName::Free);
    set.material = set.material.take().or_else(|| set.name.clone());
    let material = set.material.as_ref().and_then(|name| materials.get(name));
    // Of a wrong density its material is told, not each set of it.
    let density = material.and_then(|material| material.density).filter(|density| density.0 > 0.0);
    set.density = set.density.or(density);
    let listed = [&mut set.spheres, &mut set.cylinders];
    for sphere in listed.into_iter().flatten().flatten() {
        sphere.velocity.get_or_insert([Velocity(0.0); 3]);
        sphere.angular_velocity.get_or_insert([AngularVelocity(0.0); 3]);
    }
    for body in set.polyhedra.iter_mut().flatten() {
        body.velocity.get_or_insert([Velocity(0.0); 3]);
        body.angular_velocity.get_or_insert([AngularVelocity(0.0); 3]);
    }
    for body in set.prisms.iter_mut().flatten() {
        body.velocity.get_or_insert([Velocity(0.0); 3]);
        body.angular_velocity.get_or_insert([AngularVelocity(0.0); 3]);
        body.turn.get_or_insert(Angle(0.0));
    }
    if let Some(lattice) = &mut set.lattice {
        lattice.arrangement.get_or_insert(Arrangement::Hexagonal);
        lattice.normal.get_or_insert(AxisName::Z);
    }
    if let (Some(packing), Some(seed)) = (&mut set.packing, seed) {
        packing.seed.get_or_insert(seed);
    }
    fill_course(&mut set.course);
}

fn fill_inlet(
    inlet: &mut InletTable,
    seed: Option<u64>,
    materials: &BTreeMap<String, MaterialTable>,
) {
    if inlet.bodies.is_none() {
        inlet.material = inlet.material.take().or_else(|| inlet.name.clone());
        let material = inlet.material.as_ref().and_then(|name| materials.get(name));
        let density = material.and_then(|material| material.density);
        inlet.density = inlet.density.or(density.filter(|density| density.0 > 0.0));
    }
    inlet.tries.get_or_insert(Inlet::TRIES);
    if let Some(seed) = seed {
        inlet.seed.get_or_insert(seed);
    }
}

fn fill_course(course: &mut Option<MotionCourseEntry>) {
    let Some(MotionCourseEntry::Points(points)) = course else { return };
    for point in points {
        point.velocity.get_or_insert([Velocity(0.0); 3]);
        point.angular_velocity.get_or_insert([AngularVelocity(0.0); 3]);
    }
}

fn fill_component(name: &str, entry: &mut ComponentEntry) {
    let mut table = entry.table();
    if table.role.is_none() {
        table.role = role_by_name(name);
    }
    if let Some(program) = &table.program
        && table.role == Some(Role::Observer)
    {
        table.lossless.get_or_insert(is_lossless_by_default(spec::stem(program)));
    }
    *entry = ComponentEntry::Table(table);
}

/// Role of a component, where its name says it.
fn role_by_name(name: &str) -> Option<Role> {
    let of_physics = Role::PHYSICS.into_iter().find(|role| role.name() == name);
    let is_observer = matches!(name, "viewer" | "recorder" | "fields" | "profiles");
    of_physics.or(is_observer.then_some(Role::Observer))
}
