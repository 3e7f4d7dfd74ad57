"""Solutions of a pressure's equations by PyAMG or PETSc, one for each line on standard input.

A line says `kind folder`, with a kind of KINDS; the answer is `milliseconds setup_share iterations left`: setup and solution
together, the part of the setup, the iterations, and the largest residual over the largest right side.  The residual is at most
1e-8, as for Tremie.  `compare_pressure.py` starts this, once in an environment with PyAMG, once in one with PETSc.
"""

import sys
import time

import numpy as np
import scipy.sparse as sparse

GOAL = 1e-8


def read(folder):
    places = np.fromfile(f"{folder}/places", "<u4").reshape(-1, 2)
    values = np.fromfile(f"{folder}/values", "<f8")
    right = np.fromfile(f"{folder}/right", "<f8")
    size = len(right)
    matrix = sparse.coo_matrix((values, (places[:, 0], places[:, 1])), shape=(size, size)).tocsr()
    assert abs(matrix - matrix.T).max() < 1e-12
    return matrix, right


def by_pyamg(make):
    def solve(matrix, right, tolerance):
        start = time.perf_counter()
        hierarchy = make(matrix)
        setup = time.perf_counter() - start
        residuals = []
        q = hierarchy.solve(right, tol=tolerance, maxiter=200, accel="cg", residuals=residuals)
        return time.perf_counter() - start, setup, len(residuals) - 1, q

    return solve


def by_petsc(preconditioner):
    def solve(matrix, right, tolerance):
        size = len(right)
        equations = PETSc.Mat().createAIJ(size=(size, size), csr=(matrix.indptr, matrix.indices, matrix.data))
        b, q = equations.createVecs()
        b.setArray(right)
        # The matrix is there, as for Tremie: what counts is what is made of it.
        start = time.perf_counter()
        solver = PETSc.KSP().create()
        solver.setOperators(equations)
        solver.setType("cg")
        solver.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
        solver.getPC().setType(preconditioner)
        solver.setTolerances(rtol=tolerance, max_it=5000)
        solver.setUp()
        setup = time.perf_counter() - start
        solver.solve(b, q)
        took = time.perf_counter() - start
        found = took, setup, solver.getIterationNumber(), q.getArray().copy()
        # PETSc's objects outlive their names here, hierarchies of gigabytes with them.
        for made in (solver, equations, b, q):
            made.destroy()
        return found

    return solve


KINDS = {}
try:
    import pyamg

    KINDS["classical"] = by_pyamg(pyamg.ruge_stuben_solver)
    KINDS["aggregation"] = by_pyamg(pyamg.smoothed_aggregation_solver)
except ImportError:
    pass
try:
    import petsc4py

    petsc4py.init(sys.argv)
    from petsc4py import PETSc

    KINDS["gamg"] = by_petsc("gamg")
    KINDS["boomeramg"] = by_petsc("hypre")
    KINDS["icc"] = by_petsc("icc")
except ImportError:
    pass

KNOWN = {}


def solution(kind, folder):
    matrix, right = read(folder)

    def once(tolerance):
        took, setup, iterations, q = KINDS[kind](matrix, right, tolerance)
        return took, setup, iterations, abs(right - matrix @ q).max() / abs(right).max()

    if (kind, folder) not in KNOWN:
        # The peers end by the Euclidean norm: the loosest tolerance that meets the goal.
        tolerance = 1e-7
        while once(tolerance)[3] > GOAL:
            tolerance *= 0.5
        KNOWN[kind, folder] = tolerance
    return once(KNOWN[kind, folder])


for line in sys.stdin:
    took, setup, iterations, left = solution(*line.split())
    print(f"{1e3 * took:.3f} {setup / took:.3f} {iterations} {left:.2e}", flush=True)
