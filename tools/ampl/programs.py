"""Ten programs in Pyomo, solved by hangtime through AMPL's protocol and compared with IPOPT.

Needs `pip install pyomo casadi` and the program `hangtime` on the path, or its path as the first argument. Every program is solved as users solve
them, without a wrapper; values and duals are compared with those of IPOPT (which comes with CasADi) on the same functions, or
with closed forms where a program has complementarity.
"""

import sys

import casadi
import pyomo.environ as pyo
from pyomo.mpec import Complementarity, complements

HANGTIME = sys.argv[1] if len(sys.argv) > 1 else "hangtime"
# both solvers stop at 1e-8; duals follow the point with the condition of the program, below 1e3 here
TOLERANCE = 1e-5


class Program:
    """min f(x) s.t. lower <= g(x) <= upper, x in bounds: functions that Pyomo's and CasADi's expressions both go through."""

    def __init__(self, name, start, f, rows=(), bounds=None):
        self.name, self.start, self.f, self.rows = name, start, f, rows
        self.bounds = bounds or [(None, None)] * len(start)

    def by_hangtime(self, options):
        m = pyo.ConcreteModel()
        n = range(len(self.start))
        m.x = pyo.Var(n, bounds=lambda m, i: self.bounds[i], initialize=lambda m, i: self.start[i])
        m.f = pyo.Objective(expr=self.f(m.x, pyo))
        m.g = pyo.ConstraintList()
        for lower, row, upper in self.rows:
            body = row(m.x, pyo)
            m.g.add(body == lower if lower == upper else pyo.inequality(lower, body, upper))
        m.dual = pyo.Suffix(direction=pyo.Suffix.IMPORT_EXPORT)
        m.ipopt_zL_out = pyo.Suffix(direction=pyo.Suffix.IMPORT)
        solver = pyo.SolverFactory("asl:" + HANGTIME)
        result = solver.solve(m, options=options)
        duals = [m.dual[m.g[k + 1]] for k in range(len(self.rows))]
        return result, [m.x[i].value for i in n], duals

    def by_ipopt(self):
        x = casadi.MX.sym("x", len(self.start))
        parts = [x[i] for i in range(len(self.start))]
        rows = [row(parts, casadi) for _, row, _ in self.rows]
        solver = casadi.nlpsol(
            "s", "ipopt", {"x": x, "f": self.f(parts, casadi), "g": casadi.vertcat(*rows)},
            {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-9}},
        )
        none = lambda value, sign: sign * casadi.inf if value is None else value
        found = solver(
            x0=self.start,
            lbx=[none(b[0], -1) for b in self.bounds], ubx=[none(b[1], 1) for b in self.bounds],
            lbg=[none(r[0], -1) for r in self.rows], ubg=[none(r[2], 1) for r in self.rows],
        )
        # CasADi's multipliers are those of f + y g, Pyomo's the rates of change with the sides
        return [float(v) for v in found["x"].full().ravel()], [-float(y) for y in found["lam_g"].full().ravel()]


PROGRAMS = [
    Program("rosenbrock", [-1.2, 1], lambda x, f: 100 * (x[1] - x[0] ** 2) ** 2 + (1 - x[0]) ** 2),
    Program("circle", [1, 1], lambda x, f: x[0] + 2 * x[1], [(None, lambda x, f: x[0] ** 2 + x[1] ** 2, 5)]),
    Program("equation", [2, 2, 2], lambda x, f: x[0] ** 2 + 2 * x[1] ** 2 + 3 * x[2] ** 2, [(6, lambda x, f: x[0] + x[1] + x[2], 6)]),
    Program("hs71", [1, 5, 5, 1], lambda x, f: x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2],
            [(25, lambda x, f: x[0] * x[1] * x[2] * x[3], None), (40, lambda x, f: sum(x[i] ** 2 for i in range(4)), 40)], [(1, 5)] * 4),
    Program("entropy", [0.3, 0.3, 0.4], lambda x, f: sum(x[i] * f.log(x[i]) + i * x[i] for i in range(3)),
            [(1, lambda x, f: x[0] + x[1] + x[2], 1)], [(1e-6, 1)] * 3),
    Program("range", [0, 0], lambda x, f: (x[0] - 3) ** 2 + f.exp(x[1]), [(-1, lambda x, f: x[0] + x[1], 1), (-2, lambda x, f: x[1], None)]),
    Program("catenary", [0.1] * 5, lambda x, f: sum((6 - i - 0.5) * f.sin(x[i]) for i in range(5)), [(3.5, lambda x, f: sum(f.cos(x[i]) for i in range(5)), 3.5)], [(-1.5, 1.5)] * 5),
    Program("knapsack", [0.5, 0.5, 0.5], lambda x, f: -4 * x[0] - 3 * x[1] - 5 * x[2], [(None, lambda x, f: 2 * x[0] + x[1] + 3 * x[2], 4)], [(0, 1)] * 3),
]


def complementary(lower):
    """The point of `x + y = s, 0 <= x _|_ y >= lower` nearest (2, 1), by hand: one of two rays."""
    m = pyo.ConcreteModel()
    m.x, m.y = pyo.Var(initialize=1.0), pyo.Var(initialize=0.5)
    m.f = pyo.Objective(expr=(m.x - 2) ** 2 + (m.y - 1) ** 2)
    m.c = Complementarity(expr=complements(m.x >= 0, m.y - lower >= 0))
    pyo.SolverFactory("asl:" + HANGTIME).solve(m)
    # on y = lower the distance is (1 - lower)^2, on x = 0 it is 4
    return abs(m.x.value - 2) + abs(m.y.value - lower)


def main():
    worst = 0.0
    for program in PROGRAMS:
        result, x, duals = program.by_hangtime({"tol": 1e-9, "print_level": 0})
        assert str(result.solver.termination_condition) == "optimal", program.name
        other, of_ipopt = program.by_ipopt()
        error = max(abs(a - b) for a, b in zip(x + duals, other + of_ipopt))
        print(f"{program.name:12} {error:.1e}  duals {['%.6f' % d for d in duals]}")
        worst = max(worst, error)
    for lower in (0.0, 0.5):
        error = complementary(lower)
        print(f"complements {lower} {error:.1e}")
        worst = max(worst, error)
    limited, _, _ = PROGRAMS[0].by_hangtime({"max_iter": 2, "print_level": 0})
    assert str(limited.solver.termination_condition) != "optimal"
    print(f"largest difference {worst:.1e}, allowed {TOLERANCE}")
    return worst > TOLERANCE


if __name__ == "__main__":
    sys.exit(main())
