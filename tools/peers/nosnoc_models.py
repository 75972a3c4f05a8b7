"""nosnoc's examples, and some of hangtime's, as nosnoc (Python) wants them: regions and fields by hand.

Running costs are states, so that objectives are those of the motion alone, without what nosnoc adds for equal steps, and stand still where time does.
Nothing here is nosnoc's text; where its own statement differs: feet of the hopper may slip as its friction lets them, its path is a parabola in time
rather than a value an interval, and levels of tanks hold back what flows into them from 0.5 on, as in the paper the cascade is from.
"""

from dataclasses import dataclass, field
from math import cos, exp, log, pi, sin, sqrt
from typing import Any, Callable

import casadi as ca
import nosnoc as ns
import numpy as np

PUSH = 100.0
"""Strength of auxiliary fields: more than any force here."""


@dataclass(frozen=True)
class Simulated:
    """Switches are pairs of a function and its fields where it is positive and negative; what is wanted at the end is a closed form, if any."""

    name: str
    scene: str
    state: ca.SX
    switches: list
    start: list
    horizon: float
    wanted: Any = None
    grids: tuple = ((3, 5, 2), (3, 23, 3))
    published: str = ""
    changes: dict = field(default_factory=dict)

    def model(self):
        return filippov(self.state, self.switches, self.start)


@dataclass(frozen=True)
class Planned:
    """A plan on a grid of control intervals, elements of each, and stages; what nosnoc cannot state has no program of it."""

    name: str
    scene: str
    build: Callable
    grid: tuple
    published: str = ""
    changes: dict = field(default_factory=dict)


def options(grid, horizon, **more):
    """The defaults but for the grid and what is named."""
    chosen = ns.NosnocOpts()
    chosen.N_stages, chosen.N_finite_elements, chosen.n_s = grid
    chosen.terminal_time, chosen.nlp_max_iter, chosen.print_level = horizon, 3000, 0
    for name, value in more.items():
        setattr(chosen, name, value)
    return chosen


def filippov(x, switches, start, **more):
    """Of pairs of a function and its fields on both sides; fields add up."""
    fields = [ca.horzcat(ca.vertcat(*above), ca.vertcat(*below)) for _, above, below in switches]
    signs = [np.array([[1], [-1]])] * len(switches)
    return ns.NosnocModel(x=x, F=fields, S=signs, c=[switch[0] for switch in switches], x0=np.array(start, dtype=float), **more)


def box(*limits):
    """Lower and upper bounds of pairs, or of numbers that hold on both sides."""
    pairs = [limit if isinstance(limit, tuple) else (-limit, limit) for limit in limits]
    return np.array([low for low, _ in pairs], dtype=float), np.array([high for _, high in pairs], dtype=float)


# What is simulated.


def genes_end(x, y, horizon):
    """Exponentials between the thresholds."""
    time, much, little = 0.0, 0.4, 0.6
    while True:
        focus = (1.0 if y < little else 0.0, 1.0 if x > much else 0.0)

        def meets(value, target, threshold):
            share = (target - threshold) / (target - value)
            return -log(share) if share > 0 and -log(share) > 1e-12 else float("inf")

        first = min(meets(x, focus[0], much), meets(y, focus[1], little))
        step = min(first, horizon - time)
        x, y = focus[0] + (x - focus[0]) * exp(-step), focus[1] + (y - focus[1]) * exp(-step)
        time += step
        if time >= horizon:
            return [x, y]
        if abs(x - much) < 1e-12:
            x = much + 1e-13 * np.sign(focus[0] - much)
        if abs(y - little) < 1e-12:
            y = little + 1e-13 * np.sign(focus[1] - little)


def tanks_end():
    inflow, weir = 0.5, 2.0
    fills = 2.0
    for _ in range(50):
        fills -= (inflow * (fills - (1 - exp(-weir * fills)) / weir) - 1) / (inflow * (1 - exp(-weir * fills)))
    t = 6 - 1 / inflow
    constant = (inflow * fills * exp(-weir * fills) - inflow / weir) * exp(weir * fills)
    return [1 + inflow / weir * (1 - exp(-weir * t)), 1 + inflow / weir + (constant - inflow * t) * exp(-weir * t)]


