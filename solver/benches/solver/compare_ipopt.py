"""Solves text problems with IPOPT (CasADi wheel, MUMPS) and prints iterations, CPU time and objective.

usage: python compare_ipopt.py [--solver EXECUTABLE] file.txt [file.txt ...]

Format of the files: see tests/solver_support/mod.rs. CPU seconds are those of the solver call, the fastest of three
(of one beyond a second); the model is built before. `evaluation` is what CasADi's virtual machine takes of them. With
the executable of the benchmark `solver` each problem is solved by both in turn, and a table in Markdown compares them.
"""

import math
import statistics
import subprocess
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
    best = None
    for _ in range(3):
        start = time.process_time()
        result = solver(x0=problem["start"], lbx=problem["lower"], ubx=problem["upper"],
                        lbg=[b[0] for b in bounds], ubg=[b[1] for b in bounds])
        seconds = time.process_time() - start
        stats = solver.stats()
        evaluation = sum(v for k, v in stats.items() if k.startswith("t_proc_nlp_"))
        if best is None or seconds < best[1]:
            best = (stats, seconds, evaluation, float(result["f"]))
        if seconds > 1.0:
            break
    return best


def ours(executable, name, times):
    """The line of the benchmark as a dictionary."""
    output = subprocess.run([executable, "nlp", name, str(times)], capture_output=True, text=True, check=True)
    heading, line = [line.split() for line in output.stdout.splitlines()]
    return dict(zip(heading, line))


def compare(executable, paths):
    print("| problem | variables | rows | iterations IPOPT | iterations | CPU IPOPT (evaluation) [ms] "
          "| CPU (evaluation, linear algebra) [ms] | ratio |")
    print("|" + "---|" * 8)
    ratios = []
    for path in paths:
        for problem in read(path):
            stats, seconds, evaluation, objective = solve(problem, {})
            own = ours(executable, problem["name"], 1 if seconds > 1.0 else 3)
            ratios.append(float(own["cpu"]) / seconds)
            ms = lambda text: f"{1e3 * float(text):.1f}"
            print(f"| {problem['name']} | {own['variables']} | {own['rows']} | {stats['iter_count']} "
                  f"| {own['iterations']} | {ms(seconds)} ({ms(evaluation)}) | {ms(own['cpu'])} "
                  f"({ms(own['evaluation'])}, {ms(own['linear'])}) | {ratios[-1]:.2f} |", flush=True)
            if stats["return_status"] != "Solve_Succeeded" or own["status"] != "Solved":
                print(problem["name"], stats["return_status"], own["status"], file=sys.stderr)
            difference = abs(objective - float(own["objective"])) / max(1.0, abs(objective))
            if difference > 1e-6:
                print(problem["name"], objective, own["objective"], file=sys.stderr)
    print(f"| **median** | | | | | | | **{statistics.median(ratios):.2f}** |")


def main():
    arguments = sys.argv[1:]
    if arguments[:1] == ["--solver"]:
        compare(arguments[1], arguments[2:])
        return
    print("problem status iterations seconds evaluation objective")
    for path in arguments:
        for problem in read(path):
            stats, seconds, evaluation, objective = solve(problem, {})
            print(problem["name"], stats["return_status"], stats["iter_count"],
                  f"{seconds:.4f} {evaluation:.4f} {objective:.10e}", flush=True)


if __name__ == "__main__":
    main()
