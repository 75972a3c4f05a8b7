"""MuJoCo and Siconos on the families of `cargo bench --bench contacts`, as far as they are installed.

python3 tools/peers/contacts.py [FILE]    # then: cargo bench --bench contacts -- --out growth --peers FILE

Each family and size runs in a process of its own: CPU time to set up, CPU time of the run, most memory. MuJoCo takes steps of 1 ms with its
default solver, contacts a soft law of their own (errors of about 1e-3); Siconos takes Moreau-Jean steps of 1 ms with the law of the scene.
"""

import csv
import resource
import subprocess
import sys
import time
from pathlib import Path

SYSTEM = "/usr/bin/python3"
"""The Python of the system, for which Debian packages Siconos."""

STEP = 1e-3
LONGEST = 120
"""Longest time that one run may take [s]."""
HEADING = ["family", "bodies", "method", "contacts", "load_s", "run_s", "memory_mb", "ended"]
SIZES = {
    "cradle, elastic": [2, 5, 10, 20, 50, 100, 200],
    "tower of boxes": [2, 5, 10, 20, 50, 100],
    "discs in a box, all pairs": [2, 5, 10, 20, 50],
    "chain above a floor": [2, 5, 10, 20, 40, 60, 100],
}
HORIZONS = {"cradle, elastic": 1.0, "tower of boxes": 1.0, "discs in a box, all pairs": 0.5, "chain above a floor": 1.0}


def scattered(i, salt):
    """The same numbers as in the scenes of the benchmark."""
    return (i * 2_654_435_761 + salt * 40_503 + 12_345) % 1_000_003 / 1_000_003


def slides(axes):
    return "".join(f'<joint type="slide" axis="{axis}"/>' for axis in axes)


