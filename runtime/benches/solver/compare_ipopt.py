"""Solves text problems with IPOPT (CasADi wheel, MUMPS) and prints iterations, CPU time and objective.

usage: python compare_ipopt.py file.txt [file.txt ...]

Format of the files: see tests/solver_support/mod.rs. CPU time is that of the solver call, function
evaluation by CasADi's virtual machine included; `linear` is what remains after evaluations.
"""

import math
import sys
import time

import casadi as ca


def read(path):
    problems = []
    with open(path) as file:
        for line in file:
            line = line.strip()
            if not line or line.startswith("#"):
                continue
            word, _, rest = line.partition(" ")
            if word == "problem":
                name, n = rest.split()
                n = int(n)
                problems.append(
                    dict(name=name, n=n, lower=[-math.inf] * n, upper=[math.inf] * n,
                         start=[0.0] * n, objective=[], rows=[], pairs=[])
                )
                continue
            problem = problems[-1]
            if word == "start":
                problem["start"] = [float(a) for a in rest.split()]
            elif word == "bounds":
                k, lower, upper = rest.split()
                problem["lower"][int(k) - 1] = float(lower)
                problem["upper"][int(k) - 1] = float(upper)
            elif word == "minimize":
                problem["objective"].append(rest)
            elif word == "row":
                lower, upper, expression = rest.split(" ", 2)
                problem["rows"].append((float(lower), float(upper), expression))
            elif word == "pair":
                i, j = rest.split()
                problem["pairs"].append((int(i) - 1, int(j) - 1))
    return problems


def solve(problem, options):
    x = ca.SX.sym("x", problem["n"])
    names = {f"x{i + 1}": x[i] for i in range(problem["n"])}
    for function in ("exp", "log", "sqrt", "sin", "cos", "atan", "tanh"):
        names[function] = getattr(ca, function)
    evaluate = lambda text: ca.SX(eval(text.replace("^", "**"), names))
    objective = ca.SX(0)
    for term in problem["objective"]:
        objective += evaluate(term)
    rows = [evaluate(text) for _, _, text in problem["rows"]]
    nlp = dict(x=x, f=objective, g=ca.vertcat(*rows) if rows else ca.SX(0, 1))
    defaults = {"ipopt.print_level": 0, "print_time": 0, "ipopt.sb": "yes",
                "error_on_fail": False, "ipopt.max_iter": 1000, "ipopt.max_cpu_time": 120.0}
    solver = ca.nlpsol("solver", "ipopt", nlp, defaults | options)
    bounds = [(lower, upper) for lower, upper, _ in problem["rows"]]
    start = time.process_time()
    result = solver(x0=problem["start"], lbx=problem["lower"], ubx=problem["upper"],
                    lbg=[b[0] for b in bounds], ubg=[b[1] for b in bounds])
    seconds = time.process_time() - start
    return solver.stats(), seconds, float(result["f"])


def main():
    print("problem status iterations seconds linear objective")
    for path in sys.argv[1:]:
        for problem in read(path):
            stats, seconds, objective = solve(problem, {})
            evaluation = sum(v for k, v in stats.items() if k.startswith("t_wall_nlp_"))
            print(problem["name"], stats["return_status"], stats["iter_count"],
                  f"{seconds:.4f} {seconds - evaluation:.4f} {objective:.10e}", flush=True)


if __name__ == "__main__":
    main()
