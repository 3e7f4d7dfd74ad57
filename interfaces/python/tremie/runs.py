"""Runs of manifests, by the program that the package carries."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from . import __main__ as program
from .results import Results


class RunError(RuntimeError):
    """A run that was refused or has failed, in the program's own words. ``code`` is its exit code."""

    def __init__(self, text: str, code: int):
        super().__init__(text)
        self.code = code


def run(
    manifest: str | os.PathLike[str],
    *,
    set: Mapping[str, Any] | None = None,
    out: str | os.PathLike[str] | None = None,
    until: str | None = None,
    progress: bool | None = None,
    arguments: list[str] | None = None,
) -> Results:
    """Makes a run of a manifest, and opens its results.

    ``set`` changes values of the manifest, as ``{"scene.fluid.viscosity": "0.1 Pa s"}``; values may be
    texts, numbers, truth values or lists. ``out`` is the folder of the results; left out, the program
    chooses it. ``progress`` shows plan and progress on standard error: as a rule where that is a
    terminal. ``arguments`` are further ones of ``tremie run``.

    Raises RunError, with the text that the program prints. A KeyboardInterrupt ends the run in order.
    """
    words = ["run", os.fspath(manifest)]
    if out is not None:
        words += ["--out", os.fspath(out)]
    if until is not None:
        words += ["--until", until]
    words += [*_changes(set), *(arguments or [])]
    folder = _carry_out(words, sys.stderr.isatty() if progress is None else progress)
    return Results(folder if folder else Path(out if out is not None else "."))


def check(
    manifest: str | os.PathLike[str], *, set: Mapping[str, Any] | None = None
) -> str:
    """Checks a manifest completely, and gives the plan and the findings as text.

    Raises RunError, with the text that the program prints.
    """
    words = ["check", os.fspath(manifest), *_changes(set)]
    done = subprocess.run(_command(words), capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RunError(done.stderr.strip() or done.stdout.strip(), done.returncode)
    return done.stdout


def _changes(set: Mapping[str, Any] | None) -> list[str]:
    """Changes of the manifest, as words of a command line."""
    changes = ((key, _toml_value(value)) for key, value in (set or {}).items())
    return [word for key, value in changes for word in ("--set", f"{key}={value}")]


def _command(words: list[str]) -> list[str]:
    return [sys.executable, os.path.abspath(program.__file__), *words]


def _carry_out(words: list[str], progress: bool) -> Path | None:
    """Runs the program; gives the folder of the results."""
    child = subprocess.Popen(
        _command(words if progress else [*words, "--quiet"]),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        # Ctrl-C comes to this process alone, which passes it on once.
        start_new_session=True,
    )
    said: list[str] = []
    try:
        assert child.stderr is not None
        for line in child.stderr:
            said.append(line.rstrip())
            if progress:
                sys.stderr.write(line)
        code = child.wait()
    finally:
        if child.poll() is None:
            child.send_signal(signal.SIGINT)
            child.communicate()
    if code != 0:
        raise RunError(_error_of(said) or f"tremie ended with code {code}", code)
    return next((Path(each) for each in map(_outputs_of, reversed(said)) if each), None)


def _error_of(said: list[str]) -> str:
    """What the program said from its first error on; else everything."""
    first = next((k for k, line in enumerate(said) if line.startswith("error")), 0)
    return "\n".join(said[first:]).strip()


def _outputs_of(line: str) -> str | None:
    """Folder of the results, in the program's last line."""
    _, found, folder = line.rpartition("outputs in ")
    return folder.split("; ")[0] if found else None


def _toml_value(value: Any) -> str:
    """A value as `--set` takes it."""
    match value:
        case bool():
            return "true" if value else "false"
        case str() | int() | float():
            return json.dumps(value)
        case list() | tuple():
            return "[" + ", ".join(map(_toml_value, value)) + "]"
        case Mapping():
            return "{ " + ", ".join(f"{json.dumps(k)} = {_toml_value(v)}" for k, v in value.items()) + " }"
    raise TypeError(f"a manifest has no values of type {type(value).__name__}: {value!r}")
