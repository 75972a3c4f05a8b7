"""Pyomo takes the program ``hangtime`` as a solver, without a wrapper."""

import math
import os
import pathlib

import numpy as np
import pytest
from conftest import PROGRAM

pyo = pytest.importorskip("pyomo.environ", reason="Pyomo is not installed")
mpec = pytest.importorskip("pyomo.mpec")


@pytest.fixture
def solver(monkeypatch):
    """As a user finds it: by its name on the path."""
    folder = str(pathlib.Path(PROGRAM).parent)
    monkeypatch.setenv("PATH", folder + os.pathsep + os.environ["PATH"])
    # Pyomo remembers what it has found on a path from before.
    from pyomo.common import Executable

    Executable.rehash()
    return pyo.SolverFactory("hangtime")


def model(**variables):
    m = pyo.ConcreteModel()
    for name, (start, *bounds) in variables.items():
        m.add_component(name, pyo.Var(initialize=start, bounds=tuple(bounds) or None))
    m.dual = pyo.Suffix(direction=pyo.Suffix.IMPORT)
    m.ipopt_zL_out = pyo.Suffix(direction=pyo.Suffix.IMPORT)
    m.ipopt_zU_out = pyo.Suffix(direction=pyo.Suffix.IMPORT)
    return m


def projection():
    """The point of ``x + y <= 2`` nearest to (2, 1)."""
    m = model(x=(0,), y=(0,))
    m.c = pyo.Constraint(expr=m.x + m.y <= 2)
    m.o = pyo.Objective(expr=(m.x - 2) ** 2 + (m.y - 1) ** 2)
    return m, {"x": 1.5, "y": 0.5}, 0.5, {"c": -1}


def production():
    """A linear program that is maximized: rates of change of what is maximized, so of the other sign."""
    m = model(x=(1, 0, 3), y=(1, 0, None))
    m.c = pyo.Constraint(expr=m.x + m.y <= 4)
    m.d = pyo.Constraint(expr=m.x + 3 * m.y <= 7)
    m.o = pyo.Objective(expr=3 * m.x + 2 * m.y, sense=pyo.maximize)
    return m, {"x": 3, "y": 1}, 11, {"c": 2, "d": 0}


def can():
    """The least surface of a can of volume 1."""
    m = model(r=(1, 0.01, None), h=(1, 0.01, None))
    m.c = pyo.Constraint(expr=math.pi * m.r**2 * m.h == 1)
    m.o = pyo.Objective(expr=2 * math.pi * m.r * (m.r + m.h))
    r = (2 * math.pi) ** (-1 / 3)
    return m, {"r": r, "h": 2 * r}, 3 * (2 * math.pi) ** (1 / 3), {"c": 2 * (2 * math.pi) ** (1 / 3)}


def entropy():
    """Of five numbers with sum 1 the evenly spread ones have the most entropy."""
    m = model()
    m.p = pyo.Var(range(5), initialize=lambda m, i: 0.05 + 0.05 * i, bounds=(1e-8, 1))
    m.c = pyo.Constraint(expr=sum(m.p[i] for i in m.p) == 1)
    m.o = pyo.Objective(expr=sum(m.p[i] * pyo.log(m.p[i]) for i in m.p))
    return m, {f"p[{i}]": 0.2 for i in range(5)}, -math.log(5), {"c": 1 - math.log(5)}


def rosenbrock():
    """The valley of Rosenbrock within the unit disk; its values are those that IPOPT has as well."""
    m = model(x=(-0.5,), y=(0.5,))
    m.c = pyo.Constraint(expr=m.x**2 + m.y**2 <= 1)
    m.o = pyo.Objective(expr=100 * (m.y - m.x**2) ** 2 + (1 - m.x) ** 2)
    return m, {"x": 0.7864151510, "y": 0.6176983125}, 0.0456748087, {}


def hock_schittkowski_71():
    """Problem 71 of Hock and Schittkowski, with its published optimum."""
    m = model()
    m.x = pyo.Var(range(1, 5), initialize=lambda m, i: [1, 5, 5, 1][i - 1], bounds=(1, 5))
    x = m.x
    m.c = pyo.Constraint(expr=x[1] * x[2] * x[3] * x[4] >= 25)
    m.d = pyo.Constraint(expr=sum(x[i] ** 2 for i in x) == 40)
    m.o = pyo.Objective(expr=x[1] * x[4] * (x[1] + x[2] + x[3]) + x[3])
    found = {"x[1]": 1, "x[2]": 4.7429994, "x[3]": 3.8211503, "x[4]": 1.3794082}
    return m, found, 17.0140173, {}


def exponential_fit():
    """Rates of an exponential through exact data: the sum of squares vanishes."""
    m = model(a=(1,), b=(0,))
    t = np.linspace(0, 2, 9)
    m.o = pyo.Objective(expr=sum((m.a * pyo.exp(m.b * s) - 2 * math.exp(-1.5 * s)) ** 2 for s in map(float, t)))
    return m, {"a": 2, "b": -1.5}, 0, {}


