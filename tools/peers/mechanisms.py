"""First impacts of mechanisms by MuJoCo with ever shorter steps, beside hangtime.

python3 tools/peers/mechanisms.py [--hangtime PROGRAM]

Each scene is written twice, as a user of either program has to. MuJoCo moves by semi-implicit Euler steps, whose error is of first order:
the time of the first impact, between the two steps around it by the gap on both sides, goes to that of the motion as steps become shorter.
"""

import argparse
import json
import subprocess
import tempfile
from math import cos, radians, sin
from pathlib import Path

import mujoco
import numpy as np

STEPS = [1e-3, 1e-4, 1e-5]
AGREES = 1e-4
G = 9.81
TILT = radians(20)

# name: scene, model of MuJoCo with its gravity, and its start by joints
SCENES = {
    "box on a slope": (
        """parameters { m: kg = 1, w: m = 0.4, h: m = 0.2, g: m/s^2 = 9.81 }
coordinates { x: m, z: m, phi: rad }
gravity (0, -g)
body block: mass m, inertia m*(w^2 + h^2)/12 at (x, z) angle phi
body hill: fixed at (0, 0) angle -20 [deg]
shape block: rectangle (w, h)
shape hill: half plane
contact block, hill: inelastic, friction 0.3
start { z: 0.5, dot(x): 1, dot(phi): -2 }
horizon 1 [s]
""",
        f"""<body><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 -1 0"/>
<geom type="box" size="0.2 0.2 0.1" mass="1"/><inertial pos="0 0 0" mass="1" diaginertia="1 {0.2 / 12} 1"/></body>
<geom type="plane" size="9 9 1" euler="0 {TILT} 0"/>""",
        ([0, 0.5, 0], [1, 0, -2]),
    ),
    "two rods and a wall": (
        """parameters { m: kg = 1, l: m = 0.6, g: m/s^2 = 9.81 }
coordinates { a: rad, b: rad }
gravity (0, -g)
body upper: mass m, inertia m*l^2/12, centre (0, -l/2), at (0, 0), angle a, tip = (0, -l)
body lower: mass m/2, inertia m*l^2/24, centre (0, -l/2), at upper.tip, angle a + b, tip = (0, -l)
body bob: mass 0.2 [kg] at lower.tip
body wall: fixed at (-0.5 [m], 0) angle -90 [deg]
shape bob: circle 5 [cm]
shape wall: half plane
contact bob, wall: restitution 0.5
start { a: 1, b: 0.3 }
horizon 2 [s]
""",
        """<body><joint type="hinge" axis="0 -1 0"/><inertial pos="0 0 -0.3" mass="1" diaginertia="1 0.03 1"/>
<body pos="0 0 -0.6"><joint type="hinge" axis="0 -1 0"/><inertial pos="0 0 -0.3" mass="0.5" diaginertia="1 0.015 1"/>
<body pos="0 0 -0.6"><inertial pos="0 0 0" mass="0.2" diaginertia="1e-9 1e-9 1e-9"/><geom type="sphere" size="0.05"/></body></body></body>
<geom type="plane" size="9 9 1" pos="-0.5 0 0" zaxis="1 0 0"/>""",
        ([1, 0.3], [0, 0]),
    ),
    "a die": (
        None,
        f"""<body><freejoint/><geom type="box" size="0.008 0.008 0.008"/>
<inertial pos="0 0 0" mass="0.005" diaginertia="{0.005 * 0.008**2 * 2 / 3} {0.005 * 0.008**2 * 2 / 3} {0.005 * 0.008**2 * 2 / 3}"/></body>
<geom type="plane" size="9 9 1"/>""",
        # spins about the axes of the body: 2 conj(q) dq
        ([0, 0, 0.1, 0.8, 0.6, 0, 0], [0.5, 0, 0, 0, 22, -4]),
    ),
}


def by_hangtime(program, scene):
    """Time of the first impact of a scene in a file, or of the shipped one."""
    with tempfile.TemporaryDirectory() as folder:
        name = "dice"
        if scene is not None:
            name = Path(folder) / "scene.hang"
            name.write_text(scene)
        command = [program, "simulate", name, "--json"]
        run = subprocess.run(command, capture_output=True, text=True, check=True)
    return next(event["time"] for event in json.loads(run.stdout)["events"] if event["kind"] == "impact")


def by_mujoco(body, start, step):
    """Time at which the least gap falls through zero; contacts are told from half a decimetre on and have no force."""
    text = f"""<mujoco><compiler angle="radian" inertiafromgeom="false"/>
<option gravity="0 0 {-G}" timestep="{step}" integrator="Euler"/>
<default><geom gap="0.05" friction="0.3"/></default><worldbody>{body}</worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = start
    before = (0.0, np.inf)
    while data.time < 2:
        mujoco.mj_forward(model, data)
        gap = min((contact.dist for contact in data.contact), default=np.inf)
        if gap <= 0:
            share = before[1] / (before[1] - gap)
            return before[0] + share * (data.time - before[0])
        before = (data.time, gap)
        mujoco.mj_step(model, data)
    raise SystemExit("no impact")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hangtime", default="target/release/hangtime")
    program = parser.parse_args().hangtime
    print("scene,hangtime [s]," + ",".join(f"MuJoCo less hangtime with {step:g} s" for step in STEPS))
    for name, (scene, body, start) in SCENES.items():
        time = by_hangtime(program, scene)
        off = [by_mujoco(body, start, step) - time for step in STEPS]
        print(f"{name},{time:.9f}," + ",".join(f"{off:.2e}" for off in off))
        if abs(off[-1]) > AGREES:
            raise SystemExit(f"{name}: the first impacts differ by {off[-1]:.2e} s")


if __name__ == "__main__":
    main()