def simulations():
    x, y, z = ca.SX.sym("x"), ca.SX.sym("x", 2), ca.SX.sym("x", 3)
    over, on, w = 2 * (y[0] - 1), 2 * (y[1] - 1), 2 * pi
    outside, inside = ([y[0] - w * y[1], y[1] + w * y[0]], [y[0] + w * y[1], y[1] - w * y[0]])
    late, quarter = pi / 2 - 1, 10 - 7 * sqrt(2)
    linear = lambda s: [-3.5 * z[0] + z[1] - s, -627.5 * z[0] + z[2] + 2 * s, -625 * z[0] - s]
    slips = lambda force: [y[1], -y[0] + force]
    genes = (0.6 - y[1], [1 - y[0], -y[1]], [-y[0], -y[1]])
    fine = ((3, 5, 2), (3, 11, 2), (3, 23, 3))
    yield Simulated("crossing", "crossing", x, [(x, [3], [1])], [-1], 2, [3])
    yield Simulated("sliding mode", "sliding", y, [(y[0], [-0.5, 1], [1.5, -1])], [1, 0], 4, [0, 3])
    yield Simulated("sliding mode that is left", "leaving-sliding", y, [(y[0], [y[1] - 1, 1], [y[1] + 1, 1])], [0.3, 0], 2, [0.5])
    yield Simulated("sliding mode, unstable", "unstable-sliding", x, [(x, [1], [-1])], [0], 1, [0], published="no motion is the only one")
    end = [exp(late) * cos(w * late), exp(late) * sin(w * late)]
    own = "29 steps of 2 elements"
    yield Simulated("oscillator", "spiral", y, [(y[0] ** 2 + y[1] ** 2 - 1, outside, inside)], [exp(-1), 0], pi / 2, end, ((3, 29, 2), (4, 29, 2)), own)
    relays = [(y[0], [-1, 0.5], [1, -0.5]), (y[1], [0, -1], [0, 1])]
    yield Simulated("two relays", "two-relays", y, relays, [0.3, 0.5], 1, [0, 0])
    end = [sqrt(2) * quarter - quarter**2 / 2, sqrt(2) - quarter]
    yield Simulated("relay", "relay", y, [(y[0], [y[1], -1], [y[1], 1])], [1, 0], 10, end, fine)
    yield Simulated("relay feedback", "relay-feedback", z, [(z[0], linear(1), linear(-1))], [0, -0.001, -0.02], 10, None, ((2, 200, 2), (3, 200, 2)), "200 steps of 2 elements")
    yield Simulated("two genes", "two-genes", y, [genes, (y[0] - 0.4, [0, 1], [0, 0])], [0.1, 0.2], 3, genes_end(0.1, 0.2, 3.0), fine)
    tanks = [(y[0] - 1, [0.5 - over, over], [0.5, 0]), (y[1] - 1, [0, -on], [0, 0])]
    yield Simulated("cascade of two tanks", "tank-cascade", y, tanks, [0, 0], 6, tanks_end(), fine)
    rubs = [(y[1] - 0.2, slips(-1 / (y[1] + 0.8)), slips(1 / (1.2 - y[1])))]
    yield Simulated("stick and slip", "stick-slip-cycle", y, rubs, [1, 0], 12, None, fine)


# Plans with switches.


def with_cost(x, u, switches, start, running, final, ocp, chosen, time=None, **more):
    """With the running cost as the last state; by a final time the fields are scaled."""
    scale = 1 if time is None else time
    cost = ca.SX.sym("cost")
    whole = [
        (c, [scale * part for part in above] + ([scale * running] if k == 0 else [0]), [scale * part for part in below] + ([scale * running] if k == 0 else [0]))
        for k, (c, above, below) in enumerate(switches)
    ]
    state = ca.vertcat(x, cost)
    model = filippov(state, whole, [*start, 0], u=u, **more)
    total = cost + final
    if "lbx" in ocp:
        ocp["lbx"], ocp["ubx"] = np.append(ocp["lbx"], -np.inf), np.append(ocp["ubx"], np.inf)
    worth = ca.Function("worth", [state, model.v_global], [total])
    return chosen, model, ns.NosnocOcp(f_terminal=total, **ocp), lambda end, v: float(worth(end, v))


def limits(u=None, x=None):
    """Bounds of controls and states for `NosnocOcp`."""
    made = {}
    if u:
        made["lbu"], made["ubu"] = box(*u)
    if x:
        made["lbx"], made["ubx"] = box(*x)
    return made


