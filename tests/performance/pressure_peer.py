"""Solutions of a pressure's equations by PyAMG, one for each line on standard input.

A line says `classical|aggregation folder`; the answer is `milliseconds setup_share iterations left`: setup and solution together,
the part of the setup, the iterations, and the largest residual over the largest right side.  The residual is at most 1e-8, as
for Tremie.  `compare_pressure.py` starts this in an environment of its own.
"""

import sys
import time

import numpy as np
import pyamg
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


def solve(kind, matrix, right, tolerance):
    start = time.perf_counter()
    make = {"classical": pyamg.ruge_stuben_solver, "aggregation": pyamg.smoothed_aggregation_solver}[kind]
    hierarchy = make(matrix)
    setup = time.perf_counter() - start
    residuals = []
    q = hierarchy.solve(right, tol=tolerance, maxiter=200, accel="cg", residuals=residuals)
    took = time.perf_counter() - start
    left = abs(right - matrix @ q).max() / abs(right).max()
    return took, setup, len(residuals) - 1, left


KNOWN = {}
for line in sys.stdin:
    kind, folder = line.split()
    matrix, right = read(folder)
    key = (kind, folder)
    if key not in KNOWN:
        # The peer ends by the Euclidean norm: the loosest tolerance that meets the goal.
        tolerance = 1e-7
        while solve(kind, matrix, right, tolerance)[3] > GOAL:
            tolerance *= 0.5
        KNOWN[key] = tolerance
    took, setup, iterations, left = solve(kind, matrix, right, KNOWN[key])
    print(f"{1e3 * took:.3f} {setup / took:.3f} {iterations} {left:.2e}", flush=True)
