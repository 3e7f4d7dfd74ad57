//! Streams a Tremie run into Rerun.
//!
//! [`Viewer`] is an observer: it takes frames of a run and shows them so that a physicist sees the
//! run without touching a setting. What is drawn, by entity:
//!
//! | entity | content | when |
//! | --- | --- | --- |
//! | `scene/domain/..` | edges of the box, walls, open faces (blue: velocity, orange: pressure), inner planes | static |
//! | `scene/bodies/<set>` | spheres of a body set, coloured by speed, grey if fixed; polyhedra, in a colour of the set | each frame |
//! | `scene/cuts/<component>/<name>` | a cut through the fluid, coloured by speed; solid nodes grey | shape static, colours each frame |
//! | `scene/cuts/<component>/<name>/arrows` | velocity on a readable number of its nodes | each frame |
//! | `scene/streamlines/<component>/<volume>` | streamlines of the moment, coloured by speed | each frame |
//! | `scene/isosurfaces/<component>/<volume>/..` | surfaces of equal speed or pressure, where asked for | each frame |
//! | `scene/parts/<name>` | a rigid part, half transparent where it stands still | shape static, pose where it moves |
//! | `scene/rubber/<name>` | a deformable surface, coloured by equivalent shear strain | triangles now and then, the rest each frame |
//! | `legend/speed`, `legend/strain`, `legend/solid_fraction` | colour scales and their numbers | when a scale changes |
//! | `signals/<component>/<name>` | watched scalars, one plot per component and unit; mass flow rates of grains through sections as means since the frame before | each frame |
//! | `scene/loads/<kind>` | loads on bodies as arrows: of the fluid, of contacts | each frame |
//! | `coupling/schedule` | who waits for whom, as boxes and arrows | static |
//! | `coupling/window`, `coupling/time`, `coupling/windows_per_second` | wall time of the components | each frame |
//! | `coupling/impulse` | impulse that the fluid delivered and the grains received | each frame |
//! | `coupling/followed/<id>` | loads on bodies that the user named | each frame |
//! | `log` | the run's log | each line |
//! | `about` | domain, fluid, bodies and schedule in words | static |
//! | `about/signals` | what the signals mean | static |
//!
//! Timelines are `sim_time` (simulated seconds, shown first) and `window` (coupling windows). No
//! wall clock enters, but for the wall time that components take, in the tab "Coupling".
//!
//! **Forces that ring** have a running mean beside them, over 16 frames, at the middle of these.
//!
//! **Colours.** Bodies and cuts share one scale of speed from zero to a round number that never
//! falls while a run goes on ([`scale::Scale`]); `max_speed` fixes it. Rubber has one of its own,
//! for the equivalent shear strain ([`tremie_messages::frame::SurfaceSample::strain`]);
//! `max_strain` fixes that. Sheets of profiles have theirs, for the solid fraction.
//!
//! **Symmetry.** Of a domain with symmetry planes, parts and rubber are drawn only as far as the
//! planes, and the eye looks in through the first of them: what is computed is a section.
//!
//! **Fields.** Streamlines, cuts along any plane ([`Parameters::slices`]) and surfaces of equal
//! speed or pressure come from a frame of the fluid's lattice, thinned to
//! [`Parameters::volume_nodes`] nodes. The cut that is seen first is the fluid's own, at full
//! resolution.
//!
//! **Where it goes.** [`Mode::Web`] serves a page and the data from this program, on loopback only;
//! [`Mode::Native`] starts an installed `rerun`; [`Mode::File`] writes a recording. After a run the
//! page is served until the [`Viewer`] is dropped; [`Session::url`] is its address.
//!
//! **No telemetry.** The crate is built without Rerun's analytics. The page's own program has them
//! compiled in, so the page is served with a content security policy that lets it speak to nobody
//! but this program.

#![warn(clippy::print_stdout, clippy::print_stderr)]

mod blueprint;
mod bodies;
mod coupling;
mod cut;
mod field;
mod flow;
mod impulse;
mod isosurface;
mod layout;
mod legend;
mod loads;
mod page;
mod parameters;
mod parts;
mod patch;
mod profiles;
mod quantity;
mod rates;
mod rubber;
mod running_mean;
pub mod scale;
mod schedule;
mod section;
mod session;
mod shade;
mod signals;
mod solids;
mod stage;
mod streamlines;
mod timings;
mod view;
mod viewer;

pub use parameters::{LoadKind, Mode, Parameters, PlaneSetting, Tab};
pub use quantity::CutQuantity;
pub use session::Session;
pub use viewer::{Viewer, run};
