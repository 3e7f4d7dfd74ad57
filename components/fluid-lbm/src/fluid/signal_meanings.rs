//! What the signals mean, by the last part of their names.

const FORCE: &str = "force of the fluid on the part, fixed or moving: gauge pressure, shear, the pressure in gaps, and \
    buoyancy as if fluid stood all around what of it lies in the domain (of a cavity the weight of what fills it; none along a \
    straight pipe from face to face); no contacts, nor what acts on surfaces that it carries; a mean over the window, of a fixed part in its last step";
const TORQUE: &str = "torque of the same about the origin of the part's frame";
const WALL: &str = "force of the fluid on this face of the domain in the last step: gauge pressure without its hydrostatic \
    part, shear, and the pressure in gaps; no contacts";

/// Of the lattice, of faces, of parts, of reservoirs and of probes.
pub const MEANINGS: &[(&str, &str)] = &[
    ("max_speed", "largest speed of the fluid"),
    ("max_mach", "largest Mach number of the lattice"),
    ("min_pressure", "lowest gauge pressure without its hydrostatic part, 0 if all are above"),
    ("max_pressure", "highest gauge pressure without its hydrostatic part, 0 if all are below"),
    ("links", "lattice links from the fluid into bodies"),
    ("fallback_links", "of these, those without a second fluid cell: walls half-way there"),
    ("isolated_cells", "cells that are frozen because no neighbour is fluid"),
    ("mass", "mass of the fluid"),
    ("mass_change", "its change in the last step"),
    ("mass_residual", "what of that no term of the balance accounts for: rounding"),
    ("momentum_x", "momentum of the fluid"),
    ("momentum_y", "momentum of the fluid"),
    ("momentum_z", "momentum of the fluid"),
    (
        "momentum_residual",
        "largest part of its change that no term of the balance accounts for: rounding",
    ),
    ("wall_impulse_x", "given to the fluid by the domain's walls in the last step"),
    ("wall_impulse_y", "given to the fluid by the domain's walls in the last step"),
    ("wall_impulse_z", "given to the fluid by the domain's walls in the last step"),
    ("body_impulse_x", "given to the fluid by bodies in the last step"),
    ("body_impulse_y", "given to the fluid by bodies in the last step"),
    ("body_impulse_z", "given to the fluid by bodies in the last step"),
    ("max_relaxation_time", "largest relaxation time, which a turbulence model raises"),
    ("backflow_cells", "cells at pressure faces through which fluid enters"),
    (
        "mass_owed",
        "what interpolated walls took, and moving bodies beyond their volume, and have not paid back",
    ),
    (
        "mass_lost",
        "mass that links to walls and moving bodies took since the start, beyond what bodies displaced; negative: made",
    ),
    ("mass_lost_share", "its size over the mass of the fluid"),
    ("force_x", FORCE),
    ("force_y", FORCE),
    ("force_z", FORCE),
    ("torque_x", TORQUE),
    ("torque_y", TORQUE),
    ("torque_z", TORQUE),
    ("wall_force_x", WALL),
    ("wall_force_y", WALL),
    ("wall_force_z", WALL),
    ("density", "density of the fluid in the reservoir"),
    ("pressure", "gauge pressure there, a mean over the fluid"),
    ("volume", "volume between piston and face"),
    ("piston_velocity", "velocity of the piston towards the domain"),
    ("velocity", "mean velocity through the face into the domain"),
    ("mass_entered", "mass that has entered the domain since the start"),
    ("velocity_x", "mean velocity of the fluid there"),
    ("velocity_y", "mean velocity of the fluid there"),
    ("velocity_z", "mean velocity of the fluid there"),
    ("solid_fraction", "share of the place that no fluid fills"),
    (
        "flow_rate",
        "volume of fluid that passes in a second at the row's time, positive along the axis",
    ),
    (
        "mass_flow_rate",
        "mass of fluid that crosses from cell to cell in a second, positive along the axis; mean over the time since the row before",
    ),
];