def free_global(low, guess, high):
    return {"lbv_global": np.array([low]), "ubv_global": np.array([high]), "v_global_guess": np.array([guess])}


def turbo_car(fastest):
    def build(grid):
        x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
        time, bounds = ca.SX.sym("time"), free_global(1.0, 20.0, 100.0)
        ocp = limits([5], [np.inf, fastest]) | bounds | {"g_terminal": x - ca.vertcat(200, 0)}
        switches = [(x[1] - 10, [x[1], 3 * u], [x[1], u])]
        return with_cost(x, u, switches, [0, 0], 0, time, ocp, options(grid, 1.0), time, v_global=time)

    return build


def hysteresis_car(grid):
    """The turbo as a memory between Voronoi regions, in which a push up and down freezes the time; a grid in numerical time, whose speed is free."""
    x, u, speed = ca.SX.sym("x", 4), ca.SX.sym("u"), ca.SX.sym("speed")
    share, memory = (x[1] - 10) / 5, x[2]
    corners = [(0.25, -0.25), (0.25, 0.25), (0.75, 0.75), (0.75, 1.25)]
    regions = ca.vertcat(*[(share - a) ** 2 + (memory - b) ** 2 for a, b in corners])
    drives = [ca.vertcat(x[1], gear * u, 0, 1) for gear in (1, 3)]
    down, up = (ca.vertcat(0, 0, 2 * s * r**2 / (1 + r**2), 0) for s, r in ((-1, share - 1), (1, share)))
    fields = speed * ca.horzcat(2 * drives[0] - down, down, up, 2 * drives[1] - up)
    model = ns.NosnocModel(x=x, F=[fields], g_Stewart=[regions], x0=np.zeros(4), u=u, v_global=speed, t_var=x[3])
    bounds = limits([5], [np.inf, (0, 25), (0, 2), np.inf]) | free_global(0.1, 1.0, 1000.0)
    ocp = ns.NosnocOcp(f_terminal=x[3], g_terminal=x[:2] - ca.vertcat(150, 0), **bounds)
    return options(grid, 10.0), model, ocp, lambda end, _: float(end[3])


def sliding_plan(grid):
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 2)
    first = (x[0] + 0.15 * x[1] ** 2, [x[2] - 1, 0, u[0], u[1]], [x[2] + 1, 0, u[0], u[1]])
    second = (x[1] - 0.05 * x[0] ** 3, [0, x[3] - 1, 0, 0], [0, x[3] + 1, 0, 0])
    ocp = limits([10, 10]) | {"g_terminal": x[:2] - ca.vertcat(-pi / 6, -pi / 4)}
    chosen = options(grid, 4.0, comp_tol=1e-9, rho_h=10.0, step_equilibration=ns.StepEquilibrationMode.HEURISTIC_MEAN)
    return with_cost(x, u, [first, second], [2 * pi / 3, pi / 3, 0, 0], x[2] ** 2 + x[3] ** 2, 0, ocp, chosen)


def tank_plan(grid):
    x, u = ca.SX.sym("x", 3), ca.SX.sym("u", 4)
    flow = lambda k, drop: 0.1 * u[k] * ca.sqrt(drop)
    moved = lambda k, drop: [-flow(k, drop) if i == k - 1 else flow(k, drop) if i == k else 0 for i in range(3)]
    always = [0.1 * u[0], 0, -flow(3, x[2])]
    first = [[a + b for a, b in zip(always, moved(1, drop))] for drop in (x[0] - x[1] + 0.5, x[0])]
    switches = [(x[1] - 0.5, *first), (x[2] - 0.5, moved(2, x[1] - x[2] + 0.5), moved(2, x[1]))]
    away = sum((x[i] - 0.75) ** 2 for i in range(3))
    return with_cost(x, u, switches, [0.1] * 3, away, 0, limits([(0.25, 1.25)] * 4, [(0.001, 10)] * 3), options(grid, 100.0))


def weaker_above(grid):
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    ocp = limits([1]) | {"g_terminal": x - ca.vertcat(500, 0)}
    return with_cost(x, u, [(x[1] - 15, [x[1], 3 * u], [x[1], 5 * u])], [0, 0], u**2, 0, ocp, options(grid, 30.0))


