#!/usr/bin/env python3
"""Solves the scenes of a folder in several ways and compares them: `python3 tools/families.py target/release/hangtime zoo/families`.

Every scene is solved on 10 and on 30 control intervals by the default search, from one start, from sixteen starts, and by
time-freezing on 10 intervals; one process at a time, on one thread, `--time-limit` each. The rows are kept in a CSV file beside the folder, one
a run, and a run that is there already is not done again. On standard output comes a Markdown table: a row a scene and number of intervals, with
the objective of every way relative to the best of all, those on grids that it contains included. A scene may say
in its comment `Least possible: NUMBER`, and `on 10 intervals NUMBER` for a grid; what is less is marked. `Possible on 10 intervals: NUMBER` is a motion that was simulated.
"""

import argparse
import csv
import json
import os
import pathlib
import re
import resource
import subprocess
import sys
import time

WAYS = {
    "default": [],
    "starts-1": ["--starts", "1"],
    "starts-16": ["--starts", "16"],
    "time-freezing": ["--formulation", "time-freezing"],
}
"""The ways and their options."""
INTERVALS = (10, 30)
"""Numbers of control intervals."""
QUICK = {"time-freezing": (10,)}
"""Ways that are only tried on some numbers of intervals."""
COLUMNS = ["scene", "intervals", "way", "objective", "status", "stationarity", "iterations", "cpu_seconds", "seconds", "message"]
"""Columns of the CSV file: the first eight say what came out, then the time on the clock and what the program says of a run that is not solved."""
MOTION = {"solved", "uncertified", "time_limit", "memory_limit", "interrupted"}
"""States of a result in which an objective belongs to a motion that was replayed."""
REPLAYED = 1e-5
"""A motion of a run that was stopped counts if it ends nearer to its re-simulation than this."""
NEAR, CLOSE = 1e-2, 1e-4
"""What is above the best by more than these is listed."""
ROUNDING = 1e-6
"""Relative difference from the least possible that counts as rounding: constraints hold to about that."""
SMALL = 1e-3
"""Objectives below this, in the units of the scene, are compared by their difference: the least possible may be 0."""
UNPROVED = {"uncertified", "unconfirmed", "infeasible", "not_found", "failed", "unbounded"}
"""States of a default run that are listed where some way finds a motion."""
LONG = 10.0
"""CPU seconds above which a default run is listed."""


def run(program, scene, intervals, way, limit):
    """Solves a scene once and returns its row."""
    command = [program, "solve", str(scene), "--intervals", str(intervals), "--json", "--time-limit", str(limit), *WAYS[way]]
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, check=False, timeout=2 * limit + 60, env={**os.environ, "RAYON_NUM_THREADS": "1"}
        )
        output, errors, code = done.stdout, done.stderr, done.returncode
    except subprocess.TimeoutExpired:
        output, errors, code = "", "no end", -1
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    row = dict.fromkeys(COLUMNS, "")
    row.update(scene=scene.stem, intervals=intervals, way=way, seconds=f"{time.monotonic() - begun:.2f}")
    row["cpu_seconds"] = f"{after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime:.2f}"
    try:
        result = json.loads(output)
    except ValueError:
        last = errors.strip().splitlines()
        row.update(status={2: "refused", -1: "no end"}.get(code, f"exit {code}"), message=" | ".join(last[-3:]))
        return row
    objective = result.get("objective")
    row.update(
        objective="" if objective is None else f"{objective:.12g}",
        status=result.get("status", ""),
        stationarity=result.get("stationarity") or "",
        iterations=(result.get("iterations") or {}).get("interior_point", ""),
    )
    if row["status"] != "solved":
        row["message"] = (result.get("message") or errors).strip().replace("\n", " | ")[:400]
    return row


def least(scene, intervals):
    """The least possible objective that the comment of a scene states, for that grid or for all, if it does."""
    text = scene.read_text()
    found = re.search(rf"on {intervals} intervals ([0-9]+(?:\.[0-9]+)?)", text) or re.search(r"Least possible: (-?[0-9]+(?:\.[0-9]+)?)", text)
    return float(found[1]) if found else None


def known(scene, intervals):
    """Objectives of motions that the comment of a scene states, on that grid or on one that it contains."""
    found = re.findall(r"Possible on ([0-9]+) intervals: ([0-9]+(?:\.[0-9]+)?)", scene.read_text())
    return [float(value) for count, value in found if intervals % int(count) == 0]


def number(row):
    """The objective of a run that ended with a motion, else nothing."""
    if not row or row["status"] not in MOTION or row["objective"] == "":
        return None
    apart = re.search(r"ends ([0-9.e+-]+) from its re-simulation", row["message"])
    if apart and float(apart[1]) > REPLAYED:
        return None
    return float(row["objective"])


def effort(rows, name):
    """CPU seconds that the default search took of a scene: what is quick is run first, so that a measurement that is ended has the most rows."""
    spent = [float(row["cpu_seconds"]) for row in rows.values() if (row["scene"], row["way"]) == (name, "default")]
    return max(spent, default=2.0)


