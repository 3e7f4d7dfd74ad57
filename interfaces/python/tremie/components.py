"""Components: classes that play a role in a run, a process each."""

from __future__ import annotations

import dataclasses
import os
import sys
from dataclasses import dataclass, field
from typing import Any, ClassVar, NoReturn

import numpy as np

from . import _tremie
from .layouts import BODY_EVENT, Kind, Motion, Shape


class Problem(ValueError):
    """A fault of a user's input: the manifest's key, what was found and expected, and a remedy.

    ``key`` is the path in the manifest, as ``scene.fluid.viscosity``; a key of the component's own
    table begins with ``@``, as ``@cell``.
    """

    def __init__(self, key: str, message: str, help: str | None = None):
        super().__init__(f"{key}: {message}" + (f" ({help})" if help else ""))
        self.key, self.message, self.help = key, message, help


class Problems(ValueError):
    """Several problems at once, so that a user can mend them all."""

    def __init__(self, problems: list[Problem]):
        super().__init__("; ".join(map(str, problems)))
        self.problems = list(problems)


def _problems_of(error: BaseException) -> list[tuple[str, str, str | None]] | None:
    """Problems that an exception says; none if it says something else."""
    match error:
        case Problem():
            return [(error.key, error.message, error.help)]
        case Problems():
            return [(each.key, each.message, each.help) for each in error.problems]
    return None


@dataclass(frozen=True)
class Signal:
    """A scalar that a component reports: name in snake case, SI unit (1 if none), meaning."""

    name: str
    unit: str = "1"
    meaning: str = ""


@dataclass(frozen=True)
class Slice:
    """A cut that a fluid can show: name, and number of nodes."""

    name: str
    nodes: int


@dataclass
class Description:
    """What a component says of itself before a run is planned."""

    #: Longest step that is stable and accurate [s]; None if it takes any.
    step: float | None = None
    #: What keeps the step from being longer, in a few words.
    step_limit: str = ""
    #: Number of bodies that grains bring.
    bodies: int = 0
    #: Scalars that it reports.
    signals: list[Signal] = field(default_factory=list)
    #: Cuts that it can show.
    slices: list[Slice] = field(default_factory=list)
    #: Lines for the plan.
    notes: list[str] = field(default_factory=list)
    #: Doubtful things, with the remedy.
    warnings: list[str] = field(default_factory=list)
    #: Resolution, for the summary.
    resolution: dict[str, float] = field(default_factory=dict)
    #: Memory that it expects to take [bytes]; 0 if it does not know.
    memory: int = 0


@dataclass(frozen=True)
class Moment:
    """When a frame was taken: coupling window, and simulated time [s]."""

    window: int
    time: float


class Setup:
    """A run as a component knows it.

    ``scene`` and ``parameters`` are dictionaries: the scene in SI units, the component's own table as
    it stands in the manifest. ``quantity("1 mm", "length")`` reads a value with its unit.
    """

    def __init__(self, hello: dict[str, Any], assignment: dict[str, Any] | None, goes_on: bool):
        #: Scene of the run, as the manifest's keys, in SI units.
        self.scene: dict[str, Any] = hello["scene"]
        #: The component's own table in the manifest.
        self.parameters: dict[str, Any] = hello["parameters"]
        #: Its name in this run.
        self.component: str = hello["component"]
        #: Threads that it may use.
        self.threads: int = hello["threads"]
        #: Folder of the run's outputs.
        self.output: str = hello["output"]
        #: The run goes on from a checkpoint, with the outputs of before.
        self.goes_on = goes_on
        #: Everything of the assignment; None while the component only describes itself.
        self.assignment = assignment

    @property
    def step(self) -> float:
        """Length of a substep [s]; there from ``__init__`` of the component on."""
        return self._assigned()["step"]

    @property
    def substeps(self) -> int:
        """Substeps in a coupling window."""
        return self._assigned()["substeps"]

    @property
    def window(self) -> float:
        """Length of a coupling window [s]."""
        clock = self._assigned()["clock"]
        return clock["tick"] * clock["ticks_per_window"]

    def _assigned(self) -> dict[str, Any]:
        if self.assignment is None:
            raise RuntimeError("steps are known once the component is made, not in describe")
        return self.assignment

    def known_parameters(self, *names: str) -> dict[str, Any]:
        """The component's table, if it has no other keys than these.

        Raises Problems for any other key.
        """
        unknown = [key for key in self.parameters if key not in names]
        if unknown:
            valid = "valid keys: " + ", ".join(names) if names else "it takes none"
            raise Problems([Problem("@" + key, "unknown key", valid) for key in unknown])
        return self.parameters


