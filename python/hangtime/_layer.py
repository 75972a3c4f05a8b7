"""Motions as functions of numbers, with all their derivatives: what the layers of other libraries call."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Mapping, Sequence, Tuple

import numpy as np

from ._core import Mistake
from ._result import Run
from ._scene import Scene

_EVENT_TIMES = "event_times["


def _value(run: Run, name: str) -> float:
    """A value at the end of a motion, or the time of an event."""
    if name.startswith(_EVENT_TIMES) and name.endswith("]"):
        return float(run.events[int(name[len(_EVENT_TIMES) : -1])].time)
    return float(run[name][-1])


class Layer:
    """Chosen values at the end of motions of a scene, as a function of some of its parameters."""

    def __init__(self, scene: Scene, names: Sequence[str], of: Sequence[str], keywords: Mapping[str, Any]):
        self.scene, self.names, self.of = scene, list(names), [of] if isinstance(of, str) else list(of)
        self.keywords = dict(keywords)
        if not self.names or not self.of:
            raise Mistake("error: a layer needs parameters, and `of`, names of values at the end")
        if "objective" in self.of:
            raise Mistake("error: `of`: a simulation has no value of the objective; declare it in `outputs`")

    def one(self, values: Sequence[float]) -> Tuple[np.ndarray, np.ndarray]:
        """Values, shape (values,), and derivatives, shape (values, parameters), at one place."""
        asked = {"gradient": self.names, "gradient_of": self.of, **self.keywords}
        run = self.scene.simulate(parameters=dict(zip(self.names, map(float, values))), **asked)
        if run.status != "solved" or run.gradient is None:
            raise Mistake(f"error: no motion: {run.status}")
        rows = run.gradient.values
        return np.array([_value(run, name) for name in self.of]), np.array([rows[name] for name in self.of])

    def all(self, values: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """The same at many places, shape (.., parameters), side by side: shapes (.., values) and (.., values, parameters)."""
        values = np.asarray(values, dtype=float)
        places = values.reshape(-1, len(self.names))
        if len(places) == 1:
            found = [self.one(places[0])]
        else:
            with ThreadPoolExecutor(os.cpu_count()) as threads:
                found = list(threads.map(self.one, places))
        batch = values.shape[:-1]
        results = np.array([one[0] for one in found]).reshape(*batch, len(self.of))
        rows = np.array([one[1] for one in found]).reshape(*batch, len(self.of), len(self.names))
        return results, rows
