"""Three scenes of the zoo by nosnoc (Python) and IPOPT, with its default homotopy, written down as it wants them.

    python zoo_with_nosnoc.py [INTERVALS ...]

solves each scene on these numbers of control intervals (10, 20, 40) with the benchmark of the zoo, by default, and with nosnoc, one thread
each, and prints one table.
"""

import itertools
import os
import subprocess
import sys
import time
import warnings
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ[threads] = "1"

import casadi as ca
import nosnoc as ns
import numpy as np

PUSH = 50.0
"""Strength of the auxiliary fields: more than any force here."""
SOLVED = 1e-6
"""Largest product of a solution that counts as one."""


def options(intervals, horizon, frozen):
    """The defaults, with three finite elements of an interval; with a clock where impacts freeze the time."""
    chosen = ns.NosnocOpts()
    chosen.N_stages, chosen.N_finite_elements, chosen.terminal_time = intervals, 3, horizon
    chosen.print_level = 0
    if frozen:
        chosen.time_freezing, chosen.time_freezing_tolerance = True, 0.0
        chosen.speed_of_time_variables = ns.SpeedOfTimeVariableMode.LOCAL
    return chosen


def rough_block(intervals):
    """Friction is a force with two signs; the floor holds the block all the time."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    friction = 0.2 * 10
    fields = ca.horzcat(ca.vertcat(x[1], u - friction), ca.vertcat(x[1], u + friction))
    model = ns.NosnocModel(x=x, u=u, F=[fields], S=[np.array([[1], [-1]])], c=[x[1]], x0=np.zeros(2))
    ocp = ns.NosnocOcp(
        lbu=np.array([-20.0]), ubu=np.array([20.0]), f_q=u**2, g_terminal=x - ca.vertcat(3, 0)
    )
    return options(intervals, 5.0, frozen=False), model, ocp


def with_impacts(scene, intervals):
    """Masses on a rail that strike each other without rebound: where a gap and its velocity are below zero, time stands still and both are
    pushed apart."""
    masses, gaps, force, cost, final, goals, start, bound, horizon = scene
    n = len(masses)
    x, u = ca.SX.sym("x", 2 * n + 2), ca.SX.sym("u")
    q, v = x[:n], x[n : 2 * n]
    distances = [gap(q) for gap in gaps]
    speeds = [ca.jtimes(gap, q, v) for gap in distances]
    free = ca.vertcat(v, *[f * u / m for f, m in zip(force, masses)], cost(q, u), 1)
    aside = [ca.vertcat(ca.SX.zeros(n), PUSH * ca.gradient(gap, q) / ca.vertcat(*masses), 0, 0) for gap in distances]
    signs, fields = [], []
    for pattern in itertools.product([1, -1], repeat=2 * len(gaps)):
        closing = [i for i in range(len(gaps)) if pattern[i] < 0 and pattern[len(gaps) + i] < 0]
        signs.append(pattern)
        fields.append(sum((aside[i] for i in closing), ca.SX.zeros(2 * n + 2)) if closing else free)
    begin = np.array([*start, 0.0, 0.0])
    model = ns.NosnocModel(
        x=x, u=u, F=[ca.horzcat(*fields)], S=[np.array(signs)], c=[ca.vertcat(*distances, *speeds)], x0=begin, t_var=x[-1]
    )
    ocp = ns.NosnocOcp(
        lbu=np.array([-bound]), ubu=np.array([bound]), f_terminal=x[2 * n] + final(q), g_terminal=goals(q, v)
    )
    return options(intervals, horizon, frozen=True), model, ocp


PUSH_AND_ROLL = (
    [1.0, 2.0], [lambda q: q[1] - q[0] - 1], [1, 0], lambda q, u: u**2, lambda q: 0,
    lambda q, v: ca.vertcat(q[1] - 3, v[1] - 0.5), [-1.0, 1.0, 0.0, 0.0], 5.0, 5.0,
)
THREE_CARTS = (
    [1.0, 1.0, 1.0], [lambda q: q[1] - q[0] - 2, lambda q: q[2] - q[1] - 2], [0, 1, 0],
    lambda q, u: 10 * (q[0] + 5) ** 2 + 10 * (q[2] - 5) ** 2 + 0.05 * u**2,
    lambda q: 100 * ((q[0] + 5) ** 2 + (q[2] - 5) ** 2),
    lambda q, v: ca.SX.zeros(0), [-3.0, 0.0, 3.0, 0.0, 0.0, 0.0], 30.0, 4.0,
)
SCENES = {
    "rough-block": rough_block,
    "push-and-roll": lambda intervals: with_impacts(PUSH_AND_ROLL, intervals),
    "three-carts": lambda intervals: with_impacts(THREE_CARTS, intervals),
}


def by_nosnoc(build, intervals):
    """Objective, largest product, status of the last program, CPU seconds without the set-up."""
    solver = ns.NosnocSolver(*build(intervals))
    clock = time.process_time()
    found = solver.solve()
    seconds = time.process_time() - clock
    left = float(solver.problem.comp_res(found["w_sol"], solver.p_val))
    solved = bool(solver.solver.stats()["success"]) and left <= SOLVED
    return float(found["cost_val"]), left, "solved" if solved else "not solved", seconds


def by_hangtime(grids):
    """Objective, status and CPU seconds of each scene on each grid, as the benchmark of the zoo prints them."""
    chosen = ["--ways", "default", "--only", ",".join(SCENES), "--intervals", ",".join(map(str, grids))]
    call = ["cargo", "bench", "--quiet", "-p", "hangtime-zoo", "--bench", "zoo", "--", *chosen]
    printed = subprocess.run(call, capture_output=True, text=True, check=True, cwd=Path(__file__).parent).stdout
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in printed.splitlines()]
    return {(row[0], int(row[1])): (row[3], row[5], row[7]) for row in rows if row[0] in SCENES}


def main():
    warnings.filterwarnings("ignore")
    grids = [int(argument) for argument in sys.argv[1:]] or [10, 20, 40]
    own = by_hangtime(grids)
    print("| scene | N | nosnoc | largest product | status | CPU [s] | hangtime | status | CPU [s] |")
    print("|---|---|---|---|---|---|---|---|---|")
    for (name, build), intervals in itertools.product(SCENES.items(), grids):
        objective, left, status, seconds = by_nosnoc(build, intervals)
        other = " | ".join(own[name, intervals])
        print(f"| `{name}` | {intervals} | {objective:.6g} | {left:.1e} | {status} | {seconds:.2f} | {other} |", flush=True)


if __name__ == "__main__":
    main()
