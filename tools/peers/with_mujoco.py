"""MuJoCo: a block on the rough incline, with elliptic cones. Its contacts are soft, so that friction creeps: the step is not all that its
error depends on."""

import mujoco

from math import cos, radians, sin

from rides import G
from timing import fastest

STUDY = "incline"
ANGLE, MU, SPEED, HORIZON = radians(15), 0.5, 3.0, 2.0
STEPS = [1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4]
SCENE = f"""
<mujoco>
  <option gravity="{G * sin(ANGLE)} 0 {-G * cos(ANGLE)}" timestep="%g" cone="elliptic" impratio="100" integrator="implicitfast"/>
  <worldbody>
    <geom type="plane" size="20 1 1" friction="{MU} 0 0" condim="3"/>
    <body pos="0 0 0.1">
      <joint type="slide" axis="1 0 0"/>
      <joint type="slide" axis="0 0 1"/>
      <geom type="box" size="0.1 0.1 0.1" mass="2" friction="{MU} 0 0" condim="3"/>
    </body>
  </worldbody>
</mujoco>
"""


def slide(model, steps):
    """The coordinates at the end: the axes of the model go along the incline."""
    data = mujoco.MjData(model)
    data.qvel[0] = SPEED
    mujoco.mj_step(model, data, nstep=steps)
    along, above = data.qpos
    return along * cos(ANGLE) + above * sin(ANGLE), -along * sin(ANGLE) + above * cos(ANGLE)


def points(wanted):
    """(study, curve, settings, CPU seconds, coordinates at the end) of every run of the studies that are wanted."""
    for step in STEPS if wanted(STUDY) else []:
        model = mujoco.MjModel.from_xml_string(SCENE % step)
        seconds, end = fastest(lambda: slide(model, round(HORIZON / step)))
        yield STUDY, "MuJoCo", f"steps of {step:g} s", seconds, end
