"""Siconos: Moreau-Jean time stepping. The ski jump only: its impulses act along the normals, those of the pump track do not."""

import ctypes
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import siconos.kernel as sk

from rides import G, SKI_JUMPS
from timing import fastest

STEPS = [500, 1000, 2000, 4000, 8000, 16000]
MASS = 80.0
SURFACES = """
#define A (-0.0001524)
#define B (-0.002149)
#define C 0.4162
#define D (-9.154)
#define ARGUMENTS unsigned n, double *q, unsigned m, double *out, unsigned k, double *z
void table(ARGUMENTS) { out[0] = q[1] - ((((A * q[0] + B) * q[0] + C) * q[0] + D) * q[0] + 99.15); }
void table_normal(ARGUMENTS) { out[0] = -(((4 * A * q[0] + 3 * B) * q[0] + 2 * C) * q[0] + D); out[1] = 1; }
void slope(ARGUMENTS) { out[0] = q[1] - 45 + q[0] / 2; }
void slope_normal(ARGUMENTS) { out[0] = 0.5; out[1] = 1; }
"""


def compiled():
    """The surfaces as a library that the program finds by its name."""
    folder = Path(tempfile.mkdtemp())
    source, library = folder / "surfaces.c", folder / "surfaces.so"
    source.write_text(SURFACES)
    command = ["gcc", "-O2", "-shared", "-fPIC", "-Wl,-soname,surfaces.so", "-o", library, source]
    subprocess.run([str(word) for word in command], check=True)
    return ctypes.CDLL(str(library))


def simulate(ride, steps):
    """The coordinates at the end."""
    height = ride.table(ride.start)[0]
    body = sk.LagrangianDS(np.array([ride.start, height]), np.zeros(2), np.diag([MASS, MASS]))
    body.setFExtPtr(np.array([0.0, -MASS * G]))
    system = sk.NonSmoothDynamicalSystem(0.0, ride.horizon)
    system.insertDynamicalSystem(body)
    law = sk.NewtonImpactNSL(0.0)
    relations = [sk.LagrangianScleronomousR(f"surfaces:{name}", f"surfaces:{name}_normal") for name in ("table", "slope")]
    contacts = [sk.Interaction(law, relation) for relation in relations]
    for contact in contacts:
        system.link(contact, body)
    grid = sk.TimeDiscretisation(0.0, ride.horizon / steps)
    stepping = sk.TimeStepping(system, grid, sk.MoreauJeanOSI(0.5), sk.LCP())
    stepping.setNewtonTolerance(1e-10)
    stepping.setNewtonMaxIteration(20)
    while stepping.hasNextEvent():
        stepping.computeOneStep()
        stepping.nextStep()
    return np.array(body.q())


def points(wanted):
    """(study, curve, settings, CPU seconds, coordinates at the end) of every run of the studies that are wanted."""
    rides = [ride for ride in SKI_JUMPS if wanted(ride.study)]
    library = compiled() if rides else None
    for ride in rides:
        for steps in STEPS:
            seconds, end = fastest(lambda: simulate(ride, steps))
            yield ride.study, "Siconos", f"Moreau-Jean, {steps} steps", seconds, end
    del library
