#!/usr/bin/env python3
"""Solves a public problem set and writes a table of it: `python3 tools/problems/run.py macmpec` or `nosbench`.

Fetches what is missing into target/problems (git, and the Python package casadi, which states the problems), builds the
program, solves every problem with its default settings, and writes docs/experiments/SET.md with the table SET.csv. Clones that are there already
are named by --clone.
"""

import argparse
import csv
import json
import os
import pathlib
import random
import resource
import signal
import statistics
import subprocess
import sys
import time

import sets

LIMIT = {"macmpec": 60, "mpeclib": 60, "nosbench": 120, "cutest": 60}
TITLES = {
    "cutest": "How many of the CUTEst problems are solved, beside IPOPT?",
    "macmpec": "How many of the MacMPEC problems are certified?",
    "mpeclib": "How many of the MPECLib problems are certified?",
    "nosbench": "How many programs of nosnoc's collection are certified?",
}
NOTES = {
    "macmpec": [
        "The collection of MPECs by Leyffer, as far as its translation to CasADi is public, and the traffic problems TSC from their own",
        "data. Objectives that the collection maximizes are stated by their negatives. Best known values are those of the collection but",
        "for these: TSC has two free variables that decide everything else, and fine grids of them show the least objective, or",
        "that queues must exceed their bound of 25 (34.75 in TSC-7, 33.99 in TSC-8, 25.038 in TSC-12): the published values belong to other",
        "data. The published 28.25 of dempe is an infimum for w to infinity that no point has. bilevel1m and ex9.2.3 are bilevel1 in",
        "other words, so their value is the 0 of that problem, not the published -55.",
        "",
    ],
    "cutest": [
        "2026-11-24, AMD EPYC, 2 cores shared with other jobs. The Python versions of CUTEst problems of S2MPJ in their default sizes, up to 3000",
        "variables and rows. 19 of those that are missing branch on values of variables, 19 take more than 10 s to state. 1031 of the files agree with the",
        "classes to 1e-9 beside the start; the others have more than 300 variables or rows, or no value there.",
        "",
        "Before this table was first made, 883 were solved; 852 by both, 31 here only, 40 by IPOPT only, and 112 were called infeasible, of",
        "which IPOPT solved five (DECONVBNE, DISCS, DRCAVTY2, HATFLDF, HATFLDFLNE). What was solved then takes the same iterations now. What helped:",
        "",
        "- Newton steps judged by the error alone where the objective does not change beyond rounding, and an end to steps that stand still: sums of",
        "  squares (MISRA1C, MEYER3, MGH10 and others), LOGROS, READING3, VIBRBEAM.",
        "- The multipliers that fit best, those of near bounds free, and the bounds themselves: EIGENA, VANDERM3, CYCLOOCF, S365, DIAGIQE, DIAGIQT.",
        "- Multipliers may be as large as the gradient calls for: HS99EXP.",
        "- Rows that give way by a shift of 1e-5: AGG, SSEBNLN, MSS1, SNAKE; a smaller first barrier parameter: SPANHYD.",
        "- First steps without a test: DRCAVTY2, HATFLDF, HATFLDFLNE. Least squares of the violation from the first start: DISCS, DEVGLA1NE, NYSTROM5;",
        "  from points beside it: LUBRIFC, LEVYMONE5, LEWISPOL and others.",
        "",
        "Least squares from the end of the first run found nothing more, and are left out. The same sums of squares, minimized by IPOPT from eight starts, have a zero",
        "in one of the problems that are still called infeasible, LEVYMONE6: a local least violation. Of those that only IPOPT solves, HS13 ends at 0.9946, below the",
        "minimum of 1, which has no multipliers; the scaled objective of OSCIGRAD hides a gradient that is not zero.",
        "",
        "85 of them, drawn at random on 2026-11-30: 80 solved, by IPOPT 79 (78 by both, DRUGDISE by IPOPT only), 3,962 iterations where both solve for 3,671, median ratio of CPU times",
        "0.10. The 20 larger programs of `solver/benches/solver`, none of which is small, the same day: 0.27.",
        "",
    ],
    "nosbench": [
        "The six problems CLS1D and the six TIMF1D that are called infeasible are so for IPOPT as well, by a homotopy of the products from 1",
        "to 1e-10 and six starts each.",
        "",
    ],
}
PROGRAM = sets.ROOT / "target" / "release" / "hangtime"


