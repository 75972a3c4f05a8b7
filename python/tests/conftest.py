"""What the tests share: the command line beside the package."""

import contextlib
import json
import os
import pathlib
import signal
import subprocess
import threading

import matplotlib
import pytest

matplotlib.use("agg")

ROOT = pathlib.Path(__file__).resolve().parents[2]

#: The command line; `HANGTIME` names another one.
PROGRAM = os.environ.get("HANGTIME", str(ROOT / "target" / "debug" / "hangtime"))

BALL = """
parameters { h: m = 1, e = 0.5, push: m/s = 0 }
coordinates { z: m }
lagrangian 1[kg]/2*dot(z)^2 - 9.81[N]*z
surface floor: z >= 0
impact floor: restitution e
start { z: h, dot(z): push }
horizon 0.6 [s]
"""

#: Time-optimal push of a cart over 1 m with force within 1 N on 2 kg: 2 sqrt(m d/F) = 2 sqrt(2) s.
CART = """
parameters { m: kg = 2, d: m = 1 }
coordinates { y: m }
controls { u: N in -1..=1 }
lagrangian m/2*dot(y)^2
forces { y: u }
minimize time
start { y: 0 }
finally { y == d, dot(y) == 0 }
"""


@pytest.fixture(scope="session")
def command():
    """Runs the command line (`HANGTIME` names the program) and returns exit status, output and error text."""
    if not os.path.exists(PROGRAM):
        pytest.fail(f"{PROGRAM} is missing: cargo build -p hangtime-bin, or name the program by HANGTIME")

    def run(*words, cwd=None):
        done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, cwd=cwd, check=False)
        return done.returncode, done.stdout, done.stderr

    return run


@pytest.fixture
def ball_file(tmp_path):
    path = tmp_path / "ball.hang"
    path.write_text(BALL)
    return path


def without_seconds(text):
    """A document without CPU times, which differ from run to run; numbers as texts, so that all digits count."""
    document = json.loads(text, parse_float=str)
    document.pop("seconds")
    for improvement in document.get("improvements", []):
        improvement.pop("cpu")
    return document


@contextlib.contextmanager
def ctrl_c_after(seconds):
    timer = threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
