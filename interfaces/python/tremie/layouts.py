"""Layouts of the messages, as types of NumPy. Their fields are those of the same names in Rust."""

from enum import IntEnum

from ._tremie import layouts

_LAYOUTS = layouts()

#: Pose and velocity of a body: id, position [m], orientation (x, y, z, w), velocity [m/s],
#: angular_velocity [rad/s].
BODY_STATE = _LAYOUTS["body_state"]
#: Load on a body: id, force [N], torque about its reference point [N m].
LOAD = _LAYOUTS["load"]
#: A body that appears or disappears: id, kind, shape, motion, set, mass [kg], size [m], table.
BODY_EVENT = _LAYOUTS["body_event"]
#: A body as an observer sees it: the state, and radius [m], mass [kg], set, shape, motion, part.
BODY_SAMPLE = _LAYOUTS["body_sample"]
#: A vertex of a deformable surface: position [m], velocity [m/s], strain [1].
SURFACE_SAMPLE = _LAYOUTS["surface_sample"]
#: A node of a cut: velocity [m/s], pressure [Pa], fill [1], solid, density [kg/m3], level.
NODE = _LAYOUTS["node"]
#: A bin of a profile of grains.
PROFILE_BIN = _LAYOUTS["profile_bin"]


class Kind(IntEnum):
    """Kinds of events."""

    ADDED = 1
    REMOVED = 2


class Shape(IntEnum):
    """Shapes of bodies. A sphere's size is (radius, 0, 0)."""

    SPHERE = 1
    PART = 2
    POLYHEDRON = 3
    CYLINDER = 4


class Motion(IntEnum):
    """Motions of bodies."""

    FREE = 0
    FIXED = 1
    PRESCRIBED = 2
    SLIDER = 3
