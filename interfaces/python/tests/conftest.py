"""Scenes and programs that the tests share."""

import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
FLUID = ROOT / "examples" / "python-fluid"


@pytest.fixture
def tremie_program():
    """Calls the program that the package brings."""

    def call(*words, **more):
        program = Path(sys.executable).with_name("tremie")
        return subprocess.run(
            [program, *map(str, words)], capture_output=True, text=True, timeout=300, **more
        )

    return call


@pytest.fixture(scope="session")
def minimal_fluid():
    """The smallest fluid in Rust, which `cargo build --release` leaves beside the program."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    program = target / "release" / "minimal-fluid"
    assert program.is_file(), f"{program} is missing: cargo build --release -p minimal-fluid"
    return str(program)


@pytest.fixture
def scene(tmp_path):
    """A folder with a manifest of a few sinking spheres, and components as given."""

    def make(components, **files):
        for name, text in files.items():
            (tmp_path / f"{name}.py").write_text(textwrap.dedent(text))
        text = f"""
            [run]
            until = "20 ms"
            [scene]
            gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]
            [scene.domain]
            size = ["20 mm", "20 mm", "40 mm"]
            [scene.fluid]
            density = "960 kg/m3"
            viscosity = "0.1 Pa s"
            [[scene.bodies]]
            name = "grains"
            density = "2650 kg/m3"
            spheres = [
                {{ position = ["5 mm", "5 mm", "30 mm"], diameter = "2 mm" }},
                {{ position = ["12 mm", "12 mm", "20 mm"], diameter = "3 mm" }},
            ]
            [[scene.contacts]]
            normal_stiffness = "500 N/m"
            tangential_stiffness = "400 N/m"
            friction = 0.3
            restitution = 0.5
            [components]
            {components}
            [outputs]
            frames = "5 ms"
            signals = "1 ms"
        """
        (tmp_path / "manifest.toml").write_text(textwrap.dedent(text))
        return tmp_path

    return make
