"""nosnoc's own examples by nosnoc (Python) with IPOPT and by hangtime, by default and by time-freezing, in one run.

    python nosnoc_examples.py [NAME ...] [--hangtime PROGRAM] [--out FILE]

prints a table and writes it to FILE (nosnoc.csv). `nosnoc_models.py` states the examples as nosnoc wants them; scenes are those of the gallery, of the
zoo, and of `scenes/`. Errors of simulations are the largest of all states at the end; objectives of plans leave out what nosnoc adds for equal steps.
CPU times are those of one thread, nosnoc's without its set-up; each solve ends after LIMIT seconds of them.
"""

import argparse
import csv
import json
import multiprocessing
import os
import resource
import subprocess
import tempfile
import time
import warnings
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ[threads] = "1"

import nosnoc as ns
import numpy as np

from nosnoc_models import PLANS, SIMULATIONS, options

HERE = Path(__file__).parent
SOLVED = 1e-6
"""Largest product of a solution that counts as one."""
EXACT = 1e-9
"""The same of steps of a simulation, of order five."""
REPEATED = 3
"""Runs of a simulation, the fastest of which counts."""
LIMIT = 120
"""CPU seconds of a solve."""
NAMES = ["example", "published", "program", "grid", "objective or error", "iterations", "CPU [s]", "status"]


def limited(work, *arguments):
    """What `work` returns in a process of its own, as options of nosnoc are those of its class, or none after the limit."""
    receive, send = multiprocessing.get_context("fork").Pipe(False)

    def child():
        warnings.filterwarnings("ignore")
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        try:
            send.send(work(*arguments))
        except RuntimeError as error:
            send.send((None, None, 0.0, f"error: {str(error).splitlines()[-1]}"))

    process = multiprocessing.get_context("fork").Process(target=child)
    process.start()
    send.close()
    try:
        return receive.recv()
    except EOFError:
        return None
    finally:
        process.join()


def counted(work):
    """CPU seconds of a part of a process that has the limit from here on."""
    begun = time.process_time()
    seconds = int(begun) + LIMIT
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
    result = work()
    return result, time.process_time() - begun


def judged(solver, found, tolerance):
    left = float(solver.problem.comp_res(found["w_sol"], solver.p_val))
    return left <= tolerance and bool(solver.solver.stats()["success"])


def plan_of_nosnoc(example):
    chosen, model, ocp, worth = example.build(example.grid)
    solver = ns.NosnocSolver(chosen, model, ocp)
    found, seconds = counted(solver.solve)
    value = worth(np.array(found["x_list"][-1]), np.array(found["v_global"]).ravel())
    iterations = sum(count for count in found["nlp_iter"] if count)
    return value, iterations, seconds, "solved" if judged(solver, found, SOLVED) else "not solved"


def motion_of_nosnoc(example, grid):
    """The end, on so many stages, steps, and elements of a step."""
    stages, steps, elements = grid
    chosen = options((1, elements, stages), example.horizon / steps, comp_tol=EXACT, sigma_N=EXACT)
    solver = ns.NosnocSolver(chosen, example.model())

    def run():
        state, solved, iterations = np.array(example.start), 0, 0
        for _ in range(steps):
            solver.set("x0", state)
            found = solver.solve()
            solved += judged(solver, found, 10 * EXACT)
            iterations += sum(count for count in found["nlp_iter"] if count)
            state = np.array(found["x_list"][-1])
        return state, iterations, solved

    (state, iterations, solved), seconds = counted(run)
    return state, iterations, seconds, "solved" if solved == steps else f"{solved} of {steps} steps"


def called(program, command, example, *arguments):
    """JSON of a run of hangtime, with its own CPU seconds."""
    text = next(path for folder in ("scenes", "../../models/gallery", "../../zoo/scenes") if (path := HERE / folder / f"{example.scene}.hang").exists()).read_text()
    for old, new in example.changes.items():
        assert old in text, f"{example.scene} has no `{old}`"
        text = text.replace(old, new)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{example.scene}.hang"
        path.write_text(text)
        begun = resource.getrusage(resource.RUSAGE_CHILDREN)
        run = subprocess.run(
            ["sh", "-c", f'ulimit -t {LIMIT}; exec "$0" "$@"', program, command, path, *arguments, "--json"], capture_output=True, text=True
        )
        ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = ended.ru_utime + ended.ru_stime - begun.ru_utime - begun.ru_stime
    if run.returncode < 0 or seconds >= LIMIT:
        return {"status": "limit of time"}, seconds
    return (json.loads(run.stdout) if run.stdout.startswith("{") else {"status": f"refused: {(run.stderr.strip().splitlines() or ['no word'])[0]}"}), seconds


def end_of(document):
    """Coordinates, velocities and states at the end."""
    final = document["final"]
    return np.array([*final["q"], *final["v"], *final.get("states", [])])


def simulated(program, example):
    wanted = example.wanted
    if wanted is None:
        # No closed form: the event-driven method is another one, close to rounding.
        wanted = end_of(called(program, "simulate", example, "--method", "event", "--tolerance", "1e-13")[0])
    for grid in example.grids:
        found = limited(motion_of_nosnoc, example, grid)
        if found is None:
            yield "nosnoc", grid, None, None, LIMIT, "limit of time"
            continue
        state, iterations, seconds, status = found
        yield "nosnoc", grid, max(abs(state[: len(wanted)] - wanted)), iterations, seconds, status
    for name, more in (("hangtime", ()), ("hangtime, complementarity", ("--formulation", "complementarity"))):
        runs = [called(program, "simulate", example, *more) for _ in range(REPEATED)]
        document, seconds = min(runs, key=lambda run: run[1])
        error = max(abs(end_of(document)[: len(wanted)] - wanted)) if document["status"] == "solved" else None
        counts = document.get("iterations", {})
        yield name, "", error, counts.get("interior_point") or counts.get("newton"), seconds, document["status"]


def planned(program, example):
    if example.build:
        found = limited(plan_of_nosnoc, example)
        yield "nosnoc", example.grid, *(found or (None, None, LIMIT, "limit of time"))
    for name, more in (("hangtime", ()), ("hangtime, time-freezing", ("--formulation", "time-freezing"))):
        document, seconds = called(program, "solve", example, "--intervals", str(example.grid[0]), *more)
        status = f"{document['status']} {document.get('stationarity') or ''}".strip()
        yield name, example.grid[0], document.get("objective"), document.get("iterations", {}).get("interior_point"), seconds, status


def cells(value, digits):
    return "" if value is None else f"{value:.{digits}g}" if isinstance(value, float) else str(value)


def main():
    warnings.filterwarnings("ignore")
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*")
    parser.add_argument("--hangtime", default="hangtime")
    parser.add_argument("--out", default="nosnoc.csv")
    given = parser.parse_args()
    with open(given.out, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(NAMES)
        for example in [*SIMULATIONS, *PLANS]:
            if given.names and example.name not in given.names:
                continue
            digits = 3 if example in SIMULATIONS else 10
            for program, grid, value, iterations, seconds, status in (simulated if example in SIMULATIONS else planned)(given.hangtime, example):
                grid = ", ".join(map(str, grid)) if isinstance(grid, tuple) else grid
                row = [example.name, example.published, program, grid, cells(value, digits), cells(iterations, 0), cells(float(seconds), 2), status]
                print(*row, sep=" | ", flush=True)
                writer.writerow(row)
                file.flush()


if __name__ == "__main__":
    main()