def voice_coil(horizon):
    def build(grid):
        m1, m2, k, kf, ks, rub, r, ell = 1.03, 0.56, 2400, 12, 12, 2.1, 2, 2e-3
        x, u = ca.SX.sym("x", 5), ca.SX.sym("u")
        pull = k * (x[0] - x[1])
        rates = lambda side: [x[2], x[3], (kf * x[4] - pull - rub * side) / m1, pull / m2, (u - r * x[4] - ks * x[2]) / ell]
        ocp = limits([5]) | {"g_terminal": x - ca.vertcat(0.01, 0.01, 0, 0, 0)}
        return with_cost(x, u, [(x[2], rates(1), rates(-1))], [0] * 5, u**2, 0, ocp, options(grid, horizon))

    return build


def race_car(grid):
    x, u = ca.SX.sym("x", 5), ca.SX.sym("u", 2)
    time, bounds = ca.SX.sym("time"), free_global(0.5, 2.0, 10.0)
    c, s = ca.cos(x[4]), ca.sin(x[4])
    ahead, across = c * x[2] + s * x[3], c * x[3] - s * x[2]
    rates = lambda side: [x[2], x[3], u[0] * c + 4 * s * side, u[0] * s - 4 * c * side, u[1] * ahead]
    ocp = limits([2, 2]) | bounds | {"g_terminal": x[0] - 3, "g_path": x[1] - ca.sin(x[0]), "lbg": np.array([-0.3]), "ubg": np.array([0.3])}
    return with_cost(x, u, [(across, rates(1), rates(-1))], [0, 0, 0, 0, 0.6], 0, time, ocp, options(grid, 1.0), time, v_global=time)


def rough_block(grid):
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    ocp = limits([20]) | {"g_terminal": x - ca.vertcat(3, 0)}
    return with_cost(x, u, [(x[1], [x[1], u - 2], [x[1], u + 2])], [0, 0], u**2, 0, ocp, options(grid, 5.0))


# Plans with impacts.


@dataclass(frozen=True)
class Mechanics:
    """Bodies without rebound: functions of coordinates, velocities, controls and time; `inverse` is that of the masses."""

    coordinates: int
    controls: tuple
    inverse: Callable
    force: Callable
    gaps: list
    running: Callable
    final: Callable
    start: list
    horizon: float
    goals: Any = None
    bounds: tuple = ()
    tangent: Any = None
    friction: float = 0.0
    more: dict = field(default_factory=dict)

    def build(self, grid):
        """Where a gap and its velocity are below zero, time stands still and bodies are pushed apart, with friction against the sliding."""
        n, m = self.coordinates, len(self.controls)
        x, u = ca.SX.sym("x", 2 * n + 2), ca.SX.sym("u", m)
        q, v, clock = x[:n], x[n : 2 * n], x[-1]
        inverse = self.inverse(q)
        distances = [gap(q) for gap in self.gaps]
        speeds = [ca.jtimes(gap, q, v) for gap in distances]
        slides = [ca.dot(self.tangent(q), v)] if self.tangent else []
        many = len(distances)
        above = ca.SX.sym("alpha", 2 * many + len(slides))
        closing = [(1 - above[i]) * (1 - above[many + i]) for i in range(many)]
        rub = self.friction * (2 * above[2 * many] - 1) * self.tangent(q) if slides else 0
        free = ca.vertcat(v, inverse @ self.force(q, v, u), self.running(q, v, u, clock), 1)
        pushes = [ca.vertcat(ca.SX.zeros(n), PUSH * inverse @ (ca.gradient(gap, q) - rub), 0, 0) for gap in distances]
        rates = free
        for part in closing:
            rates = (1 - part) * rates
        rates += sum(part * push for part, push in zip(closing, pushes))
        begin = np.array([*self.start, *[0.0] * (2 * n + 2 - len(self.start))])
        model = ns.NosnocModel(x=x, u=u, f_x=[rates], alpha=[above], c=[ca.vertcat(*distances, *speeds, *slides)], x0=begin, t_var=clock)
        return self.finished(grid, model, q, v)

    def finished(self, grid, model, q, v):
        n, x = self.coordinates, model.x
        total = x[-2] + self.final(q, v)
        inf = [np.inf]
        ocp = limits(self.controls, [*(self.bounds or inf * 2 * n), *inf * 2])
        if self.goals:
            ocp["g_terminal"] = self.goals(q, v)
        frozen = {"time_freezing": True, "time_freezing_tolerance": 0.0, "speed_of_time_variables": ns.SpeedOfTimeVariableMode.LOCAL, "pss_mode": ns.PssMode.STEP}
        worth = ca.Function("worth", [x], [total])
        chosen = options(grid, self.horizon, **frozen | self.more)
        return chosen, model, ns.NosnocOcp(f_terminal=total, **ocp), lambda end, _: float(worth(end))


