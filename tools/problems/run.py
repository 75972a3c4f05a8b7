#!/usr/bin/env python3
"""Solves a public problem set and writes a table of it: `python3 tools/problems/run.py macmpec` or `nosbench`.

Fetches what is missing into target/problems (git, and the Python package casadi, which states the problems), builds the
program, solves every problem with its default settings, and writes docs/experiments/SET.md. Clones that are there already
are named by --clone.
"""

import argparse
import json
import os
import pathlib
import random
import resource
import signal
import statistics
import subprocess
import time

import sets

LIMIT = {"macmpec": 60, "mpeclib": 60, "nosbench": 120}
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
        return result["status"] == "infeasible"
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
    lines = [f"# {name}", "", *NOTES.get(name, []), f"`python3 tools/problems/run.py {name}`, one default setting, {limit} s a problem, one problem at a time. "
             f"{len(results)} problems; {missing} more were not in the clone.", "",
             f"- certified (B or S): {len(solved)} of {len(results)} ({100 * len(solved) / len(results):.1f} %); {counts}",
             *([f"- at the best known value, or better, or infeasible as known: {at_best} of {len(with_best)}"] if with_best else []),
             f"- median time of the processor {seconds:.3g} s, sum {sum(r['cpu'] for r in results):.0f} s", "",
             "| problem | variables | pairs | status | stationarity | objective | best known | iterations | CPU [s] |",
             "|---|---:|---:|---|---|---:|---:|---:|---:|"]
    return "\n".join(lines + [row(result, best.get(result["name"])) for result in results]) + "\n"


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
    for path in paths:
        results.append(solve(path, limit, arguments.cpu))
        print(row(results[-1], best.get(path.stem)), flush=True)
    text = table(arguments.set, results, missing, best, limit)
    if not arguments.only and not arguments.sample:
        (sets.ROOT / "docs" / "experiments" / f"{arguments.set}.md").write_text(text)
    print(text[: text.index("| problem")])


if __name__ == "__main__":
    main()