def above(value, best):
    """Excess of an objective over the best one, relative to it."""
    return (value - best) / max(abs(best), SMALL)


def cell(row, best):
    """What the table says of a run."""
    if not row:
        return ""
    value = number(row)
    if value is None:
        return f"{row['status']} ({row['cpu_seconds']} s)"
    excess = above(value, best)
    word = "best" if excess < 1e-6 else f"+{excess:.1e}" if excess < NEAR else f"+{100 * excess:.1f} %"
    mark = "" if row["status"] == "solved" else f", {row['status']}"
    return f"{word} ({row['cpu_seconds']} s{mark})"


def table(scenes, rows):
    """The Markdown table and what is wrong, as lines."""
    lines = [f"| scene | N | best | {' | '.join(WAYS)} |", "|" + "---|" * (3 + len(WAYS))]
    wrong = []
    for scene in scenes:
        for intervals in INTERVALS:
            bound = least(scene, intervals)
            of = {way: rows.get((scene.stem, str(intervals), way)) for way in WAYS}
            contained = [rows.get((scene.stem, str(fewer), way)) for fewer in INTERVALS if intervals % fewer == 0 for way in WAYS]
            values = [number(row) for row in contained if number(row) is not None] + known(scene, intervals)
            best = min(values, default=None)
            lines.append(
                f"| {scene.stem} | {intervals} | {'none' if best is None else f'{best:.8g}'} | {' | '.join(cell(row, best) for row in of.values())} |"
            )
            place = f"{scene.stem}, N = {intervals}"
            default = of["default"]
            if default and best is not None:
                value = number(default)
                if value is None or default["status"] in UNPROVED:
                    wrong.append(f"b: {place}: {default['status']}, best {best:.8g}: {default['message'][:160]}")
                if value is not None and above(value, best) > CLOSE:
                    size = "1 %" if above(value, best) > NEAR else "1e-4"
                    wrong.append(f"a ({size}): {place}: {value:.8g}, best {best:.8g}, +{100 * above(value, best):.3g} % ({default['status']})")
            if default and float(default["cpu_seconds"]) > LONG:
                wrong.append(f"c: {place}: {default['cpu_seconds']} s")
            for way, row in of.items():
                value = number(row)
                if bound is not None and value is not None and above(value, bound) < -ROUNDING:
                    wrong.append(f"d: {place}, {way}: {value:.9g} is less than possible, {bound:.9g}")
                if row and (row["status"].startswith("exit") or row["status"] in ("refused", "no end")):
                    wrong.append(f"e: {place}, {way}: {row['status']}: {row['message']}")
    return lines, wrong


def main():
    """Runs what is missing, then prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", help="the program hangtime")
    parser.add_argument("folder", type=pathlib.Path, help="folder of scene files")
    parser.add_argument("--csv", type=pathlib.Path, help="the rows [default: FOLDER.csv]")
    parser.add_argument("--time-limit", type=float, default=60.0, metavar="SECONDS")
    parser.add_argument("--ways", default=",".join(WAYS), help="which ways, separated by commas")
    parser.add_argument("--intervals", default="", help="only these numbers of intervals, separated by commas")
    parser.add_argument("--only", default="", metavar="TEXT", help="scenes whose name begins so")
    parser.add_argument("--table", action="store_true", help="print the table of the rows that are there, and run nothing")
    options = parser.parse_args()
    numbers = [int(number) for number in options.intervals.split(",")] if options.intervals else INTERVALS
    path = options.csv or options.folder.with_suffix(".csv")
    scenes = sorted(options.folder.glob("*.hang"))
    rows = {}
    if path.exists():
        with path.open(newline="") as file:
            rows = {(row["scene"], row["intervals"], row["way"]): row for row in csv.DictReader(file)}
    ways = [] if options.table else options.ways.split(",")
    for scene in sorted(scenes, key=lambda scene: effort(rows, scene.stem)):
        for way, intervals in ((way, count) for way in ways for count in numbers if count in QUICK.get(way, numbers)):
            key = (scene.stem, str(intervals), way)
            if key in rows or not scene.stem.startswith(options.only):
                continue
            row = run(options.program, scene, intervals, way, options.time_limit)
            rows[key] = {name: str(value) for name, value in row.items()}
            print(" ".join(str(row[name]) for name in COLUMNS[:8]), file=sys.stderr, flush=True)
            write(path, scenes, rows)
    if not options.table:
        write(path, scenes, rows)
    lines, wrong = table(scenes, rows)
    print("\n".join(lines))
    print("\n" + "\n".join(f"- {line}" for line in wrong))


def write(path, scenes, rows):
    """Writes the rows of the scenes that are there, in order."""
    names = [scene.stem for scene in scenes]
    kept = [row for row in rows.values() if row["scene"] in names]
    kept.sort(key=lambda row: (row["scene"], int(row["intervals"]), list(WAYS).index(row["way"])))
    new = path.with_suffix(".new")
    with new.open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(kept)
    new.replace(path)


if __name__ == "__main__":
    main()