def cpu_of(process):
    """Seconds of processor time of a running process, where the system tells."""
    try:
        fields = pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def solve(path, limit, cpu):
    """Solves a problem in at most `limit` seconds, on the clock or, with `cpu`, of processor time, which other work on the machine
    does not shorten."""
    command = [PROGRAM, "nlp", path, "--json"] + ([] if cpu else ["--time-limit", str(limit)])
    start, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    over = False
    while True:
        try:
            out, error = process.communicate(timeout=0.1)
            break
        except subprocess.TimeoutExpired:
            if cpu and not over and cpu_of(process.pid) > limit:
                over = True
                # asks for the best result so far
                process.send_signal(signal.SIGINT)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    result = json.loads(out) if out else {"status": "no_result", "diagnosis": error.strip()}
    if over and result["status"] != "solved":
        result["status"] = "time_limit"
    result["name"], result["clock"] = path.stem, time.monotonic() - start
    result["cpu"] = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return result


def is_best(result, best):
    """Whether a certified value is the best known one, to 1e-4 and to the digits that are published; of an infeasible
    problem, whether it is called so."""
    if best == float("inf"):
        return result["status"] in ("infeasible", "locally_infeasible")
    return result["status"] == "solved" and best is not None and result["objective"] <= best + 1e-4 * max(1.0, abs(best))


def row(result, best):
    size = result.get("size", {})
    counts = result.get("iterations", {})
    value = "" if result.get("objective") is None else f"{result['objective']:.7g}"
    cells = [result["name"], size.get("variables", ""), size.get("complementarities", ""), result["status"],
             result.get("stationarity", ""), value, "" if best is None else f"{best:.7g}",
             counts.get("interior_point", ""), f"{result['cpu']:.2f}"]
    return "| " + " | ".join(map(str, cells)) + " |"


def table(name, results, missing, best, limit):
    solved = [result for result in results if result["status"] == "solved"]
    with_best = [result for result in results if best.get(result["name"]) is not None]
    at_best = sum(is_best(result, best[result["name"]]) for result in with_best)
    states = sorted({result["status"] for result in results})
    counts = ", ".join(f"{sum(r['status'] == s for r in results)} {s}" for s in states)
    seconds = statistics.median(result["cpu"] for result in results)
    lines = [f"# {TITLES[name]}", "", *NOTES.get(name, []), f"`python3 tools/problems/run.py {name}`, one default setting, {limit} s a problem, one problem at a time. "
             f"{len(results)} problems; {missing} more were not in the clone.", "",
             f"- certified (B or S): {len(solved)} of {len(results)} ({100 * len(solved) / len(results):.1f} %); {counts}",
             *([f"- at the best known value, or better, or infeasible as known: {at_best} of {len(with_best)}"] if with_best else []),
             f"- median time of the processor {seconds:.3g} s, sum {sum(r['cpu'] for r in results):.0f} s", "",
             "| problem | variables | pairs | status | stationarity | objective | best known | iterations | CPU [s] |",
             "|---|---:|---:|---|---|---:|---:|---:|---:|"]
    return "\n".join(lines + [row(result, best.get(result["name"])) for result in results]) + "\n"


def ipopt(path, limit):
    """What IPOPT says of a problem; kept beside its file, which it depends on alone."""
    kept = path.with_suffix(".ipopt.json")
    if not kept.exists():
        command = [sys.executable, sets.HERE / "ipopt.py", path, "--limit", str(limit)]
        out = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "OMP_NUM_THREADS": "1"}).stdout
        kept.write_text(out if out.strip() else json.dumps({"status": "no_result", "iterations": 0, "objective": None, "violation": None, "seconds": 0}))
    return json.loads(kept.read_text())


def compared_row(result, other):
    size, counts = result.get("size", {}), result.get("iterations", {})
    value = lambda objective: "" if objective is None else f"{objective:.7g}"
    residual = result.get("residuals", {}).get("violation_stationarity")
    rows = size.get("equalities", 0) + size.get("inequalities", 0)
    cells = [result["name"], size.get("variables", ""), rows, result["status"], "" if residual is None else f"{residual:.0e}",
             value(result.get("objective")), counts.get("interior_point", ""), f"{1e3 * result['own']:.1f}",
             other["status"], value(other["objective"]), other["iterations"], f"{1e3 * other['seconds']:.1f}"]
    return "| " + " | ".join(map(str, cells)) + " |"


