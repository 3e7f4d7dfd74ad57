"""Tremie in Python: components of runs, runs, and what they left.

Three things stand here:

* :class:`Fluid`, :class:`Grains` and :class:`Observer`: derive a class from one of them, end the file
  with ``tremie.main(YourClass)``, and name the file in a manifest. Arrays show the memory that the
  processes of a run share; nothing is copied.
* :func:`run` makes a run of a manifest, as ``tremie run`` does.
* :func:`open` reads the folder of a run: signals, frames of bodies and cuts, the manifest.

All values are in SI units and in the world frame.
"""

from ._tremie import __version__, quantity
from .components import (
    Description,
    Fluid,
    Grains,
    Moment,
    Observer,
    Problem,
    Problems,
    Setup,
    Signal,
    Slice,
    added,
    main,
    removed,
)
from .components import _problems_of as _problems_of
from .layouts import (
    BODY_EVENT,
    BODY_SAMPLE,
    BODY_STATE,
    LOAD,
    NODE,
    PROFILE_BIN,
    SURFACE_SAMPLE,
    Kind,
    Motion,
    Shape,
)
from .results import Frame, Results, open
from .runs import RunError, check, run

__all__ = [
    "BODY_EVENT",
    "BODY_SAMPLE",
    "BODY_STATE",
    "Description",
    "Fluid",
    "Frame",
    "Grains",
    "Kind",
    "LOAD",
    "Moment",
    "Motion",
    "NODE",
    "Observer",
    "PROFILE_BIN",
    "Problem",
    "Problems",
    "Results",
    "RunError",
    "SURFACE_SAMPLE",
    "Setup",
    "Shape",
    "Signal",
    "Slice",
    "__version__",
    "added",
    "check",
    "main",
    "open",
    "quantity",
    "removed",
    "run",
]
