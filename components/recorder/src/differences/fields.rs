//! Names of the numbers that values of messages and frames hold.

use super::Number;
use tremie_messages::frame::{BodySample, SliceNode, SurfaceSample};
use tremie_messages::{BodyEvent, BodyState, FacetLoad, Load, PortState, SurfaceVertex};

/// A value with named numbers.
pub(super) trait Fields {
    /// What tells it from the others of its list; `place` is its index.
    fn key(&self, place: usize) -> u64;
    /// Its name, by its key.
    fn name(key: u64) -> String;
    /// Pushes its numbers with their names, always the same.
    fn fields(&self, to: &mut Vec<(&'static str, Number)>);
}

fn vector(names: [&'static str; 3], values: [f64; 3], to: &mut Vec<(&'static str, Number)>) {
    to.extend(names.into_iter().zip(values.map(Number::Real)));
}

const POSITION: [&str; 3] = ["position.x", "position.y", "position.z"];
const VELOCITY: [&str; 3] = ["velocity.x", "velocity.y", "velocity.z"];
const FORCE: [&str; 3] = ["force.x", "force.y", "force.z"];

impl Fields for BodyState {
    fn key(&self, _: usize) -> u64 {
        self.id
    }
    fn name(key: u64) -> String {
        format!("body {key}")
    }
    fn fields(&self, to: &mut Vec<(&'static str, Number)>) {
        const TURN: [&str; 4] =
            ["orientation.x", "orientation.y", "orientation.z", "orientation.w"];
        const SPIN: [&str; 3] = ["angular_velocity.x", "angular_velocity.y", "angular_velocity.z"];
        vector(POSITION, self.position, to);
        to.extend(TURN.into_iter().zip(self.orientation.map(Number::Real)));
        vector(VELOCITY, self.velocity, to);
        vector(SPIN, self.angular_velocity, to);
    }
}

impl Fields for BodySample {
    fn key(&self, _: usize) -> u64 {
        self.state.id
    }
    fn name(key: u64) -> String {
        BodyState::name(key)
    }
    fn fields(&self, to: &mut Vec<(&'static str, Number)>) {
        self.state.fields(to);
        to.extend(
            [("radius", self.radius), ("mass", self.mass)].map(|(n, x)| (n, Number::Real(x))),
        );
        let whole = [
            ("set", self.set),
            ("shape", self.shape),
            ("motion", self.motion),
            ("part", self.part),
        ];
        to.extend(whole.map(|(name, n)| (name, Number::Whole(n.into()))));
    }
}

impl Fields for BodyEvent {
    fn key(&self, place: usize) -> u64 {
        place as u64
    }
    fn name(key: u64) -> String {
        format!("event {key}")
    }
    fn fields(&self, to: &mut Vec<(&'static str, Number)>) {
        let small = [
            ("kind", self.kind),
            ("shape", self.shape),
            ("motion", self.motion),
            ("set", self.set),
        ];
        to.push(("body", Number::Whole(self.id)));
        to.extend(small.map(|(name, n)| (name, Number::Whole(n.into()))));
        to.push(("mass", Number::Real(self.mass)));
        vector(["size.x", "size.y", "size.z"], self.size, to);
        to.push(("table", Number::Whole(self.table)));
    }
}

impl Fields for Load {
    fn key(&self, _: usize) -> u64 {
        self.id
    }
    fn name(key: u64) -> String {
        format!("body {key}")
    }
    fn fields(&self, to: &mut Vec<(&'static str, Number)>) {
        vector(FORCE, self.force, to);
        vector(["torque.x", "torque.y", "torque.z"], self.torque, to);
    }
}

impl Fields for PortState {
    fn key(&self, _: usize) -> u64 {
        u64::from(self.axis) << 32 | u64::from(self.side)
    }
    fn name(key: u64) -> String {
        let face = Self { axis: (key >> 32) as u32, side: key as u32, velocity: 0.0 };
        format!("face {face}")
    }
    fn fields(&self, to: &mut Vec<(&'static str, Number)>) {
        to.push(("velocity", Number::Real(self.velocity)));
    }
}

impl Fields for SurfaceVertex {
    fn key(&self, place: usize) -> u64 {
        place as u64
    }
    fn name(key: u64) -> String {
        format!("vertex {key}")
    }
    fn fields(&self, to: &mut Vec<(&'static str, Number)>) {
        vector(POSITION, self.position, to);
        vector(VELOCITY, self.velocity, to);
    }
}

impl Fields for SurfaceSample {
    fn key(&self, place: usize) -> u64 {
        place as u64
    }
    fn name(key: u64) -> String {
        SurfaceVertex::name(key)
    }
    fn fields(&self, to: &mut Vec<(&'static str, Number)>) {
        self.vertex.fields(to);
        to.push(("strain", Number::Real(self.strain)));
    }
}

impl Fields for FacetLoad {
    // A facet may have several loads, in the sender's order.
    fn key(&self, place: usize) -> u64 {
        place as u64
    }
    fn name(key: u64) -> String {
        format!("load {key}")
    }
    fn fields(&self, to: &mut Vec<(&'static str, Number)>) {
        to.push(("facet", Number::Whole(self.facet)));
        vector(FORCE, self.force, to);
        vector(["point.x", "point.y", "point.z"], self.point, to);
        to.push(("stiffness", Number::Real(self.stiffness)));
    }
}

impl Fields for SliceNode {
    fn key(&self, place: usize) -> u64 {
        place as u64
    }
    fn name(key: u64) -> String {
        format!("node {key}")
    }
    fn fields(&self, to: &mut Vec<(&'static str, Number)>) {
        to.extend(VELOCITY.into_iter().zip(self.velocity.map(Number::Single)));
        let more = [("pressure", self.pressure), ("fill", self.fill), ("density", self.density)];
        to.extend(more.map(|(name, x)| (name, Number::Single(x))));
        let whole = [("solid", self.solid), ("level", self.level)];
        to.extend(whole.map(|(name, n)| (name, Number::Whole(n.into()))));
    }
}