class _Component:
    #: Role that the class plays.
    role: ClassVar[str]
    #: Name and version, for the log. The name also tells states of checkpoints from another's.
    program: ClassVar[str] = ""
    #: Version of the state that save_state gives; None if the component cannot go on from one.
    state_version: ClassVar[int | None] = None

    def __init__(self, setup: Setup):
        """Makes the component: ``setup`` has the assigned steps now."""

    @classmethod
    def describe(cls, setup: Setup) -> Description:
        """Checks scene and parameters, and says what the component needs. Cheap.

        Raise Problem or Problems for wrong input.
        """
        return Description()

    @classmethod
    def _describe(cls, setup: Setup) -> dict[str, Any]:
        told = cls.describe(setup)
        if not isinstance(told, Description):
            raise TypeError(f"describe gave {type(told).__name__}, expected tremie.Description")
        whole = dataclasses.asdict(told)
        for signal in whole["signals"]:
            signal["sampled"] = False
        return whole | {
            "interface": 0,
            "program": "",
            "work": "",
            "state": cls.state_version,
            "watches": cls._watches(),
        }

    @classmethod
    def _watches(cls) -> dict[str, Any]:
        return {}

    def save_state(self) -> dict[str, Any]:
        """Everything that comes next depends on: arrays of NumPy, and what JSON can hold.

        Called at a checkpoint where ``state_version`` is set.
        """
        raise NotImplementedError(f"{type(self).__name__} has a state_version and no save_state")

    def restore_state(self, state: dict[str, Any]) -> None:
        """Puts back what save_state gave, into a component made anew from the same scene."""
        raise NotImplementedError(f"{type(self).__name__} has a state_version and no restore_state")


class Fluid(_Component):
    """A fluid: takes poses of bodies, gives the loads on them.

    Arrays are views of the memory that the processes share. They are valid during the call alone:
    keep copies. ``bodies`` and ``loads`` have the same bodies in the same order (ascending ids).
    """

    role = "fluid"
    #: Bodies may be polyhedra. A scene with some is refused otherwise.
    takes_polyhedra: ClassVar[bool] = False

    def events(self, events: np.ndarray) -> None:
        """Bodies that appear or disappear (BODY_EVENT), effective with the next bodies."""

    def start(self, bodies: np.ndarray, loads: np.ndarray) -> None:
        """Looks at the bodies (BODY_STATE) at time zero, lets no time pass, writes the loads (LOAD)."""
        self.advance(0, bodies, loads)

    def advance(self, substeps: int, bodies: np.ndarray, loads: np.ndarray) -> None:
        """Advances through a window, and writes the mean load on each body, buoyancy included."""
        raise NotImplementedError("a fluid needs advance")

    def signals(self) -> list[float]:
        """Values of the signals, in the order of the description."""
        return []

    def slice(self, name: str, nodes: np.ndarray) -> dict[str, Any]:
        """Fills the cut of that name (NODE), and gives its grid: origin [m], step (two vectors [m]), count."""
        raise NotImplementedError("the description has a slice, so the fluid needs the method slice")


