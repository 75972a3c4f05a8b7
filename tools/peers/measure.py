"""Other programs on the ski jump and the pump track: where they come to, and for how much CPU time.

    python measure.py [FILE]

writes one row a run to FILE (peers.csv). `hangtime chart` draws them beside its own runs: the stored ones, or those of
a `peers.csv` in its output directory. What is not installed is left out, and said.
"""

import csv
import datetime
import importlib
import os
import platform
import sys
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[threads] = "1"

HEADER = ["date", "machine", "study", "curve", "settings", "CPU time [s]", "coordinates at the end"]
PROGRAMS = ["with_scipy", "with_nosnoc", "with_siconos"]


def machine():
    """Name of the processor and number of cores, without anything that names the computer."""
    name = platform.machine()
    information = Path("/proc/cpuinfo")
    if information.exists():
        lines = information.read_text().splitlines()
        models = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
        name = models[0] if models else name
    return f"{name.split(' @ ')[0]}, {os.cpu_count()} cores"


def rows(programs):
    """One row for each run, as it is made."""
    day, where = datetime.date.today().isoformat(), machine()
    for program in programs:
        try:
            module = importlib.import_module(program)
        except ImportError as missing:
            print(f"{program}: left out, {missing}", file=sys.stderr)
            continue
        for study, curve, settings, seconds, end in module.points():
            coordinates = " ".join(repr(float(value)) for value in end)
            print(f"{study}: {curve}, {settings}: {seconds:.2e} s, {coordinates}", file=sys.stderr)
            yield [day, where, study, curve, settings, f"{seconds:.3e}", coordinates]


def main():
    arguments = sys.argv[1:]
    chosen = [name for name in PROGRAMS if name in arguments] or PROGRAMS
    files = [name for name in arguments if name not in PROGRAMS] or ["peers.csv"]
    if len(files) > 1:
        sys.exit(__doc__)
    measured = list(rows(chosen))
    with open(files[0], "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(HEADER)
        writer.writerows(measured)


main()
