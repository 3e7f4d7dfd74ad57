"""What a run left in its folder."""

from __future__ import annotations

import builtins
import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _tremie

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Frame:
    """A frame of a recording: its sender, name, window, time [s], grid and values.

    Values are arrays of their own (BODY_SAMPLE, SURFACE_SAMPLE or NODE). A cut's values have the
    shape of its grid, ``values[j, i]`` at ``origin + i * step[0] + j * step[1]``.
    """

    sender: str
    name: str
    window: int
    time: float
    grid: dict[str, Any] | None
    values: np.ndarray


class Results:
    """The folder of a run, finished or not."""

    def __init__(self, folder: str | os.PathLike[str]):
        self.folder = Path(folder)
        if not self.folder.is_dir():
            raise FileNotFoundError(f"{self.folder} is no folder of a run")

    def __repr__(self) -> str:
        return f"Results({str(self.folder)!r})"

    @cached_property
    def signals(self) -> pd.DataFrame:
        """Signals over time [s]: a column ``component.name`` each; ``attrs["units"]`` has the units."""
        # It takes half a second, which components need not wait for.
        import pandas as pd

        times, columns, units, cut = _tremie.read_signals(self.folder / "signals.csv")
        frame = pd.DataFrame(columns, index=pd.Index(times, name="time"))
        frame.attrs["units"] = units
        if cut:
            frame.attrs["cut"] = cut
        return frame

    @cached_property
    def manifest(self) -> dict[str, Any]:
        """The manifest of the run, all defaults included; its files are told from the run's `folder`."""
        return _tremie.read_toml(self._text("manifest.toml"))

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The run's summary: how it ended, versions, times, resolution, findings."""
        return json.loads(self._text("summary.json"))

    @cached_property
    def log(self) -> list[dict[str, Any]]:
        """Lines of the log."""
        return [json.loads(line) for line in self._text("log.jsonl").splitlines() if line]

    def bodies(self) -> Iterator[Frame]:
        """Frames of all bodies, in order of time, from the recording."""
        return self._frames("bodies")

    def surfaces(self) -> Iterator[Frame]:
        """Frames of the vertices of deformable surfaces."""
        return self._frames("surfaces")

    def slices(self, name: str | None = None) -> Iterator[Frame]:
        """Frames of cuts, or of the cut of that name."""
        return (each for each in self._frames("slice") if name in (None, each.name))

    def _frames(self, kind: str) -> Iterator[Frame]:
        for _, sender, name, window, time, grid, values in _tremie.Frames(self._recording(), kind):
            if grid is not None:
                across, up = grid["count"]
                values = values.reshape(up, across)
            yield Frame(sender, name, window, time, grid, values)

    def _recording(self) -> Path:
        found = sorted(self.folder.glob("*.mcap"))
        if not found:
            raise FileNotFoundError(
                f"{self.folder} has no recording; add a recorder to the manifest: "
                'recorder = { program = "recorder", role = "observer", lossless = true } '
                "in [components]"
            )
        return found[0]

    def _text(self, name: str) -> str:
        with builtins.open(self.folder / name, encoding="utf-8") as file:
            return file.read()


def open(folder: str | os.PathLike[str]) -> Results:
    """Opens the folder of a run, finished or not."""
    return Results(folder)
