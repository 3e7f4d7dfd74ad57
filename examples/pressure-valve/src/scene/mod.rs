//! Parts and manifests of the valve from its dimensions.
//!
//! Slurry comes along the conduit, turns up into the bore, lifts the valve, passes the cone and the
//! gap under the rubber ring, and leaves through the chamber above.

mod command;
mod dimensions;
mod frame;
mod grains;
mod held;
mod moving;
mod rubber;
mod text;
mod working;

pub use command::{SceneArgs, build_pressure_valve, build_safety_valve};
pub use dimensions::{Closure, Dimensions, Misfit};
pub use frame::frame;
pub use grains::Grains;
pub use held::{Steady, manifest as held};
pub use moving::{ring, steel, steel_and_ring};
pub use rubber::{Resting, specification};
pub use working::{Ring, Working, manifest as working};
