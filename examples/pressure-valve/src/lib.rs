//! A spring-loaded valve with a rubber seal, beside a conduit, after Mutabaruka and Kamrin
//! (*Comput. Part. Mech.* 5, 2018).
//!
//! [`scene`] writes parts and manifests from the valve's dimensions: `tremie scene pressure-valve
//! FOLDER`. [`results`] reads a valve out of a finished run, this one or another that slides on an
//! axis: `tremie valve OUT`.

pub mod results;
pub mod scene;