def follower():
    """A leader sells ``x`` at the price ``10 - x - y``; the follower's ``y`` is the best answer, ``(9 - x)/2``."""
    m = model(x=(1, 0, None), y=(1,))
    m.k = mpec.Complementarity(expr=mpec.complements(m.y >= 0, m.x + 2 * m.y - 9 >= 0))
    m.o = pyo.Objective(expr=m.x * (9 - m.x - m.y), sense=pyo.maximize)
    return m, {"x": 4.5, "y": 2.25}, 10.125, {}


def bard():
    """Problem 1 of Bard, 1988, with the follower's optimality conditions: 17 at (1, 0)."""
    m = model(x=(2, 0, None), y=(0, 0, None), k=(0, 0, None), l=(0, 0, None), n=(0, 0, None))
    m.c = pyo.Constraint(expr=2 * (m.y - 1) - 1.5 * m.x + m.k - 0.5 * m.l + m.n == 0)
    m.s = mpec.Complementarity(expr=mpec.complements(m.k >= 0, 3 * m.x - m.y - 3 >= 0))
    m.t = mpec.Complementarity(expr=mpec.complements(m.l >= 0, -m.x + 0.5 * m.y + 4 >= 0))
    m.u = mpec.Complementarity(expr=mpec.complements(m.n >= 0, -m.x - m.y + 7 >= 0))
    m.o = pyo.Objective(expr=(m.x - 5) ** 2 + (2 * m.y + 1) ** 2)
    return m, {"x": 1, "y": 0}, 17, {}


def obstacle():
    """A loaded string over a floor at -1: it rests on the middle, and is a parabola beside.

    ``w'' = 8`` from ``w(0) = 0`` to where it touches with slope 0, half its length away: ``w = 4 (s - 1/2)^2 - 1`` with
    differences that are exact for parabolas; so of seventeen nodes over the length 2 the middle ones, from 1/2 to 3/2, rest.
    """
    m = model()
    n, h = 15, 1 / 8
    m.w = pyo.Var(range(n), initialize=0)
    m.k = pyo.Block(range(n))
    for i in range(n):
        left = m.w[i - 1] if i else 0
        right = m.w[i + 1] if i + 1 < n else 0
        force = (2 * m.w[i] - left - right) / h**2 + 8
        m.k[i].c = mpec.Complementarity(expr=mpec.complements(m.w[i] + 1 >= 0, force >= 0))
    m.o = pyo.Objective(expr=0 * m.w[0])
    s = h * np.arange(1, n + 1)
    s = np.minimum(s, 2 - s)
    found = np.where(s < 0.5, 4 * (s - 0.5) ** 2 - 1, -1)
    return m, {f"w[{i}]": w for i, w in enumerate(found)}, 0, {}


PROGRAMS = [
    projection, production, can, entropy, rosenbrock, hock_schittkowski_71, exponential_fit, follower, bard, obstacle
]  # fmt: skip
#: Published and printed values have eight digits; the solver's tolerance is 1e-8 relative to the program's scale, and
#: a solution of a least squares problem has the root of that.
CLOSE = 2e-6


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda program: program.__name__)
def test_pyomo_solves(solver, program):
    assert solver.available(exception_flag=False), "Pyomo does not find the solver by its name"
    m, found, objective, duals = program()
    results = solver.solve(m)
    pyo.assert_optimal_termination(results)
    for name, value in found.items():
        assert m.find_component(name)() == pytest.approx(value, abs=CLOSE), name
    assert m.o() == pytest.approx(objective, abs=CLOSE)
    for name, value in duals.items():
        assert m.dual[m.find_component(name)] == pytest.approx(value, abs=CLOSE), name
    # The certificate comes back as a suffix of the problem.
    assert "solved" in results.solver.message


def ipopt(m, folder):
    """What IPOPT says of the file that Pyomo writes: rates with the rows, and the bounds, in the order of the file."""
    casadi = pytest.importorskip("casadi", reason="CasADi, whose wheel holds IPOPT, is not installed")
    # First for the files of names; with them the file has comments, which CasADi does not read.
    for labels in (True, False):
        m.write(str(folder / "p.nl"), io_options={"symbolic_solver_labels": labels})
    program = casadi.NlpBuilder()
    program.import_nl(str(folder / "p.nl"))
    # It states a maximum as the minimum of the negative.
    sign = -1 if m.o.sense == pyo.maximize else 1
    functions = {"x": casadi.vertcat(*program.x), "f": program.f, "g": casadi.vertcat(*program.g)}
    quiet = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-10}}
    solve = casadi.nlpsol("solve", "ipopt", functions, quiet)
    end = solve(x0=program.x_init, lbx=program.x_lb, ubx=program.x_ub, lbg=program.g_lb, ubg=program.g_ub)
    assert solve.stats()["success"]
    rows = (folder / "p.row").read_text().split()[: len(program.g)]
    columns = (folder / "p.col").read_text().split()
    values = {name: np.array(end[name]).ravel() for name in ("x", "lam_g", "lam_x")}
    return (
        dict(zip(columns, values["x"])),
        dict(zip(rows, -sign * values["lam_g"])),
        dict(zip(columns, -sign * values["lam_x"])),
    )


