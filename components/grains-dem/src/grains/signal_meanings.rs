//! What the signals mean, by the last part of their names.

const PLACE: &str =
    "position of a body's centre, a clump's centroid, or the origin of a part's frame";
const TURN: &str = "its orientation, a unit quaternion (x, y, z, w) from its frame to the world";
const FORCE: &str = "force of the grains on the part, fixed or moving: contacts and lubrication at the end of \
    the window; no fluid, no stops";
const WALL: &str = "force of the grains on this face of the domain at the end of the window: contacts and lubrication; no fluid";
const FLUID_FORCE: &str = "force of the fluid under which it went through the window: gauge pressure, shear, the pressure \
    in gaps, and buoyancy; no contacts";
const FLUID_TORQUE: &str = "torque of the same about the body's centre or the clump's centroid";

/// Of all grains, of those that are followed, of faces, of parts, sliders, inlets, outlets and probes.
pub const MEANINGS: &[(&str, &str)] = &[
    ("max_speed", "largest speed of a free body or a slider"),
    (
        "mean_height",
        "mean height of centres against gravity, from the domain's lowest point; 0 without gravity",
    ),
    ("kinetic_energy", "energy of translation"),
    ("rotational_energy", "energy of rotation"),
    ("potential_energy", "energy of weight, from the domain's lowest point"),
    ("elastic_energy", "energy in the springs of contacts, sliders and stops"),
    ("momentum_x", "momentum of all free bodies and sliders"),
    ("momentum_y", "momentum of all free bodies and sliders"),
    ("momentum_z", "momentum of all free bodies and sliders"),
    (
        "contacts",
        "contacts at the end of the window: between bodies, and of bodies with walls and parts",
    ),
    ("max_overlap_ratio", "largest overlap since the start over the smaller radius of its pair"),
    ("list_rebuilds", "neighbour lists made since the start"),
    ("x", PLACE),
    ("y", PLACE),
    ("z", PLACE),
    ("vx", "its velocity"),
    ("vy", "its velocity"),
    ("vz", "its velocity"),
    ("qx", TURN),
    ("qy", TURN),
    ("qz", TURN),
    ("qw", TURN),
    ("wx", "its angular velocity"),
    ("wy", "its angular velocity"),
    ("wz", "its angular velocity"),
    ("fluid_force_x", FLUID_FORCE),
    ("fluid_force_y", FLUID_FORCE),
    ("fluid_force_z", FLUID_FORCE),
    ("fluid_torque_x", FLUID_TORQUE),
    ("fluid_torque_y", FLUID_TORQUE),
    ("fluid_torque_z", FLUID_TORQUE),
    ("force_x", FORCE),
    ("force_y", FORCE),
    ("force_z", FORCE),
    ("torque_x", "torque of the same about the origin of the part's frame"),
    ("torque_y", "torque of the same about the origin of the part's frame"),
    ("torque_z", "torque of the same about the origin of the part's frame"),
    ("wall_force_x", WALL),
    ("wall_force_y", WALL),
    ("wall_force_z", WALL),
    ("lift", "travel of the part along its axis"),
    ("velocity", "velocity of the part along its axis"),
    ("spring_force", "force of the spring along the axis, negative while it closes"),
    (
        "contact_force",
        "force of the grains along the axis at the end of the window: contacts and lubrication; no fluid, no stops",
    ),
    ("stop_force", "force of the stops along the axis, positive from the lower one"),
    (
        "fluid_force",
        "force of the fluid along the axis under which it went through the window, all that fluid.PART.force_x to z hold: buoyancy too",
    ),
    ("surface_force", "force of contacts on the surfaces that the part carries, along the axis"),
    ("carrier_force", "what else acts on these surfaces along the axis: a fluid"),
    ("inserted", "grains that came since the start"),
    (
        "deficit",
        "volume that is still to come to reach the fraction; 0 where less than half a sphere lacks",
    ),
    ("mass_inserted", "mass of grains that came since the start"),
    ("removed", "grains that went since the start"),
    ("mass_removed", "mass of grains that went since the start"),
    ("bodies", "grains that are there"),
    (
        "mass_flow_rate",
        "mass of grains that passes in a second, positive along the axis: the mean since the row before",
    ),
    (
        "crossings",
        "grains that passed since the start, less those that came back; in a clump each piece counts",
    ),
    ("mass_passed", "mass of grains that passed since the start, less what came back"),
    (
        "solid_fraction",
        "volume of grains over that of the region; overlaps in a clump count twice unless its mass is that of the union",
    ),
    ("number", "grains there"),
    ("velocity_x", "mean velocity of the grains there, by volume"),
    ("velocity_y", "mean velocity of the grains there, by volume"),
    ("velocity_z", "mean velocity of the grains there, by volume"),
    ("projected_area", "area of the ring that grains hide, seen along its axis"),
    ("area_fraction", "that area over the ring's"),
];
