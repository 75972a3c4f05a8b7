"""Simulation and optimal control of mechanical systems with impacts.

>>> import hangtime as ht
>>> ride = ht.load("ride.hang")
>>> run = ride.simulate(speed="15 km/h", horizon=2)
>>> run["y"], run.time, run.events, run.at(0.7)["dot(y)"]
>>> best = ride.solve(intervals=30, progress=True)
>>> answer = ht.nlp("program.nl")

Numbers are those of the command line, bit for bit. Bad input is one exception, :class:`Mistake`, that prints like the
command line; it is a ``KeyError``, ``FileNotFoundError`` or ``TypeError`` as well where that is what it is.
"""

from ._core import Mistake, __version__
from ._mistakes import NoSuchFile, NoSuchName, WrongType
from ._program import Program, nlp
from ._result import Estimate, Event, Gradient, Run, Solution
from ._scene import Scene, load, scene, scenes
from ._sweep import Sweep, sweep

__all__ = [
    "Estimate",
    "Event",
    "Gradient",
    "Mistake",
    "NoSuchFile",
    "NoSuchName",
    "Program",
    "Run",
    "Scene",
    "Solution",
    "Sweep",
    "WrongType",
    "__version__",
    "load",
    "nlp",
    "scene",
    "scenes",
    "sweep",
]
