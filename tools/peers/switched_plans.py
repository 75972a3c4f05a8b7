"""nosnoc (Python) with IPOPT on optimal control of the voice coil and the race car of `tests/scenes/switched.rs`, which stores what this prints.

    python switched_plans.py

Objective, CPU time in seconds, what is left of the complementarity, and whether IPOPT is satisfied. Conditions of the track hold at ends of elements.
"""

import os
import warnings

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[threads] = "1"

import time

import casadi as ca
import nosnoc as ns
import numpy as np


def solved(model, ocp, horizon, intervals, elements, stages):
    """The best objective on so many control intervals, elements of each, and stages of Radau IIA."""
    chosen = ns.NosnocOpts()
    chosen.N_stages, chosen.N_finite_elements, chosen.n_s, chosen.terminal_time, chosen.print_level = intervals, elements, stages, horizon, 0
    solver = ns.NosnocSolver(chosen, model, ocp)
    begun = time.process_time()
    found = solver.solve()
    seconds = time.process_time() - begun
    left = float(solver.problem.comp_res(found["w_sol"], solver.p_val))
    return float(found["cost_val"]), round(seconds, 2), left, bool(solver.solver.stats()["success"])


def voice_coil(horizon, intervals, elements, stages):
    """A coil moves a load on a spring by 1 cm with the least voltage (Christiansen, Maurer and Zirn 2008)."""
    m1, m2, k, kf, ks, rub, r, ell = 1.03, 0.56, 2400, 12, 12, 2.1, 2, 2e-3
    x, u = ca.SX.sym("x", 5), ca.SX.sym("u")
    pull = k * (x[0] - x[1])
    rates = lambda side: ca.vertcat(x[2], x[3], (kf * x[4] - pull - rub * side) / m1, pull / m2, (u - r * x[4] - ks * x[2]) / ell)
    model = ns.NosnocModel(x=x, u=u, F=[ca.horzcat(rates(1), rates(-1))], S=[np.array([[1], [-1]])], c=[x[2]], x0=np.zeros(5))
    goal = x - ca.vertcat(0.01, 0.01, 0, 0, 0)
    ocp = ns.NosnocOcp(lbu=np.array([-5.0]), ubu=np.array([5.0]), f_q=u**2, g_terminal=goal)
    return solved(model, ocp, horizon, intervals, elements, stages)


def race_car(way, intervals, elements, stages):
    """A car whose tyres rub across is as far along a winding track as soon as it can (after Stewart and Anitescu 2010)."""
    x, u, horizon = ca.SX.sym("x", 5), ca.SX.sym("u", 2), ca.SX.sym("horizon")
    c, s = ca.cos(x[4]), ca.sin(x[4])
    ahead, across = c * x[2] + s * x[3], c * x[3] - s * x[2]
    rates = lambda side: horizon * ca.vertcat(x[2], x[3], u[0] * c + 4 * s * side, u[0] * s - 4 * c * side, u[1] * ahead)
    model = ns.NosnocModel(
        x=x, u=u, F=[ca.horzcat(rates(1), rates(-1))], S=[np.array([[1], [-1]])], c=[across], x0=np.array([0, 0, 0, 0, 0.6]), v_global=horizon
    )
    ocp = ns.NosnocOcp(
        lbu=-2 * np.ones(2), ubu=2 * np.ones(2), f_terminal=horizon, g_terminal=x[0] - way, g_path=x[1] - ca.sin(x[0]),
        lbg=np.array([-0.3]), ubg=np.array([0.3]), lbv_global=np.array([0.5]), ubv_global=np.array([10.0]), v_global_guess=np.array([2.0]),
    )
    return solved(model, ocp, 1.0, intervals, elements, stages)


if __name__ == "__main__":
    warnings.filterwarnings("ignore")
    print("voice coil, 120 ms", voice_coil(0.12, 8, 4, 3), flush=True)
    print("race car, 3 m", race_car(3, 6, 3, 2), flush=True)