def mujoco_text(family, n):
    """The scene in MuJoCo's format, and the number of its contacts."""
    floor = '<geom type="plane" size="50 50 1"/>'
    if family == "cradle, elastic":
        place = lambda i: -0.3 if i == 0 else 0.1 * i
        bodies = "".join(
            f'<body pos="{place(i)} 0 0">{slides(["1 0 0"])}<geom type="sphere" size="0.05" mass="1" solref="-1e5 0"/></body>'
            for i in range(n)
        )
        return bodies, n - 1
    if family == "tower of boxes":
        bodies = "".join(
            f'<body pos="0 0 {0.11 * (i + 1) - 0.05}">{slides(["0 0 1"])}<geom type="box" size="0.05 0.05 0.05" mass="1"/></body>'
            for i in range(n)
        )
        return floor + bodies, n
    if family == "discs in a box, all pairs":
        columns = int(n**0.5 + 0.999)
        wide = 0.3 * columns
        walls = floor + "".join(
            f'<geom type="plane" pos="{x} 0 0" zaxis="{side} 0 0" size="50 50 1"/>' for x, side in ((0, 1), (wide, -1))
        )
        x = lambda i: 0.15 + 0.3 * (i % columns) + 0.06 * (scattered(i + 1, 3) - 0.5)
        z = lambda i: 0.15 + 0.25 * (i // columns) + 0.04 * (scattered(i + 1, 4) - 0.5)
        bodies = "".join(
            f'<body pos="{x(i)} 0 {z(i)}">{slides(["1 0 0", "0 0 1"])}<geom type="sphere" size="0.1" mass="1"/></body>'
            for i in range(n)
        )
        return walls + bodies, 3 * n + n * (n - 1) // 2
    text, close = "", ""
    for i in range(1, n + 1):
        place = f"0 0 {0.07 * n}" if i == 1 else "0 0 -0.1"
        text += (
            f'<body pos="{place}"><joint type="hinge" axis="0 -1 0" ref="0" springref="0"/>'
            '<geom type="sphere" size="0.001" pos="0 0 -0.1" mass="1"/>'
        )
        close += "</body>"
    return floor + text + close, n


def run_mujoco(family, n):
    import mujoco

    begin = time.process_time()
    text, contacts = mujoco_text(family, n)
    gravity = "0 0 0" if family == "cradle, elastic" else "0 0 -9.81"
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{STEP}" gravity="{gravity}"/><default><geom condim="1"/></default>'
        f"<worldbody>{text}</worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    if family == "cradle, elastic":
        data.qvel[0] = 1.0
    if family == "discs in a box, all pairs":
        data.qvel[::2] = [scattered(i + 1, 5) - 0.5 for i in range(n)]
    if family == "chain above a floor":
        # Relative angles; the first one is absolute.
        data.qpos[:] = 0.02
        data.qpos[0] = 0.82
    load = time.process_time() - begin
    begin = time.process_time()
    for _ in range(round(HORIZONS[family] / STEP)):
        mujoco.mj_step(model, data)
    return contacts, load, time.process_time() - begin


def run_siconos(family, n):
    import numpy as np
    import siconos.kernel as sk

    begin = time.process_time()
    if family not in ("cradle, elastic", "tower of boxes"):
        raise NotImplementedError("family")
    horizon = HORIZONS[family]
    system = sk.NonSmoothDynamicalSystem(0.0, horizon)
    row = family == "cradle, elastic"
    law = sk.NewtonImpactNSL(1.0 if row else 0.0)
    starts = [-0.3] + [0.1 * i for i in range(1, n)] if row else [0.11 * (i + 1) - 0.05 for i in range(n)]
    bodies = []
    for i, start in enumerate(starts):
        body = sk.LagrangianLinearTIDS([start], [1.0 if row and i == 0 else 0.0], np.eye(1))
        if not row:
            body.setFExtPtr(np.array([-9.81]))
        system.insertDynamicalSystem(body)
        bodies.append(body)
    if not row:
        system.link(sk.Interaction(law, sk.LagrangianLinearTIR([[1.0]], [-0.05])), bodies[0])
    for before, behind in zip(bodies, bodies[1:]):
        system.link(sk.Interaction(law, sk.LagrangianLinearTIR([[-1.0, 1.0]], [-0.1])), before, behind)
    grid = sk.TimeDiscretisation(0.0, STEP)
    stepping = sk.TimeStepping(system, grid, sk.MoreauJeanOSI(0.5), sk.LCP())
    load = time.process_time() - begin
    begin = time.process_time()
    while stepping.hasNextEvent():
        stepping.computeOneStep()
        stepping.nextStep()
    return n - 1 if row else n, load, time.process_time() - begin


def interpreter(package):
    """A Python that has a package: this one, or that of the system."""
    for python in (sys.executable, SYSTEM):
        if Path(python).exists() and not subprocess.run([python, "-c", f"import {package}"], capture_output=True).returncode:
            return python
    return None


def main():
    if len(sys.argv) == 5 and sys.argv[1] == "--child":
        method, family, n = sys.argv[2], sys.argv[3], int(sys.argv[4])
        contacts, load, seconds = {"mujoco": run_mujoco, "siconos": run_siconos}[method](family, n)
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6
        print(f"{contacts} {load} {seconds} {memory}")
        return
    file = sys.argv[1] if len(sys.argv) > 1 else "contacts_peers.csv"
    with open(file, "w", newline="") as out:
        table = csv.writer(out)
        table.writerow(HEADING)
        for method in ("mujoco", "siconos"):
            python = interpreter(method)
            if python is None:
                print(f"{method}: not installed")
                continue
            for family, sizes in SIZES.items():
                for n in sizes:
                    command = [python, __file__, "--child", method, family, str(n)]
                    try:
                        done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST)
                    except subprocess.TimeoutExpired:
                        print(f"{method} {family} {n}: more than {LONGEST} s")
                        break
                    if done.returncode:
                        reason = done.stderr.strip().splitlines()
                        print(f"{method} {family} {n}: {reason[-1] if reason else 'failed'}")
                        break
                    contacts, load, seconds, memory = done.stdout.split()
                    table.writerow([family, n, method, contacts, load, seconds, memory, ""])
                    print(f"{method} {family} {n}: {float(seconds):.4f} s")


if __name__ == "__main__":
    main()