def compared_table(name, results, missing, limit):
    """The table against IPOPT, whose `Solve_Succeeded` counts as solved, nothing else."""
    here = [r for r, _ in results if r["status"] == "solved"]
    there = [r for r, o in results if o["status"] == "Solve_Succeeded"]
    both = [(r, o) for r, o in results if r["status"] == "solved" and o["status"] == "Solve_Succeeded"]
    only = [r["name"] for r, o in results if r["status"] != "solved" and o["status"] == "Solve_Succeeded"]
    differ = [(r["objective"] - o["objective"]) / max(1.0, abs(o["objective"])) for r, o in both]
    states = sorted({r["status"] for r, _ in results})
    counts = ", ".join(f"{sum(r['status'] == s for r, _ in results)} {s}" for s in states)
    infeasible = [r for r, _ in results if r["status"] == "infeasible"]
    false = [r["name"] for r, o in results if r["status"] == "infeasible" and o["status"] == "Solve_Succeeded"]
    ratio = statistics.median(r["own"] / max(o["seconds"], 1e-6) for r, o in both)
    iterations = sum(r["iterations"]["interior_point"] for r, _ in both), sum(o["iterations"] for _, o in both)
    residual = max((r["residuals"]["violation_stationarity"] for r in infeasible), default=0.0)
    lines = [f"# {TITLES[name]}", "", *NOTES.get(name, []),
             f"`python3 tools/problems/run.py {name}`, one default setting, {limit} s a problem, one problem at a time, against IPOPT of the package "
             f"casadi with MUMPS and default options. {len(results)} problems; {missing} more could not be stated.", "",
             f"- {counts}; `solved` by IPOPT: {len(there)}",
             f"- solved by both {len(both)}, here only {len(here) - len(both)}, by IPOPT only {len(only)}: {', '.join(only)}",
             f"- iterations where both solve: {iterations[0]}, IPOPT {iterations[1]}; median ratio of CPU times {ratio:.2g}",
             f"- objectives that differ by more than 1e-4: {sum(d < -1e-4 for d in differ)} better here, {sum(d > 1e-4 for d in differ)} better there",
             f"- called infeasible though IPOPT solves it: {len(false)}{': ' + ', '.join(false) if false else ''}; the largest residual of those "
             f"called infeasible, the gradient of the violation, is {residual:.1e}", "",
             "| problem | variables | rows | status | residual | objective | iterations | CPU [ms] | IPOPT | objective | iterations | CPU [ms] |",
             "|---|---:|---:|---|---:|---:|---:|---:|---|---:|---:|---:|"]
    return "\n".join(lines + [compared_row(result, other) for result, other in results]) + "\n"


def parted(name, text):
    """A page that links to its table, and the rows of that."""
    head, rows = text[: text.index("| problem")], text[text.index("| problem"):].splitlines()
    cells = [[cell.strip() for cell in row.strip("| ").split("|")] for row in rows]
    return f"{head}The table is [{name}.csv]({name}.csv).\n", [cells[0], *cells[2:]]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("set", choices=LIMIT)
    parser.add_argument("--clone", action="append", default=[], type=pathlib.Path, help="a clone of a source repository")
    parser.add_argument("--only", default="", help="problems whose names begin so; prints the table instead of writing it")
    parser.add_argument("--sample", type=int, help="so many problems drawn at random; prints the table instead of writing it")
    parser.add_argument("--seed", type=int, default=1, help="of the draw")
    parser.add_argument("--limit", type=float, help="seconds a problem")
    parser.add_argument("--cpu", action="store_true", help="limits processor time instead of the clock")
    parser.add_argument("--cargo", action="append", default=[], help="an option for cargo, such as --cargo=--offline")
    arguments = parser.parse_args()
    limit = arguments.limit or LIMIT[arguments.set]
    paths, missing = sets.fetch(arguments.set, arguments.clone)
    subprocess.run(["cargo", "build", "--release", "--workspace", *arguments.cargo, "--bin", "hangtime"], cwd=sets.ROOT, check=True)
    best = sets.known(arguments.set)
    paths = [path for path in paths if path.stem.startswith(arguments.only)]
    if arguments.sample:
        paths = random.Random(arguments.seed).sample(paths, min(arguments.sample, len(paths)))
    results = []
    compares = arguments.set == "cutest"
    for path in paths:
        result = solve(path, limit, arguments.cpu)
        # building derivatives is counted on neither side
        result["own"] = result.get("seconds", {}).get("total", result["cpu"])
        results.append((result, ipopt(path, limit)) if compares else result)
        print(compared_row(*results[-1]) if compares else row(result, best.get(path.stem)), flush=True)
    text = compared_table(arguments.set, results, missing, limit) if compares else table(arguments.set, results, missing, best, limit)
    if not arguments.only and not arguments.sample:
        page, rows = parted(arguments.set, text)
        folder = sets.ROOT / "docs" / "experiments"
        (folder / f"{arguments.set}.md").write_text(page)
        with open(folder / f"{arguments.set}.csv", "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(rows)
    print(text[: text.index("| problem")])


if __name__ == "__main__":
    main()