@pytest.mark.parametrize("program", PROGRAMS[:7], ids=lambda program: program.__name__)
def test_points_and_duals_agree_with_ipopt(solver, program, tmp_path):
    m, *_ = program()
    x, rows, bounds = ipopt(m, tmp_path)
    pyo.assert_optimal_termination(solver.solve(m))
    for name, value in x.items():
        assert m.find_component(name)() == pytest.approx(value, abs=CLOSE), name
    for name, value in rows.items():
        assert m.dual[m.find_component(name)] == pytest.approx(value, abs=CLOSE), name
    for name, value in bounds.items():
        variable = m.find_component(name)
        rate = m.ipopt_zL_out.get(variable, 0) + m.ipopt_zU_out.get(variable, 0)
        assert rate == pytest.approx(value, abs=CLOSE), name


def test_options_act(solver):
    m, *_ = rosenbrock()
    results = solver.solve(m, options={"max_iter": 3}, load_solutions=False)
    assert results.solver.termination_condition == pyo.TerminationCondition.maxIterations
    results = solver.solve(m, options={"tol": 1e-3})
    loose = iterations(results)
    m, *_ = rosenbrock()
    assert loose < iterations(solver.solve(m, options={"tol": 1e-11}))
    # In each of its starts a program of a circle and a line has one of two ends; of several the better one is kept.
    m = model(x=(0.5,), y=(0.2,))
    m.c = pyo.Constraint(expr=m.x**2 + m.y**2 == 1)
    m.o = pyo.Objective(expr=m.y**2 + 0.1 * m.x)
    solver.solve(m)
    assert m.o() == pytest.approx(0.1, abs=1e-6)
    m.x, m.y = 0.5, 0.2
    solver.solve(m, options={"starts": 12})
    assert m.o() == pytest.approx(-0.1, abs=1e-6)


def iterations(results):
    return int(results.solver.message.split("; ")[2].split()[0])


def test_log_is_that_of_a_solver_and_can_be_silenced(solver, capfd):
    m, *_ = can()
    solver.solve(m, tee=True)
    log = capfd.readouterr().out
    assert "inf_pr" in log and "hangtime: solved" in log
    solver.solve(m, tee=True, options={"print_level": 0})
    assert "inf_pr" not in capfd.readouterr().out


def test_start_from_multipliers_takes_at_most_a_third_of_the_iterations(solver):
    m, *_ = hock_schittkowski_71()
    cold = iterations(solver.solve(m))
    for suffix in ("dual", "ipopt_zL_in", "ipopt_zU_in"):
        if suffix != "dual":
            m.add_component(suffix, pyo.Suffix(direction=pyo.Suffix.EXPORT))
    m.dual.direction = pyo.Suffix.IMPORT_EXPORT
    m.ipopt_zL_in.update(m.ipopt_zL_out)
    m.ipopt_zU_in.update(m.ipopt_zU_out)
    m.c.set_value(m.x[1] * m.x[2] * m.x[3] * m.x[4] >= 25.01)
    warm = iterations(solver.solve(m))
    assert 3 * warm <= cold, (warm, cold)


def test_what_cannot_be_solved_is_told_by_its_condition(solver):
    m = model(x=(0.5, 0, 1))
    m.c = pyo.Constraint(expr=m.x**2 >= 2)
    m.o = pyo.Objective(expr=m.x)
    results = solver.solve(m, load_solutions=False)
    assert results.solver.termination_condition == pyo.TerminationCondition.infeasible
    m = model(x=(0.5,))
    m.o = pyo.Objective(expr=m.x)
    results = solver.solve(m, load_solutions=False)
    assert results.solver.termination_condition == pyo.TerminationCondition.unbounded
    for text, variables, objective, options in [
        ("whole number", {"domain": pyo.Integers, "initialize": 1}, lambda x: x**2, {}),
        ("not finite", {"initialize": -1}, lambda x: pyo.log(x), {}),
        ("no option", {"initialize": 1}, lambda x: x**2, {"toll": 1}),
    ]:
        m = pyo.ConcreteModel()
        m.x = pyo.Var(**variables)
        m.o = pyo.Objective(expr=objective(m.x))
        results = solver.solve(m, load_solutions=False, options=options)
        assert results.solver.status != pyo.SolverStatus.ok
        assert text in results.solver.message, results.solver.message
