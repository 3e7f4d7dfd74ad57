"""Runs from Python, their errors and their results."""

import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import tremie

from conftest import FLUID, ROOT

SHORT = ROOT / "examples" / "settling-sphere" / "short.toml"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A finished run with bodies, cuts and signals."""
    out = tmp_path_factory.mktemp("run") / "out"
    return tremie.run(SHORT, set={"scene.fluid.viscosity": "0.1 Pa s"}, until="0.1 s", out=out)


def test_signals_are_a_table_over_time(run):
    speed = run.signals["grains.body0_vz"]
    assert speed.index.name == "time" and speed.index[-1] == pytest.approx(0.1, rel=0.02)
    assert speed.iloc[-1] < -0.01
    assert run.signals.attrs["units"]["grains.body0_vz"] == "m/s"


def test_the_manifest_has_what_was_set(run):
    assert run.manifest["scene"]["fluid"]["viscosity"] == "0.1 Pa s"
    assert run.summary["windows"] > 0 or "windows" in str(run.summary)


def test_frames_of_a_recording_are_arrays(tmp_path):
    found = tremie.run(FLUID, until="50 ms", out=tmp_path / "out")
    frames = list(found.bodies())
    assert [frame.window for frame in frames] == sorted({frame.window for frame in frames})
    first, last = frames[0], frames[-1]
    assert first.values.dtype == tremie.BODY_SAMPLE
    assert np.all(last.values["position"][:, 2].mean() < first.values["position"][:, 2].mean())
    np.testing.assert_array_equal(first.values["id"], last.values["id"])


def test_cuts_have_the_shape_of_their_grid(tmp_path):
    found = tremie.run(
        ROOT / "examples" / "dam-break", set={"settings.fluid-pic.cell": "50 mm"}, until="20 ms",
        out=tmp_path / "out",
    )
    cuts = list(found.slices("velocity"))
    assert cuts and cuts[0].values.shape == tuple(reversed(cuts[0].grid["count"]))
    assert cuts[-1].values["velocity"].shape[-1] == 3


def test_a_typing_error_raises_the_programs_own_text():
    with pytest.raises(tremie.RunError) as error:
        tremie.run(SHORT, set={"scene.fluid.viscosty": "0.1 Pa s"})
    assert error.value.code == 2
    assert 'unknown key "viscosty"' in str(error.value)
    assert 'did you mean "viscosity"?' in str(error.value)


def test_a_missing_manifest_and_a_missing_folder_are_said(tmp_path):
    with pytest.raises(tremie.RunError, match="nowhere"):
        tremie.run(tmp_path / "nowhere.toml")
    with pytest.raises(FileNotFoundError, match="nowhere"):
        tremie.open(tmp_path / "nowhere")
    (tmp_path / "empty").mkdir()
    with pytest.raises(FileNotFoundError, match="recording"):
        next(tremie.open(tmp_path / "empty").bodies())
    with pytest.raises(FileNotFoundError, match="signals.csv"):
        tremie.open(tmp_path / "empty").signals


def test_quantities_are_read_with_their_units():
    assert tremie.quantity("0.3 mm", "length") == pytest.approx(3e-4)
    with pytest.raises(ValueError, match='expected a length with a unit, as "0.3 mm"'):
        tremie.quantity("0.3", "length")
    with pytest.raises(ValueError, match="no kind of quantity"):
        tremie.quantity("0.3 mm", "width")


def test_ctrl_c_ends_a_run_in_order(tmp_path):
    """The signal comes to the process of Python alone, which passes it on."""
    out = tmp_path / "out"
    text = f"import tremie; tremie.run({str(FLUID)!r}, until='100 s', out={str(out)!r})"
    # A shell that starts a command in the background has it ignore the signal, and all that it starts.
    heed = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)
    command = [sys.executable, "-c", text]
    child = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=heed)
    deadline = time.monotonic() + 60

    def rows():
        table = out / "signals.csv"
        return table.read_bytes().count(b"\n") if table.exists() else 0

    # A run that is ended before its first window leaves nothing.
    while rows() < 3 and time.monotonic() < deadline:
        time.sleep(0.1)
    child.send_signal(signal.SIGINT)
    _, errors = child.communicate(timeout=60)
    assert "KeyboardInterrupt" in errors
    assert "interrupted" in (out / "summary.json").read_text()


def test_the_program_is_whole(tremie_program):
    assert tremie_program("--help").stdout.startswith("Co-simulation")
    assert "fluid-lbm" in tremie_program("components").stdout
    wrong = tremie_program("rum")
    assert wrong.returncode == 2 and "run" in wrong.stderr