def push_and_roll():
    return Mechanics(
        2, (5,), lambda q: ca.DM(np.diag([1, 0.5])), lambda q, v, u: ca.vertcat(u, 0), [lambda q: q[1] - q[0] - 1],
        lambda q, v, u, t: u**2, lambda q, v: 0, [-1, 1], 5.0, lambda q, v: ca.vertcat(q[1] - 3, v[1] - 0.5),
    )


BUFFERS = [lambda q: q[1] - q[0] - 2, lambda q: q[2] - q[1] - 2]


def three_carts():
    far = lambda q: (q[0] + 5) ** 2 + (q[2] - 5) ** 2
    return Mechanics(
        3, (30,), lambda q: ca.DM.eye(3), lambda q, v, u: ca.vertcat(0, u, 0), BUFFERS,
        lambda q, v, u, t: 10 * far(q) + 0.05 * u**2, lambda q, v: 100 * far(q), [-3, 0, 3], 4.0,
    )


def dragging_carts():
    away = lambda q, v: 10 * (q[0] + 5) ** 2 + q[1] ** 2 + 10 * (q[2] - 5) ** 2 + 0.1 * ca.dot(v, v)
    return Mechanics(
        3, (20,), lambda q: ca.DM.eye(3), lambda q, v, u: ca.vertcat(0, u, 0) - 2 * v, BUFFERS,
        lambda q, v, u, t: away(q, v) + 0.1 * u**2, lambda q, v: 100 * away(q, v), [-3, 0, 3], 5.0, None, ((-15, 10), 15, (-10, 15), 5, 5, 5),
    )


def discs(start, goal, horizon, drag):
    touch = lambda q: (q[0] - q[2]) ** 2 + (q[1] - q[3]) ** 2 - 0.25
    away = lambda q: 5 * ca.sumsqr(q[:2] - ca.DM(goal[:2])) + 10 * ca.sumsqr(q[2:] - ca.DM(goal[2:]))
    held = lambda v: drag * v / ca.norm_2(v + 0.1)
    force = lambda q, v, u: ca.vertcat(u, 0, 0) - (ca.vertcat(held(v[:2]), held(v[2:])) if drag else 0)
    return Mechanics(
        4, (20, 20), lambda q: ca.DM(np.diag([0.5, 0.5, 1, 1])), force, [touch], lambda q, v, u, t: away(q) + 0.1 * ca.sumsqr(u),
        lambda q, v: 100 * away(q), start, horizon, None, (10, 10, 10, 10, 5, 5, 5, 5),
    )


def hopper():
    """Without the condition that the foot does not slip, which is no law of its friction."""
    far = 0.7
    near = lambda q, s: (
        50 * (q[0] - 0.1 - (far - 0.1) * s) ** 2 + 50 * (q[1] - 0.5 - 1.2 * s * (1 - s)) ** 2 + 20 * q[2] ** 2 + 50 * (q[3] - 0.5 + 1.6 * s * (1 - s)) ** 2
    )
    final = lambda q, v: 300 * ((q[0] - far) ** 2 + (q[1] - 0.5) ** 2 + q[2] ** 2 + (q[3] - 0.5) ** 2) + 0.1 * ca.sumsqr(v)
    force = lambda q, v, u: ca.vertcat(-ca.sin(q[2]) * u[1], ca.cos(q[2]) * u[1] - 1.1 * 9.81, u[0], u[1])
    return Mechanics(
        4, (50, 50), lambda q: ca.DM(np.diag([1 / 1.1, 1 / 1.1, 1 / 0.275, 10])), force, [lambda q: q[1] - q[3] * ca.cos(q[2])],
        lambda q, v, u, t: near(q, t / 1.5) + 0.1 * ca.sumsqr(v) + 0.01 * ca.sumsqr(u), final, [0.1, 0.5, 0, 0.5], 1.5, None,
        ((0, 0.8), (0, 1.5), pi, (0.1, 0.5), np.inf, np.inf, np.inf, np.inf), lambda q: ca.vertcat(1, 0, q[3] * ca.cos(q[2]), ca.sin(q[2])), 0.45,
        {"sigma_0": 100.0},
    )


