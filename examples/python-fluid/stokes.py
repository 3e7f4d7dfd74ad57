"""A fluid in Python: Stokes drag and buoyancy on spheres, as examples/minimal-fluid does it in Rust.

On each grain act the force F = 3 pi mu d (u - v) - rho_f V g and the torque T = -pi mu d^3 omega
(Stokes 1851). The fluid's velocity u is constant; no grain feels another through it.
"""

import numpy as np
import tremie


class StokesFluid(tremie.Fluid):
    program = "stokes.py 0.1.0"
    # Another number whenever save_state keeps other things.
    state_version = 1

    @classmethod
    def describe(cls, setup):
        setup.known_parameters()
        fluid = setup.scene.get("fluid")
        if fluid is None:
            raise tremie.Problem("scene", "there is no fluid", "add a [scene.fluid] table")
        return tremie.Description(
            # No step of its own: it takes whatever window the others need.
            signals=[tremie.Signal("largest_drag", "N", "largest drag on a sphere")],
            notes=[f"Stokes drag, {fluid['viscosity']} Pa s"],
            warnings=["grains do not feel each other through this fluid"],
        )

    def __init__(self, setup):
        fluid = setup.scene["fluid"]
        self.density, self.viscosity = fluid["density"], fluid["viscosity"]
        self.velocity, self.gravity = np.array(fluid["velocity"]), np.array(setup.scene["gravity"])
        self.ids = np.zeros(0, dtype=np.uint64)
        self.diameters = np.zeros(0)  # in the order of the ids [m]
        self.largest_drag = 0.0

    def events(self, events):
        new = events[events["kind"] == tremie.Kind.ADDED]
        if np.any(new["shape"] != tremie.Shape.SPHERE):
            raise ValueError("this fluid knows spheres alone")
        stay = ~np.isin(self.ids, events["id"][events["kind"] == tremie.Kind.REMOVED])
        ids = np.concatenate([self.ids[stay], new["id"]])
        diameters = np.concatenate([self.diameters[stay], 2 * new["size"][:, 0]])
        order = np.argsort(ids)
        self.ids, self.diameters = ids[order], diameters[order]

    def advance(self, substeps, bodies, loads):
        d = self.diameters[:, None]
        drag = 3 * np.pi * self.viscosity * d * (self.velocity - bodies["velocity"])
        # Buoyancy is part of the load: grains always apply their full weight.
        loads["force"] = drag - self.density * np.pi / 6 * d**3 * self.gravity
        loads["torque"] = -np.pi * self.viscosity * d**3 * bodies["angular_velocity"]
        self.largest_drag = float(np.abs(drag).max(initial=0.0))

    def signals(self):
        return [self.largest_drag]

    def save_state(self):
        return {"ids": self.ids, "diameters": self.diameters, "largest_drag": self.largest_drag}

    def restore_state(self, state):
        self.ids, self.diameters = state["ids"], state["diameters"]
        self.largest_drag = state["largest_drag"]


if __name__ == "__main__":
    tremie.main(StokesFluid)
