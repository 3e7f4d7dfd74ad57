"""Components that are classes of Python, in runs with those in Rust."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import tremie

from conftest import FLUID

IDLE = '''
    import numpy as np
    import tremie

    class Water(tremie.Fluid):
        program = "water.py 1"
        {members}

    tremie.main(Water)
'''

STILL = "def advance(self, substeps, bodies, loads): loads['force'] = 0.0"


def fluid(members):
    """A file with a fluid of these methods."""
    lines = [line.strip("\n") for line in members.splitlines()]
    return IDLE.replace("{members}", "\n        ".join(lines))


GRAINS = 'fluid = "./water.py"\ngrains = "grains-dem"'.replace("\n", "\n            ")


def test_the_example_conforms(tremie_program):
    done = tremie_program("conform", FLUID / "stokes.py")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "conforms: 12 checks hold" in done.stdout


def test_the_fluid_falls_as_the_one_in_rust(minimal_fluid, tmp_path):
    """The same formulas in another order of operations: not the same bits, but nearly."""
    signals = {}
    for program in ["./stokes.py", minimal_fluid]:
        out = tmp_path / Path(program).name
        found = tremie.run(FLUID, set={"components.fluid": program}, until="50 ms", out=out)
        signals[program] = found.signals["fluid.largest_drag"]
    one, other = signals.values()
    assert one.max() > 1e-5
    np.testing.assert_allclose(one, other, rtol=1e-9)


def test_an_exception_ends_the_run_with_its_traceback(scene):
    folder = scene(
        GRAINS,
        water=fluid(
            """def advance(self, substeps, bodies, loads):
    loads["force"] = 0.0
    self.windows = getattr(self, "windows", 0) + 1
    if self.windows == 3:
        raise ArithmeticError("the pressure has no solution")"""
        ),
    )
    with pytest.raises(tremie.RunError) as error:
        tremie.run(folder, out=folder / "out")
    text = str(error.value)
    assert "ArithmeticError: the pressure has no solution" in text
    assert 'water.py", line' in text
    assert "fluid" in text and "window 2" in text


def test_wrong_input_is_said_with_the_line_of_the_manifest(scene):
    folder = scene(
        GRAINS,
        water=fluid(
            "@classmethod\ndef describe(cls, setup):\n"
            "    raise tremie.Problem('scene.fluid.density', 'is too small', 'try 1000 kg/m3')\n" + STILL
        ),
    )
    with pytest.raises(tremie.RunError) as error:
        tremie.check(folder)
    assert error.value.code == 2
    text = str(error.value)
    assert "scene.fluid.density: is too small" in text
    assert 'density = "960 kg/m3"' in text and "try 1000 kg/m3" in text


def test_an_unknown_parameter_is_named(scene):
    folder = scene(
        GRAINS + "\n            [settings.water]\n            stifness = 3",
        water=fluid(
            "@classmethod\ndef describe(cls, setup):\n"
            "    setup.known_parameters('stiffness')\n    return tremie.Description()\n" + STILL
        ),
    )
    with pytest.raises(tremie.RunError) as error:
        tremie.check(folder)
    text = str(error.value)
    assert "settings.water.stifness: unknown key" in text and "valid keys: stiffness" in text


def test_a_view_that_is_kept_ends_the_run(scene):
    members = """def advance(self, substeps, bodies, loads):
    loads["force"] = 0.0
    self.last = bodies["velocity"]"""
    folder = scene(GRAINS, water=fluid(members))
    with pytest.raises(tremie.RunError, match="kept `bodies`.*bodies.copy"):
        tremie.run(folder, out=folder / "out")
    folder = scene(GRAINS, water=fluid(members + ".copy()"))
    tremie.run(folder, out=folder / "copied")


def test_bodies_cannot_be_written(scene):
    members = """def advance(self, substeps, bodies, loads):
    bodies["velocity"] = 0.0"""
    folder = scene(GRAINS, water=fluid(members))
    with pytest.raises(tremie.RunError, match="read-only"):
        tremie.run(folder, out=folder / "out")


def test_what_a_component_prints_is_in_the_log(scene):
    members = """def advance(self, substeps, bodies, loads):
    loads["force"] = 0.0
    print("pressure solved")"""
    folder = scene(GRAINS, water=fluid(members))
    results = tremie.run(folder, out=folder / "out")
    said = [line for line in results.log if "pressure solved" in line["message"]]
    assert said and said[0]["from"] == "fluid"


def test_a_run_goes_on_from_a_checkpoint_to_the_same_bits(tremie_program, tmp_path):
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    for out, until in [(whole, "40 ms"), (broken, "20 ms")]:
        tremie.run(FLUID, until=until, out=out, set={"run.checkpoints.windows": 1000})
    done = tremie_program("resume", broken, "--until", "40 ms")
    assert done.returncode == 0, done.stderr
    one, other = tremie.open(whole).signals, tremie.open(broken).signals
    assert one.index[-1] == other.index[-1]
    columns = [name for name in one if not name.startswith("run.")]
    assert one[columns].equals(other[columns])


FALLING = '''
    import numpy as np
    import tremie

    class Falling(tremie.Grains):
        program = "falling.py 1"

        @classmethod
        def describe(cls, setup):
            return tremie.Description(step=1e-4, step_limit="a choice", bodies=2,
                                      signals=[tremie.Signal("height", "m")])

        def __init__(self, setup):
            self.step, self.gravity = setup.step, np.array(setup.scene["gravity"])
            self.new = tremie.added([1, 2], radius=[1e-3, 2e-3], mass=[1e-5, 8e-5])
            self.x = np.array([[5e-3, 5e-3, 0.03], [12e-3, 12e-3, 0.02]])
            self.v = np.zeros((2, 3))

        def events(self):
            new, self.new = self.new, self.new[:0]
            return new

        def state(self, bodies):
            bodies["id"] = [1, 2]
            bodies["position"], bodies["velocity"] = self.x, self.v
            bodies["orientation"] = [0, 0, 0, 1]

        def advance(self, substeps, loads):
            force = loads["force"] if len(loads) else 0.0
            for _ in range(substeps):
                self.v = self.v + self.step * (self.gravity + force / np.array([[1e-5], [8e-5]]))
                self.x = self.x + self.step * self.v

        def signals(self):
            return [float(self.x[0, 2])]

    tremie.main(Falling)
'''


def test_grains_fall_in_a_fluid_of_rust(scene, minimal_fluid, tremie_program):
    folder = scene(f'fluid = "{minimal_fluid}"\n            grains = "./falling.py"', falling=FALLING)
    done = tremie_program("conform", folder / "falling.py", "--role", "grains")
    assert done.returncode == 0, done.stdout + done.stderr
    height = tremie.run(folder, out=folder / "out").signals["grains.height"]
    # Stokes: the limit velocity is approached with a time of m / (3 pi mu d).
    mass, d, mu = 1e-5, 2e-3, 0.1
    weight = mass * 9.81 - 960 * np.pi / 6 * d**3 * 9.81
    tau = mass / (3 * np.pi * mu * d)
    t = height.index.to_numpy()
    fallen = weight / (3 * np.pi * mu * d) * (t - tau * (1 - np.exp(-t / tau)))
    np.testing.assert_allclose(0.03 - height, fallen, atol=0.05 * fallen[-1])


def test_an_observer_sees_what_it_has_methods_for(scene, minimal_fluid):
    folder = scene(
        f'fluid = "{minimal_fluid}"\n            grains = "grains-dem"\n'
        '            eye = { program = "./eye.py", role = "observer", lossless = true }',
        eye='''
            import json, os
            import tremie

            class Eye(tremie.Observer):
                def __init__(self, setup):
                    self.path, self.seen = os.path.join(setup.output, "seen.json"), {}

                def bodies(self, sender, at, bodies):
                    assert bodies.dtype == tremie.BODY_SAMPLE and not bodies.flags.writeable
                    self.seen["radii"] = bodies["radius"].tolist()
                    self.seen["bodies"] = at.window

                def signals(self, sender, at, values):
                    self.seen.setdefault("signals", {})[sender] = sorted(values)

                def close(self, last_common_window):
                    self.seen["last"] = last_common_window
                    with open(self.path, "w") as file:
                        json.dump(self.seen, file)
                    return "written"

            tremie.main(Eye)
        ''',
    )
    tremie.run(folder, out=folder / "out")
    seen = json.loads((folder / "out" / "seen.json").read_text())
    assert seen["radii"] == [1e-3, 1.5e-3]
    assert seen["bodies"] == seen["last"]
    assert "largest_drag" in seen["signals"]["fluid"]


def test_a_process_outside_of_a_run_says_how_it_is_meant_to_be_started():
    done = subprocess.run([sys.executable, FLUID / "stokes.py"], capture_output=True, text=True)
    assert done.returncode == 2
    assert "stokes.py 0.1.0 is a component" in done.stderr and "tremie run MANIFEST" in done.stderr


def test_a_program_that_is_no_component_yet_is_told_what_it_lacks(scene):
    folder = scene('fluid = "./water.py"', water="import tremie")
    with pytest.raises(tremie.RunError, match="before it said a word.*tremie.main") as refused:
        tremie.check(folder)
    assert "components.fluid" in str(refused.value)


def test_a_path_that_counts_from_the_wrong_folder_is_told_from_the_right_one(scene, tremie_program):
    folder = scene('fluid = "fluid-lbm"', water="import tremie")
    manifest = folder / "below" / "manifest.toml"
    manifest.parent.mkdir()
    (folder / "manifest.toml").rename(manifest)
    told = tremie_program("check", manifest, "--set", 'components.fluid="./water.py"', cwd=folder)
    assert told.returncode == 2
    assert "paths count from the manifest's folder; here it is" in told.stderr
    assert str(folder / "water.py") in told.stderr


@pytest.mark.parametrize("many", [100_000])
def test_many_bodies_are_seen_where_they_lie(scene, many):
    """1e5 bodies take 11 MB a window; a component that copied none needs no such memory."""
    folder = scene(
        'grains = "./many.py"\n            fluid = "./water.py"',
        water=fluid(
            f"""def advance(self, substeps, bodies, loads):
    import resource, tracemalloc
    assert bodies.base is not None and len(bodies) == {many}
    if not tracemalloc.is_tracing():
        tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    tracemalloc.reset_peak()
    np.copyto(loads["force"], 0.0)
    assert bodies["position"].base is not None
    self.grown = max(getattr(self, "grown", 0), tracemalloc.get_traced_memory()[1] - before)
def signals(self):
    return [float(self.grown)]
@classmethod
def describe(cls, setup):
    return tremie.Description(signals=[tremie.Signal("grown", "B")])"""
        ),
        many=f'''
            import numpy as np
            import tremie

            N = {many}

            class Many(tremie.Grains):
                @classmethod
                def describe(cls, setup):
                    return tremie.Description(step=1e-3, bodies=N)

                def __init__(self, setup):
                    self.new = tremie.added(np.arange(N), radius=1e-5, mass=1e-9)

                def events(self):
                    new, self.new = self.new, self.new[:0]
                    return new

                def state(self, bodies):
                    bodies["id"] = np.arange(N)
                    bodies["position"] = 0.01
                    bodies["orientation"] = [0, 0, 0, 1]

                def advance(self, substeps, loads):
                    pass

            tremie.main(Many)
        ''',
    )
    found = tremie.run(folder, out=folder / "out", until="10 ms")
    assert found.signals["fluid.grown"].max() < 100_000  # one copy of the states takes 11.2 MB
