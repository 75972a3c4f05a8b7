"""nosnoc (Python) with IPOPT: the time-freezing system, whose fields and regions it wants written down by hand."""

import warnings

import casadi as ca
import nosnoc as ns
import numpy as np

from rides import G, PUMP_TRACKS, SKI_JUMPS
from timing import fastest

GRIDS = [(2, 30, 3), (2, 30, 4), (3, 30, 4), (2, 90, 4)]
"""Stages of Radau IIA, steps, finite elements of a step."""
PUSH = 50.0
"""Strength of the auxiliary field of the pump track, as published."""
SKI_PUSH = 100 * G
SKI_GRIDS = [(2, 30, 3), (2, 90, 2), (2, 180, 2)]
SKI_TOLERANCE = 1e-4
"""At smaller ones no step of the ski jump is solved."""
SKI_GAP = 1e-3
"""The jumper starts that far above the table, or the first step is not solved."""


def options(stages, step, elements, tolerance):
    """Of one step in physical time."""
    chosen = ns.NosnocOpts()
    chosen.irk_scheme = ns.IrkSchemes.RADAU_IIA
    chosen.n_s = stages
    chosen.N_finite_elements = elements
    chosen.terminal_time = step
    chosen.mpcc_mode = ns.MpccMode.SCHOLTES_INEQ
    chosen.cross_comp_mode = ns.CrossComplementarityMode.SUM_LAMBDAS_COMPLEMENT_WITH_EVERY_THETA
    chosen.step_equilibration = ns.StepEquilibrationMode.HEURISTIC_MEAN
    chosen.sigma_0, chosen.homotopy_update_slope = 1.0, 0.1
    chosen.comp_tol = chosen.sigma_N = tolerance
    chosen.time_freezing, chosen.time_freezing_tolerance = True, 0.0
    chosen.speed_of_time_variables = ns.SpeedOfTimeVariableMode.LOCAL
    chosen.print_level = 0
    chosen.opts_casadi_nlp["ipopt"]["max_iter"] = 500
    return chosen


def pump_track(ride):
    """Model and start: on the track, where gap and its velocity are below zero, the auxiliary field holds."""
    x = ca.SX.sym("x", 7)
    y, s, _, v, fall, stretch, clock = ca.vertsplit(x)
    slope, bend = 0.4 * ca.sin(2 * y), 0.8 * ca.cos(2 * y)
    free = ca.vertcat(v, fall, stretch, 0, -G - bend * v**2, 0, 1)
    push = PUSH * ca.vertcat(0, 0, 0, -slope, 1, 0, 0)
    start = np.array([0, 0, ride.length, ride.speed, 0, 0, 0])
    signs = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
    fields = ca.horzcat(free, free, free, push)
    model = ns.NosnocModel(x=x, F=[fields], S=[signs], c=[ca.vertcat(s, fall)], x0=start, t_var=clock)
    return model, start, 3


def ski_jump(ride):
    """The same of two surfaces, by products of step functions instead of sixteen regions."""
    x = ca.SX.sym("x", 5)
    y, z, vy, vz, clock = ca.vertsplit(x)
    gaps = ca.vertcat(z - ride.table(y)[0], z - ride.slope(y)[0])
    normals = [ca.gradient(gaps[i], x)[:2] for i in range(2)]
    closing = [ca.dot(normal, ca.vertcat(vy, vz)) for normal in normals]
    free = ca.vertcat(vy, vz, 0, -G, 1)
    above = ca.SX.sym("alpha", 4)
    held = [(1 - above[i]) * (1 - above[2 + i]) for i in range(2)]
    pushes = [ca.vertcat(0, 0, SKI_PUSH / 80 * normal, 0) for normal in normals]
    field = (1 - held[0]) * (1 - held[1]) * free + held[0] * pushes[0] + held[1] * pushes[1]
    start = np.array([ride.start, ride.table(ride.start)[0] + SKI_GAP, 0, 0, 0])
    switches = [ca.vertcat(gaps, *closing)]
    model = ns.NosnocModel(x=x, f_x=[field], alpha=[above], c=switches, x0=start, t_var=clock)
    return model, start, 2


def simulate(ride, build, grid, tolerance):
    """CPU seconds of all steps without the set-up, the coordinates at the end, and how many steps were solved."""
    stages, steps, elements = grid
    chosen = options(stages, ride.horizon / steps, elements, tolerance)
    model, start, coordinates = build(ride)
    if coordinates == 2:
        chosen.pss_mode = ns.PssMode.STEP
    solver = ns.NosnocSolver(chosen, model)
    reached = {}

    def run():
        state, solved = start, 0
        for _ in range(steps):
            solver.set("x0", state)
            found = solver.solve()
            left = float(solver.problem.comp_res(found["w_sol"], solver.p_val))
            solved += left <= 10 * tolerance and bool(solver.solver.stats()["success"])
            state = np.array(found["x_list"][-1])
        reached["steps"] = solved
        return state[:coordinates]

    seconds, end = fastest(run, repeated=1.0)
    return seconds, end, reached["steps"]


def points(wanted):
    """(study, curve, settings, CPU seconds, coordinates at the end) of every run of the studies that are wanted."""
    warnings.filterwarnings("ignore")
    cases = [(ride, pump_track, grid, 1e-8) for ride in PUMP_TRACKS for grid in GRIDS]
    cases += [(ride, ski_jump, grid, SKI_TOLERANCE) for ride in SKI_JUMPS for grid in SKI_GRIDS]
    for ride, build, grid, tolerance in cases:
        if not wanted(ride.study):
            continue
        stages, steps, elements = grid
        seconds, end, solved = simulate(ride, build, grid, tolerance)
        settings = f"Radau IIA, {stages} stages, {solved} of {steps} steps of {elements} elements solved to {tolerance:g}"
        yield ride.study, "nosnoc", settings, seconds, end