def ball_throw(grid):
    """A rebound by a spring and a damper below the ground, where time stands still."""
    x, u = ca.SX.sym("x", 6), ca.SX.sym("u", 2)
    stiff = 100.0
    damped = 2 * abs(log(0.9)) * sqrt(stiff / (pi**2 + log(0.9) ** 2))
    free = [x[2], x[3], u[0], u[1] - 9.81, ca.sumsqr(u), 1]
    below = [0, x[3], 0, -stiff * x[1] - damped * x[3], 0, 0]
    model = filippov(x, [(x[1], free, below)], [0, 0.5, 0, 0, 0, 0], u=u, t_var=x[5])
    total = x[4] + 100 * ca.sumsqr(x[2:4])
    rows = {"g_path": ca.sumsqr(u), "lbg": np.array([-np.inf]), "ubg": np.array([81.0]), "g_terminal": x[:2] - ca.vertcat(4, 0.5)}
    chosen = options(grid, 4.0, time_freezing=True, time_freezing_tolerance=0.0, speed_of_time_variables=ns.SpeedOfTimeVariableMode.LOCAL)
    worth = ca.Function("worth", [x], [total])
    return chosen, model, ns.NosnocOcp(f_terminal=total, **rows), lambda end, _: float(worth(end))


SIMULATIONS = list(simulations())
SHORT_COIL = {"horizon 80": "horizon 120"}
SHORT_TRACK = {"x == 5 [m]": "x == 3 [m]", "horizon 4": "horizon 2"}
PLANS = [
    Planned("turbo car, 25 m/s", "turbo-car", turbo_car(25), (20, 3, 2), "11.8 in closed form"),
    Planned("turbo car, 20 m/s", "turbo-car", turbo_car(20), (10, 3, 2), "40/3 in closed form", {"in -25..=25": "in -20..=20"}),
    Planned("turbo car with hysteresis", "hysteresis-car", hysteresis_car, (10, 3, 2), "10.1333 without a grid"),
    Planned("free start", "free-start", None, (1,), "1.523772775 at x(0) = -1.427572232"),
    Planned("plan with sliding modes", "sliding-plan", sliding_plan, (6, 6, 2), "6.61665325"),
    Planned("cascade of three tanks", "tank-plan", tank_plan, (20, 2, 2)),
    Planned("weaker motor", "weaker-above", weaker_above, (30, 2, 2)),
    Planned("voice coil, 80 ms", "voice-coil", voice_coil(0.08), (30, 2, 2)),
    Planned("voice coil, 120 ms", "voice-coil", voice_coil(0.12), (8, 4, 3), "", SHORT_COIL),
    Planned("race car", "race-car", race_car, (6, 3, 2), "", SHORT_TRACK),
    Planned("carts that drag", "carts", lambda grid: dragging_carts().build(grid), (20, 3, 2)),
    Planned("hopper", "hopper", lambda grid: hopper().build(grid), (20, 3, 2)),
    Planned("disc that pushes another one", "disc-push", lambda grid: discs([-1, -2, -1, -1], [-1, 1, 0, 0], 2.0, 0).build(grid), (15, 2, 2)),
    Planned("discs that change places", "discs-swap", lambda grid: discs([-1, 0, 1, 0], [1, 0, -1, 0], 3.0, 2).build(grid), (20, 3, 2)),
    Planned("thrown ball", "ball-throw", ball_throw, (20, 5, 4)),
    *[Planned(f"rough block, N = {n}", "rough-block", rough_block, (n, 3, 2)) for n in (10, 20)],
    *[Planned(f"push and roll, N = {n}", "push-and-roll", lambda grid: push_and_roll().build(grid), (n, 3, 2)) for n in (10, 20)],
    *[Planned(f"three carts, N = {n}", "three-carts", lambda grid: three_carts().build(grid), (n, 3, 2)) for n in (10, 20)],
]