class Grains(_Component):
    """Grains: take the loads on bodies, give their poses and the events of their lives.

    Arrays are views of the memory that the processes share. They are valid during the call alone:
    keep copies.
    """

    role = "grains"
    #: Bodies may be polyhedra. A scene with some is refused otherwise.
    takes_polyhedra: ClassVar[bool] = False

    def events(self) -> np.ndarray:
        """Bodies that appeared or disappeared at the last window's end (BODY_EVENT); at first all.

        :func:`added` and :func:`removed` make such arrays.
        """
        raise NotImplementedError("grains need events: which bodies there are")

    def state(self, bodies: np.ndarray) -> None:
        """Writes the state of all living bodies (BODY_STATE), in ascending order of their ids."""
        raise NotImplementedError("grains need state")

    def advance(self, substeps: int, loads: np.ndarray) -> None:
        """Advances through a window, each substep under the same loads (LOAD); none without a fluid."""
        raise NotImplementedError("grains need advance")

    def signals(self) -> list[float]:
        """Values of the signals, in the order of the description."""
        return []

    def _events(self) -> bytes:
        return np.ascontiguousarray(self.events(), dtype=BODY_EVENT).tobytes()


class Observer(_Component):
    """An observer: sees frames, and changes nothing. It gets what the class has methods for."""

    role = "observer"

    def bodies(self, sender: str, at: Moment, bodies: np.ndarray) -> None:
        """All bodies at one moment (BODY_SAMPLE)."""

    def surfaces(self, sender: str, at: Moment, vertices: np.ndarray) -> None:
        """All vertices of deformable surfaces (SURFACE_SAMPLE)."""

    def slice(
        self, sender: str, name: str, at: Moment, grid: dict[str, Any], nodes: np.ndarray
    ) -> None:
        """A cut through a field (NODE), with its grid: origin, step, count."""

    def volume(
        self, sender: str, name: str, at: Moment, grid: dict[str, Any], nodes: np.ndarray
    ) -> None:
        """Nodes of a lattice (NODE), with its grid: origin, step, count."""

    def profile(
        self, sender: str, name: str, at: Moment, times: dict[str, Any], bins: np.ndarray
    ) -> None:
        """A table of a profile of grains (PROFILE_BIN), with its times begin and end, and samples."""

    def signals(self, sender: str, at: Moment, values: dict[str, float]) -> None:
        """Signals of a component, by their names."""

    def log(self, at: Moment, level: str, text: str) -> None:
        """A line of the log; the level is info, warning or error."""

    def close(self, last_common_window: int) -> str | None:
        """The run is over, and every frame was delivered. Gives a note for the run's summary."""
        return None

    @classmethod
    def _watches(cls) -> dict[str, Any]:
        def has(method: str) -> bool:
            return getattr(cls, method) is not getattr(Observer, method)

        watches: dict[str, Any] = {
            "bodies": has("bodies"),
            "surfaces": has("surfaces"),
            "slices": has("slice"),
            "profiles": has("profile"),
            "signals": has("signals"),
            "log": has("log"),
        }
        if has("volume"):
            watches["volumes"] = {}
        return watches


def added(
    ids: Any, radius: Any, mass: Any, motion: Motion = Motion.FREE, set: int = 0
) -> np.ndarray:
    """Events of spheres that appear: ids, radii [m] and masses [kg], each one number or one a body."""
    ids = np.atleast_1d(np.asarray(ids, dtype=np.uint64))
    events = np.zeros(len(ids), dtype=BODY_EVENT)
    events["id"], events["kind"], events["shape"] = ids, Kind.ADDED, Shape.SPHERE
    events["motion"], events["set"], events["mass"] = motion, set, mass
    events["size"][:, 0] = radius
    return events


def removed(ids: Any) -> np.ndarray:
    """Events of bodies that disappear."""
    ids = np.atleast_1d(np.asarray(ids, dtype=np.uint64))
    events = np.zeros(len(ids), dtype=BODY_EVENT)
    events["id"], events["kind"] = ids, Kind.REMOVED
    return events


def main(component: type[_Component]) -> NoReturn:
    """Takes part in a run as ``component``; the last line of a component's file.

    What the file prints goes into the run's log.
    """
    if not (isinstance(component, type) and issubclass(component, _Component)):
        raise TypeError("main takes a class that derives from Fluid, Grains or Observer")
    if hasattr(sys.stdout, "reconfigure"):
        sys.stdout.reconfigure(line_buffering=True)
    program = component.program or os.path.basename(sys.argv[0]) or component.__name__
    code = _tremie.serve(component.role, component, program)
    sys.stdout.flush()
    sys.exit(code)
