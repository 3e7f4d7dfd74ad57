"""Kernels of lbmpy, one burst for each line on standard input.

A line says `f64|f32 bgk|les pattern threads seconds`; the answer is a rate in million cell updates a second.  What is timed is the
generated sweep over a periodic-free interior and nothing else: no ghost layers are exchanged, nothing is put out.  That favours it a little.
`compare.py` starts this in an environment of its own.
"""

import ctypes
import os
import sys
import time

EDGE = int(sys.argv[1])
os.environ["OMP_NUM_THREADS"] = sys.argv[2]
os.environ.setdefault("OMP_PROC_BIND", "true")

import numpy as np  # noqa: E402
import pystencils as ps  # noqa: E402
from lbmpy import LBMConfig, LBMOptimisation, LBStencil, Method, Stencil, create_lb_update_rule  # noqa: E402
from lbmpy.advanced_streaming import get_timesteps, is_inplace  # noqa: E402
from lbmpy.enums import SubgridScaleModel  # noqa: E402

Q = 19
OPENMP = ctypes.CDLL("libgomp.so.1")


def aligned(shape, dtype):
    """An array [x, y, z, q], x fastest and q slowest, whose first interior cell of a row is aligned to 64 bytes."""
    item = np.dtype(dtype).itemsize
    lane = 64 // item
    nx = -(-shape[0] // lane) * lane
    padded = (shape[3], shape[2], shape[1], nx)
    size = int(np.prod(padded))
    raw = np.zeros(size + 2 * lane, dtype)
    offset = (-(raw.ctypes.data // item) - 1) % lane
    return raw[offset : offset + size].reshape(padded)[..., : shape[0]].transpose(3, 2, 1, 0)


def target():
    with open("/proc/cpuinfo") as info:
        flags = info.read()
    return ps.Target.X86_AVX512 if "avx512f" in flags else ps.Target.X86_AVX


class Lattice:
    """Populations of a box and the kernels of a scheme."""

    def __init__(self, precision, model, pattern):
        dtype = {"f64": "float64", "f32": "float32"}[precision]
        shape = (EDGE + 2,) * 3 + (Q,)
        self.inplace = is_inplace(pattern)
        self.state = [aligned(shape, dtype) for _ in range(1 if self.inplace else 2)]
        noise = np.random.default_rng(1).uniform(-1e-4, 1e-4, size=shape[:3]).astype(dtype)
        for array in self.state:
            for q in range(Q):
                array[..., q] = noise * (1 if q % 2 else -1)
        fields = [ps.Field.create_from_numpy_array(name, array, index_dimensions=1)
                  for name, array in zip(["src", "dst"], [self.state[0], self.state[-1]])]
        self.kernels = [self.kernel(model, pattern, step, fields, dtype) for step in get_timesteps(pattern)]

    @staticmethod
    def kernel(model, pattern, step, fields, dtype):
        les = {"subgrid_scale_model": SubgridScaleModel.SMAGORINSKY} if model == "les" else {}
        lattice = LBMConfig(stencil=LBStencil(Stencil.D3Q19), method=Method.SRT, relaxation_rate=1.9, compressible=True,
                            streaming_pattern=pattern, timestep=step, **les)
        optimisation = LBMOptimisation(cse_global=True, symbolic_field=fields[0], symbolic_temporary_field=fields[1],
                                       field_layout="fzyx")
        config = ps.CreateKernelConfig(default_dtype=dtype, ghost_layers=1)
        config.cpu.openmp.enable = True
        config.target = target()
        config.cpu.vectorize.enable = True
        config.cpu.vectorize.assume_inner_stride_one = True
        config.cpu.vectorize.assume_aligned = True
        rule = create_lb_update_rule(lbm_config=lattice, lbm_optimisation=optimisation, config=config)
        return ps.create_kernel(rule, config).compile()

    def steps(self, count):
        for step in range(count):
            if self.inplace:
                self.kernels[step % 2](src=self.state[0])
            else:
                self.kernels[0](src=self.state[0], dst=self.state[1])
                self.state.reverse()

    def rate(self, seconds):
        start = time.perf_counter()
        self.steps(4)
        count = max(2, int(seconds / ((time.perf_counter() - start) / 4)) // 2 * 2)
        start = time.perf_counter()
        self.steps(count)
        spent = time.perf_counter() - start
        if not np.isfinite(self.state[0][1:-1, 1:-1, 1:-1, :].mean(dtype=np.float64)):
            raise RuntimeError("the populations are no numbers any more")
        return EDGE**3 * count / spent * 1e-6


def main():
    known = {}
    for line in sys.stdin:
        precision, model, pattern, threads, seconds = line.split()
        key = (precision, model, pattern)
        if key not in known:
            known.clear()
            known[key] = Lattice(*key)
        OPENMP.omp_set_num_threads(int(threads))
        print(known[key].rate(float(seconds)), flush=True)


main()
