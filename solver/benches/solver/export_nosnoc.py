"""Writes the complementarity problem behind an example of nosnoc_py as text, in vertical form.

usage: python export_nosnoc.py EXAMPLE.py FUNCTION NAME [option=value ...] > NAME.txt

EXAMPLE.py is a script of the examples folder of nosnoc_py 0.2.0, FUNCTION the function in it that builds and
solves a problem; the solve is replaced by the export. Options override fields of NosnocOpts (for instance
N_stages=10). Pairs (G, H) are recorded where nosnoc_py would relax them; a side that is not a variable gets
one, and equal sides share it. Format: see tests/solver_support/mod.rs.
"""

import importlib.util
import math
import os
import sys

import casadi as ca
import matplotlib
import numpy as np

matplotlib.use("Agg")
import nosnoc
import nosnoc.problem
import nosnoc.solver

PAIRS = []


class Exported(BaseException):
    pass


def record(self, x, y, sigma, tau, s_elastic):
    side = x[0]
    for term in x[1:]:
        side = side + term
    if side.numel() == 1 and y.numel() > 1:
        side = ca.repmat(side, y.numel(), 1)
    PAIRS.extend((side[i], y[i]) for i in range(y.numel()))


def number(value):
    if math.isinf(value):
        return "inf" if value > 0 else "-inf"
    value = float(value)
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)


def tape(x, expression):
    """The expression as nodes that refer to earlier nodes."""
    function = ca.Function("f", [x], [expression])
    binary = {ca.OP_ADD: "+", ca.OP_SUB: "-", ca.OP_MUL: "*", ca.OP_DIV: "/"}
    unary = {ca.OP_NEG: "neg", ca.OP_EXP: "exp", ca.OP_LOG: "log", ca.OP_SQRT: "sqrt", ca.OP_SIN: "sin",
             ca.OP_COS: "cos", ca.OP_ATAN: "atan", ca.OP_TANH: "tanh", ca.OP_INV: "inv"}
    nodes, place, result = [], {}, None

    def add(word):
        nodes.append(word)
        return len(nodes) - 1

    for k in range(function.n_instructions()):
        code = function.instruction_id(k)
        target, source = function.instruction_output(k), function.instruction_input(k)
        if code == ca.OP_CONST:
            place[target[0]] = add("#" + number(function.instruction_constant(k)))
        elif code == ca.OP_INPUT:
            place[target[0]] = add(f"x{source[1] + 1}")
        elif code == ca.OP_OUTPUT:
            result = place[source[0]]
        elif code in binary:
            place[target[0]] = add(f"{binary[code]}{place[source[0]]},{place[source[1]]}")
        elif code in unary:
            place[target[0]] = add(f"{unary[code]}{place[source[0]]}")
        elif code in (ca.OP_SQ, ca.OP_TWICE):
            argument = place[source[0]]
            place[target[0]] = add(f"{'*' if code == ca.OP_SQ else '+'}{argument},{argument}")
        elif code == ca.OP_TAN:
            sine, cosine = add(f"sin{place[source[0]]}"), add(f"cos{place[source[0]]}")
            place[target[0]] = add(f"/{sine},{cosine}")
        elif code in (ca.OP_CONSTPOW, ca.OP_POW):
            exponent = nodes[place[source[1]]]
            assert exponent[0] == "#"
            place[target[0]] = add(f"pow{place[source[0]]},{exponent[1:]}")
        else:
            raise NotImplementedError(f"operation {code}")
    if result != len(nodes) - 1:
        zero = add("#0")
        add(f"+{result},{zero}")
    return "tape " + " ".join(nodes)


def terms(cost):
    """The summands of a sum, so that its Hessian stays sparse."""
    stack, found = [cost], []
    while stack:
        term = stack.pop()
        if not term.is_constant() and not term.is_symbolic() and term.op() == ca.OP_ADD:
            stack += [term.dep(1), term.dep(0)]
        elif not (term.is_constant() and float(term) == 0):
            found.append(term)
    return found


def export(solver, name):
    problem = solver.problem
    solver.initialize()
    solver.setup_p_val(1.0, 1.0)
    w, p, values = problem.w, problem.p, ca.DM(solver.p_val)
    cost, rows = ca.substitute([problem.cost, problem.g], [p], [values])
    position = {w[i].name(): i for i in range(w.numel())}
    lower, upper, start = (list(np.array(v, dtype=float).flatten()) for v in (problem.lbw, problem.ubw, problem.w0))
    slacks, known, pairs = [], {}, []

    def side(expression):
        expression = ca.substitute(expression, p, values)
        if expression.is_constant():
            return None
        if expression.is_symbolic():
            return position[expression.name()]
        key = str(expression)
        if key not in known:
            known[key] = w.numel() + len(slacks)
            slacks.append(expression)
            value = float(ca.Function("v", [w], [expression])(start[: w.numel()]))
            lower.append(0.0)
            upper.append(math.inf)
            start.append(max(0.0, value))
        return known[key]

    for first, second in PAIRS:
        pair = side(first), side(second)
        if None not in pair and pair not in pairs and pair[::-1] not in pairs:
            pairs.append(pair)
    x = ca.vertcat(w, *[ca.SX.sym(f"s{i}") for i in range(len(slacks))])
    print(f"problem {name} {x.numel()}")
    print("start", " ".join(map(number, start)))
    for k in {k for pair in pairs for k in pair}:
        lower[k] = 0.0
    for k, (l, u) in enumerate(zip(lower, upper)):
        if not (math.isinf(l) and math.isinf(u)):
            print("bounds", k + 1, number(l), number(u))
    for term in terms(cost) or [ca.SX(0)]:
        print("minimize", tape(x, term))
    for i in range(rows.numel()):
        if not rows[i].is_constant():
            print("row", number(problem.lbg[i]), number(problem.ubg[i]), tape(x, rows[i]))
    for i, expression in enumerate(slacks):
        print("row 0 0", tape(x, expression - x[w.numel() + i]))
    for i, j in pairs:
        print("pair", i + 1, j + 1)


def main():
    path, function, name = sys.argv[1:4]
    overrides = dict(option.split("=") for option in sys.argv[4:])
    for item in vars(nosnoc.problem).values():
        if isinstance(item, type) and "create_complementarity" in vars(item):
            item.create_complementarity = record

    def solve(self, *_, **__):
        export(self, name)
        raise Exported

    nosnoc.solver.NosnocSolver.solve = nosnoc.NosnocSolver.solve = solve
    preprocess = nosnoc.NosnocOpts.preprocess

    def override(self):
        for key, value in overrides.items():
            setattr(self, key, int(value))
        return preprocess(self)

    nosnoc.NosnocOpts.preprocess = override
    path = os.path.abspath(path)
    sys.path.insert(0, os.path.dirname(path))
    os.chdir(os.path.dirname(path))
    spec = importlib.util.spec_from_file_location("example", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    try:
        getattr(module, function)()
    except Exported:
        pass


if __name__ == "__main__":
    main()
