#!/usr/bin/env python3
"""Solves `.nl` files by IPOPT with default options, for comparison: `python3 tools/problems/ipopt.py FILE.nl --limit 60`."""

import argparse
import json
import time

import casadi as ca


def solve(path, limit):
    """Status, iterations, objective, violation and seconds of processor time of a run; building derivatives is not counted."""
    program = ca.NlpBuilder()
    program.import_nl(str(path))
    x = ca.SX.sym("x", len(program.x))
    functions = ca.Function("program", [ca.vertcat(*program.x)], [program.f, ca.vertcat(*program.g)]).expand()
    f, g = functions(x)
    options = {"print_time": False, "error_on_fail": False, "ipopt": {"max_iter": 3000, "max_cpu_time": limit, "print_level": 0, "sb": "yes"}}
    solver = ca.nlpsol("ipopt", "ipopt", {"x": x, "f": f, "g": ca.SX(g)}, options)
    before = time.process_time()
    end = solver(x0=program.x_init, lbx=program.x_lb, ubx=program.x_ub, lbg=program.g_lb, ubg=program.g_ub)
    seconds = time.process_time() - before
    stats = solver.stats()
    far = lambda value, lower, upper: [max(l - v, v - u, 0.0) for v, l, u in zip(value, lower, upper)]
    violation = far(ca.vertsplit(end["g"]), program.g_lb, program.g_ub) + far(ca.vertsplit(end["x"]), program.x_lb, program.x_ub)
    # with more equations than variables it does not begin, and its counts are not set
    begun = stats["return_status"] != "Not_Enough_Degrees_Of_Freedom"
    return {"status": stats["return_status"], "iterations": stats["iter_count"] if begun else 0, "objective": float(end["f"]),
            "violation": max(map(float, violation), default=0.0), "seconds": seconds}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+")
    parser.add_argument("--limit", type=float, default=60)
    arguments = parser.parse_args()
    for path in arguments.files:
        print(json.dumps(solve(path, arguments.limit)), flush=True)


if __name__ == "__main__":
    main()
