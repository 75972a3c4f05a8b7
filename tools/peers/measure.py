"""Other programs on the ski jump, the pump track and the incline: where they come to, and for how much CPU time.

    python measure.py [FILE] [PROGRAM ...] [--only SCENE ...]

writes one row a run to FILE (peers.csv), of these scenes only where some are named. `hangtime chart` draws them beside its own runs: the
stored ones, or those of a `peers.csv` in its output directory; `hangtime chart --peers` calls this script. What is not installed is
left out, and said; programs that only the Python of the system has are run by that.
"""

import csv
import datetime
import importlib
import os
import platform
import subprocess
import sys
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[threads] = "1"

HEADER = ["date", "machine", "study", "curve", "settings", "CPU time [s]", "coordinates at the end"]
PROGRAMS = ["with_scipy", "with_nosnoc", "with_siconos", "with_mujoco"]
SYSTEM = "/usr/bin/python3"
"""The Python of the system, for which Debian packages some of them."""
ELSEWHERE = "HANGTIME_PEERS_ELSEWHERE"
"""Set in a run by another Python, which looks no further."""


def machine():
    """Name of the processor and number of cores, without anything that names the computer."""
    name = platform.machine()
    information = Path("/proc/cpuinfo")
    if information.exists():
        lines = information.read_text().splitlines()
        models = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
        name = models[0] if models else name
    return f"{name.split(' @ ')[0]}, {os.cpu_count()} cores"


def elsewhere(program, only):
    """The rows of a program by the Python of the system; nothing where that has it not, either."""
    if ELSEWHERE in os.environ or not Path(SYSTEM).exists() or Path(SYSTEM).resolve() == Path(sys.executable).resolve():
        return []
    command = [SYSTEM, __file__, "-", program, *(["--only", *only] if only else [])]
    run = subprocess.run(command, env={**os.environ, ELSEWHERE: "1"}, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    return list(csv.reader(run.stdout.splitlines()))[1:] if run.returncode == 0 else []


def wanted(study, only):
    """Whether a study is of one of the named scenes."""
    return not only or any(study == scene or study.startswith(f"{scene},") for scene in only)


def rows(programs, only):
    """One row for each run, as it is made."""
    day, where = datetime.date.today().isoformat(), machine()
    for program in programs:
        try:
            module = importlib.import_module(program)
        except ImportError as missing:
            others = elsewhere(program, only)
            if not others:
                print(f"{program}: left out, {missing}", file=sys.stderr)
            yield from others
            continue
        for study, curve, settings, seconds, end in module.points(lambda study: wanted(study, only)):
            coordinates = " ".join(repr(float(value)) for value in end)
            print(f"{study}: {curve}, {settings}: {seconds:.2e} s, {coordinates}", file=sys.stderr)
            yield [day, where, study, curve, settings, f"{seconds:.3e}", coordinates]


def main():
    arguments, only = sys.argv[1:], []
    if "--only" in arguments:
        place = arguments.index("--only")
        arguments, only = arguments[:place], arguments[place + 1 :]
    chosen = [name for name in PROGRAMS if name in arguments] or PROGRAMS
    files = [name for name in arguments if name not in PROGRAMS] or ["peers.csv"]
    if len(files) > 1:
        sys.exit(__doc__)
    measured = list(rows(chosen, only))
    with sys.stdout if files[0] == "-" else open(files[0], "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(HEADER)
        writer.writerows(measured)


main()
