"""Results: arrays, events, tables, pictures."""

from __future__ import annotations

import json
import os
from html import escape
from typing import TYPE_CHECKING, Any, Dict, Iterable, Iterator, List, Optional, Type, TypeVar

import numpy as np

from ._core import Mistake
from ._mistakes import NoSuchName, WrongType

Motion = TypeVar("Motion", bound="Run")
#: Parts of a trajectory that hold a vector at every instant.
_PARTS = ("q", "v", "states", "u", "contact_force", "friction_force", "outputs")
#: In shorter intervals [s], relative to the time, rounding dominates the slope of the coordinates.
_SHORT = 1e-8
#: A part that a motion does not have.
_NOTHING = np.zeros((0, 0))
_NOTHING.flags.writeable = False


def _must(name: str, doc: str) -> Any:
    """A field of the document as an attribute."""
    return property(lambda result: result.document[name], doc=doc)


def _may(name: str, doc: str) -> Any:
    """The same of a field that some documents do not have; then it is ``None``."""
    return property(lambda result: result.document.get(name), doc=doc)


class Event:
    """An impact, or a change of a contact: ``time`` [s], ``kind``, ``contact``, and states by name."""

    def __init__(self, entry: Dict[str, Any]):
        self.time: float = entry["time"]
        self.kind: str = entry["kind"]
        self.contact: str = entry["contact"]
        self.q = np.array(entry["q"])
        """Coordinates, shape (n,)."""
        self.v_before = np.array(entry["v_before"])
        """Velocities right before, shape (n,)."""
        self.v_after = np.array(entry["v_after"])
        """Velocities right after, shape (n,)."""
        self.states = np.array(entry.get("states", ()))
        """States of first order, which an impact leaves as they are; shape (states,)."""
        self.contact_impulse = np.array(entry.get("contact_impulse", ()))
        """Normal impulses of an impact, shape (contacts,); empty for other events."""
        self.friction_impulse = np.array(entry.get("friction_impulse", ()))
        """Tangential impulses of an impact, shape (contacts,); empty for other events and without friction."""

    def __repr__(self) -> str:
        return f"<{self.kind} {self.contact} at {self.time!r} s>"


class Gradient:
    """Derivatives of a motion by :attr:`with_respect_to`, one a column; NaN where there is none."""

    def __init__(self, entry: Dict[str, Any], names: Dict[str, List[str]]):
        self.with_respect_to: List[str] = list(entry["with_respect_to"])
        """Names of the columns."""
        self.mode: str = entry.get("mode", "forward")
        """``forward``, or ``adjoint``, which has nothing but :attr:`values` and :attr:`objective`."""
        self.values = {name: _row(row) for name, row in entry.get("values", {}).items()}
        """Of the values at the end that ``gradient_of=`` chose, by name, shape (columns,)."""
        count = len(self.with_respect_to)
        last, exists = entry.get("final", {}), entry.get("exists", True)
        rows = [pair for part in last for pair in zip(names[part], last[part])]
        self.final: Dict[str, np.ndarray] = {name: _row(row) for name, row in rows}
        """Of the state at the end, by name, shape (columns,)."""
        self.event_times = _matrix(entry.get("event_times", ()), count)
        """Of the times of events, shape (events, columns)."""
        self.outputs = {name: _matrix(rows, count) for name, rows in entry.get("outputs", {}).items()}
        """Of each output, by name, shape (rows, columns)."""
        self.objective = _row(entry["objective"]) if "objective" in entry else None
        """Of the objective, shape (columns,); ``None`` where there is none."""
        self.final_time = _row(entry["final_time"]) if "final_time" in entry else None
        """Of the final time of an optimum, shape (columns,); ``None`` for a simulation."""
        self.error_estimate: Optional[float] = entry.get("error_estimate")
        """How far derivatives may be off, as a share of the largest change of each value that they tell of; ``None`` where that is not known."""
        self.range: List[Dict[str, Any]] = list(entry.get("range", ()))
        """How far each quantity may go until the events are others, to first order: ``below`` and ``above``, each with ``change``
        and ``because``, or ``None``."""
        by: List[Any] = entry.get("exists_by", exists if isinstance(exists, list) else [exists] * count)
        self.obstacles: List[Optional[str]] = [None if exists is True else exists for exists in by]
        """Why there is no derivative, a word a column; ``None`` where there is one."""
        self.obstacle: Optional[str] = next((why for why in self.obstacles if why), None)
        """The first of :attr:`obstacles`, if there is one."""
        self.sides: Dict[str, Any] = entry.get("sides") or entry.get("one_sided") or {}
        """Derivatives to both sides where there are no others, as in the JSON."""

    def __repr__(self) -> str:
        return f"<hangtime gradient by {', '.join(self.with_respect_to)}{': ' + self.obstacle if self.obstacle else ''}>"


class State(Dict[str, float]):
    """The state at one instant: values by the names of :attr:`Run.units`."""

    def __missing__(self, name: str) -> float:
        raise NoSuchName(f"error: no quantity `{name}`; there are: {', '.join(self)}")


class Run:
    """A motion. ``run["y"]`` is an array over :attr:`time`; :attr:`units` lists names and units.

    Velocities are ``dot(y)``, contact forces ``contact force NAME``. Runs pickle.
    """

    _document: Optional[Dict[str, Any]] = None
    _columns: Optional[Dict[str, tuple]] = None
    _native: Any
    _scene: Any
    _command: str
    _words: List[str]
    _arrays: Dict[str, np.ndarray]
    _json: Optional[str]
    _pages: Optional[Dict[str, str]]

    @classmethod
    def _of(cls: Type[Motion], core: Any, scene: Any, command: str, words: List[str]) -> Motion:
        run = cls.__new__(cls)
        run._native, run._scene, run._command, run._words = core, scene, command, words
        run._arrays = {}
        run._json = run._pages = None
        return run

    def __getstate__(self) -> Dict[str, Any]:
        kept = {"_scene": self._scene, "_command": self._command, "_words": self._words, "_json": self.json}
        # A solve takes long: its pages go along; those of a simulation are made again.
        return {**kept, "_native": None, "_arrays": {}, "_pages": self.files if self._command == "solve" else None}

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """A field of the document that has no attribute of its own, as it stands there."""
            if name.startswith("_") or name not in self.document:
                raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")
            return self.document[name]

    @property
    def json(self) -> str:
        """What the command line prints with ``--json``, one line."""
        if self._json is None:
            self._json = self._native.json
        return self._json

    @property
    def document(self) -> Dict[str, Any]:
        """The same as a dict, with every number of the contract."""
        if self._document is None:
            self._document = json.loads(self.json)
        return self._document

    @property
    def files(self) -> Dict[str, str]:
        """What the command line writes with ``--out``: data, figures and a page, by name."""
        if self._pages is None:
            native = self._native
            if native is None:
                native = getattr(self._scene._core, self._command)(self._words)
            self._pages = dict(native.files())
        return self._pages

    @property
    def status(self) -> str:
        """``solved``, or the name of what went wrong."""
        return self._native.status if self._native is not None else self.document["status"]

    @property
    def diagnosis(self) -> Optional[str]:
        """Why it did not end with a solution."""
        found = self.document.get("diagnosis")
        return found["message"] if isinstance(found, dict) else found

    notes: List[str] = _must("notes", "Remarks that a user should read.")
    scene: str = _must("scene", "Name of the scene.")
    schema: int = _must("schema", "Version of the document's layout.")
    parameters: Dict[str, Any] = _must(
        "parameters",
        "Values of all parameters by name, in their declared units; those that a solve has found too. Choices are texts.",
    )
    method: Dict[str, Any] = _must("method", "The method and its settings.")
    error_estimate: Optional[float] = _may(
        "error_estimate",
        "Estimated distance of the motion from the exact one, in the units of the scene; ``None`` where there is none.",
    )
    residuals: Dict[str, float] = _must("residuals", "``primal``, ``dual`` and ``complementarity``.")
    size: Dict[str, int] = _must(
        "size", "Numbers of variables, rows, pairs and nonzeros of the largest system or program."
    )
    iterations: Dict[str, int] = _must("iterations", "Work done.")
    seconds: Dict[str, float] = _must("seconds", "CPU times [s].")

    @property
    def initially(self) -> Dict[str, str]:
        """What each contact does from the start on, by name: of that there is no event."""
        return {entry["contact"]: entry["mode"] for entry in self.document["initially"]}

    @property
    def joints(self) -> Dict[str, np.ndarray]:
        """Forces of joints by name, shape (rows,), or (rows, equations) for a joint with several."""
        joints = self.document.get("joints", {})
        return {name: np.array(entry["force"], dtype=float) for name, entry in joints.items()}

    @property
    def gradient(self) -> Optional[Gradient]:
        """The derivatives that were asked for by ``gradient=``; ``None`` where none were."""
        if "gradient" not in self.document:
            return None
        quantities = self.document["quantities"]
        names = {part: [entry["name"] for entry in quantities.get(part, ())] for part in ("q", "states")}
        names["v"] = [f"dot({name})" for name in names["q"]]
        return Gradient(self.document["gradient"], names)

    @property
    def time(self) -> np.ndarray:
        """Instants [s], shape (rows,); an instant with an impact stands there twice, before and after."""
        return self._part("time")

    horizon: float = _must("horizon", "Length of the motion that was asked for [s].")

    @property
    def events(self) -> List[Event]:
        """Impacts and changes of contacts in order."""
        return [Event(entry) for entry in self.document["events"]]

    @property
    def units(self) -> Dict[str, str]:
        """Names of all quantities with their units; a number has an empty one."""
        return {name: unit for name, (_, _, unit) in self._named().items()}

    def _named(self) -> Dict[str, tuple]:
        if self._columns is None:
            quantities = {part: self._quantities(part) for part in _PARTS}
            columns: Dict[str, tuple] = {"time": ("time", None, "s")}
            for part in _PARTS:
                for index, (name, unit) in enumerate(quantities[part]):
                    name = f"dot({quantities['q'][index][0]})" if part == "v" else name
                    columns.setdefault(name, (part, index, unit))
            self._columns = columns
        return self._columns

    def _quantities(self, part: str) -> List[tuple]:
        """Names and units of the columns of a part."""
        if self._native is not None:
            return self._native.quantities(part)
        entries = self.document["quantities"].get(part, ())
        return [(entry["name"], entry["unit"]) for entry in entries]

    def _part(self, part: str) -> np.ndarray:
        if part not in self._arrays:
            if self._native is not None:
                # A view of what the native part has written: no text on the way.
                found = self._native.part(part)
                width, numbers = found if found is not None else (0, b"")
                array = np.frombuffer(numbers)
            else:
                rows = self.document["trajectory"].get(part, [])
                array = np.array(rows, dtype=float)
                array.flags.writeable = False
                width = array.shape[1] if array.ndim == 2 else 1
            self._arrays[part] = array if part == "time" else array.reshape(-1, width) if width else _NOTHING
        return self._arrays[part]

    def __getitem__(self, name: str) -> np.ndarray:
        """All values of a quantity, shape (rows,), in the unit of :attr:`units`; read-only."""
        named = self._named()
        if not isinstance(name, str) or name not in named:
            raise NoSuchName(f"error: no quantity {name!r}; there are: {', '.join(named)}")
        part, index, _ = named[name]
        return self._part(part) if index is None else self._part(part)[:, index]

    def __iter__(self) -> Iterator[str]:
        return iter(self._named())

    def __contains__(self, name: object) -> bool:
        return name in self._named()

    def keys(self) -> List[str]:
        """Names of all quantities."""
        return list(self._named())

    @property
    def final(self) -> State:
        """The state at the end."""
        if not len(self.time):
            raise Mistake(f"error: no motion: {self.status}")
        return State({name: float(self[name][-1]) for name in self})

    def at(self, time: float) -> State:
        """The state at a time [s], right after an impact at that time.

        Between two instants, at distance h, coordinates follow the cubic through both states, and velocities its
        derivative: accurate to h^4 and h^3. States of first order, controls, forces and outputs are linear. Nothing reaches
        over an impact.
        """
        t = self.time
        try:
            time = float(time)
        except (TypeError, ValueError):
            raise WrongType(f"error: the time is {type(time).__name__}: give a number of seconds") from None
        if not len(t) or not t[0] <= time <= t[-1]:
            simulated = f"it has instants from {t[0]} s to {t[-1]} s" if len(t) else "it has no motion"
            raise Mistake(f"error: time {time} s was not simulated; {simulated}")
        k = int(np.searchsorted(t, time, side="right")) - 1
        rows = {part: self._part(part) for part in _PARTS}
        if t[k] == time or k + 1 == len(t):
            values = {part: row[k] for part, row in rows.items() if len(row)}
        else:
            values = _between(t, rows, k, time)
        named = self._named().items()
        return State(
            {name: time if index is None else float(values[part][index]) for name, (part, index, _) in named}
        )

    def sample(self, times: Iterable[float]) -> Dict[str, np.ndarray]:
        """All quantities at times of one's own [s], in any order: arrays of shape (times,) by the names of :attr:`units`.

        Each is what :meth:`at` gives: right after an impact at that time, and between instants as accurate.
        """
        try:
            chosen = np.asarray(times, dtype=float)
        except (TypeError, ValueError):
            raise WrongType(f"error: `times` is {type(times).__name__}: give numbers of seconds") from None
        states = [self.at(time) for time in np.atleast_1d(chosen)]
        return {name: np.array([state[name] for state in states]) for name in self}

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame`` with a column a quantity, indexed by time; units are in ``attrs["units"]``."""
        try:
            import pandas
        except ImportError:
            raise ImportError("to_pandas needs pandas: pip install 'hangtime[pandas]'") from None
        names = [name for name in self if name != "time"]
        frame = pandas.DataFrame({name: self[name] for name in names}, index=pandas.Index(self.time, name="time"))
        frame.attrs["units"] = self.units
        return frame

    def plot(self, *names: str, axes: Any = None) -> Any:
        """Draws quantities over time, by default all coordinates, and returns matplotlib's axes."""
        pyplot = _pyplot()
        names = names or tuple(name for name, _ in self._quantities("q"))
        axes = axes if axes is not None else pyplot.subplots()[1]
        for name in names:
            unit = self.units.get(name, "")
            axes.plot(self.time, self[name], label=f"{name} [{unit}]" if unit else name)
        for event in self.document["events"]:
            axes.axvline(event["time"], color="0.8", linewidth=0.8, zorder=0)
        axes.set_xlabel("time [s]")
        axes.legend()
        return axes

    @property
    def svg(self) -> str:
        """A picture of the motion, or of its quantities over time where the scene has no picture."""
        pictures = {name: text for name, text in self.files.items() if name.endswith(".svg")}
        others = ("-time.svg", "-search.svg", "-measured.svg", "-residuals.svg")
        chosen = [name for name in pictures if not name.endswith(others)] or list(pictures)
        if not chosen:
            raise Mistake(f"error: no motion to draw: {self.status}")
        return pictures[chosen[0]]

    def play(self, height: int = 640) -> "Player":
        """The player of the motion, which a notebook shows inline, so many pixels high; ``.save(path)`` writes it as a page."""
        if not isinstance(height, (int, np.integer)) or isinstance(height, bool) or height < 1:
            raise Mistake(f"error: `height`: found {height!r}; give a whole number of pixels")
        pages = [text for name, text in self.files.items() if name.endswith(".html")]
        if not pages:
            raise Mistake(f"error: no motion to play: {self.status}")
        return Player(pages[0], height)

    def _facts(self) -> List[tuple]:
        document = self.document
        facts = [("status", self.status), ("horizon", f"{self.horizon!r} s"), ("events", len(document["events"]))]
        facts += [(f"final {name}", f"{value!r} {self.units[name]}") for name, value in self._end().items()]
        return facts

    def _end(self) -> Dict[str, float]:
        coordinates = {name for name, _ in self._quantities("q")}
        return {name: value for name, value in self.final.items() if name in coordinates} if len(self.time) else {}

    def __repr__(self) -> str:
        facts = ", ".join(f"{name} {value}" for name, value in self._facts())
        return f"<hangtime {self._command} {self._scene.name}: {facts}>"

    def _repr_html_(self) -> str:
        rows = "".join(f"<tr><td>{escape(str(a))}</td><td>{escape(str(b))}</td></tr>" for a, b in self._facts())
        picture = self.svg if len(self.time) else ""
        return f"<table>{rows}</table>{picture}"


class Solution(Run):
    """A plan: the re-simulated motion, and what belongs to the plan."""

    @property
    def objective(self) -> float:
        """Value of what is minimized; NaN without a plan."""
        return _number(self.document["objective"])

    resimulated_objective: Optional[float] = _may(
        "resimulated_objective", "The same of the event-driven simulation; ``None`` where it has none."
    )
    stationarity: str = _must("stationarity", "``S``, ``B``, or ``none``.")
    optima: List[Dict[str, Any]] = _must("optima", "The distinct local optima that were found.")
    improvements: List[Dict[str, Any]] = _must(
        "improvements", "The first motion that was confirmed, and every better one after it."
    )
    starts: int = _must("starts", "Motions from which the best order of contacts was solved.")
    bound: Optional[float] = _may(
        "bound", "Least objective of an order of contacts that reaches the goals off the grid; ``None`` where none does."
    )
    words: Dict[str, int] = _must("words", "Orders of contacts: ``tried``, and ``failed`` ones, which are undecided.")

    @property
    def free(self) -> Dict[str, Dict[str, Any]]:
        """Free parameters that were found, by name: ``value``, ``unit``, ``range``, and ``at_bound`` at an end of it."""
        return self.document.get("free", {})

    excess: List[Dict[str, Any]] = _must("excess", "Violations between the places where a condition is imposed.")
    margins: List[Dict[str, Any]] = _must("margins", "Distances that the method keeps, and what they cost.")
    time_freezing: Optional[Dict[str, Any]] = _may(
        "time_freezing", "The complementarity problem of that formulation, where it was asked for."
    )

    @property
    def controls(self) -> np.ndarray:
        """Controls, as the command line's JSON has them, shape (intervals, controls)."""
        return np.array(self.document["controls"], dtype=float)

    @property
    def resimulated(self) -> float:
        """Distance of the event-driven simulation under these controls from the plan, at the end; NaN without a plan."""
        return _number(self.document["resimulation_error"])

    #: The same under its name in the document.
    resimulation_error = resimulated

    def _facts(self) -> List[tuple]:
        plan = [("objective", repr(self.objective)), ("stationarity", self.stationarity)]
        return super()._facts() + plan + [("re-simulated", f"{self.resimulated!r} away")]


class Estimate(Run):
    """Parameters that were estimated: the motion of the first experiment, and what belongs to the estimate."""

    objective: float = _must("objective", "The misfit: squares of all residuals in standard deviations, added up.")

    @property
    def values(self) -> Dict[str, float]:
        """The values that were found, by parameter."""
        return {name: found["value"] for name, found in self.document["free"].items()}

    @property
    def deviations(self) -> Dict[str, Optional[float]]:
        """Their standard deviations; ``None`` at a bound, and where the measurements determine nothing."""
        return {name: found["deviation"] for name, found in self.document["free"].items()}

    @property
    def covariance(self) -> np.ndarray:
        """Covariance of the parameters in the order of :attr:`values`; not a number where there is none."""
        return np.array(self.document["knowledge"]["covariance"], dtype=float)

    @property
    def correlation(self) -> np.ndarray:
        """Correlation of the parameters, likewise."""
        return np.array(self.document["knowledge"]["correlation"], dtype=float)

    experiments: List[Dict[str, Any]] = _must(
        "experiments", "Measured and computed values and residuals, an experiment each."
    )

    def _facts(self) -> List[tuple]:
        found = self.document["free"].items()
        values = [(name, f"{entry['value']!r} +- {entry['deviation']!r} {entry['unit']}".rstrip()) for name, entry in found]
        return super()._facts() + [("misfit", repr(self.objective))] + values


class Player:
    """A page that plays a motion and loads nothing from elsewhere."""

    def __init__(self, page: str, height: int):
        self.page, self.height = page, height

    def save(self, path: Any) -> None:
        """Writes the page."""
        try:
            with open(os.fspath(path), "w", encoding="utf-8") as file:
                file.write(self.page)
        except (OSError, TypeError, ValueError) as error:
            raise Mistake(f"error: {error}; give the path of a file that can be written") from None

    def _repr_html_(self) -> str:
        frame = "width:100%;border:0"
        return f'<iframe srcdoc="{escape(self.page)}" style="{frame};height:{int(self.height)}px"></iframe>'


def _number(value: Optional[float]) -> float:
    """A number of the document, whose ``null`` is none."""
    return float("nan") if value is None else value


def _row(values: Any) -> np.ndarray:
    return np.array(values, dtype=float)


def _matrix(rows: Any, width: int) -> np.ndarray:
    return np.array(rows, dtype=float).reshape(-1, width)


def _between(t: np.ndarray, rows: Dict[str, np.ndarray], k: int, time: float) -> Dict[str, np.ndarray]:
    """The values between instant k and the next."""
    h = t[k + 1] - t[k]
    s = (time - t[k]) / h
    values = {part: row[k] + s * (row[k + 1] - row[k]) for part, row in rows.items() if len(row)}
    (q0, q1), (v0, v1) = rows["q"][k : k + 2], rows["v"][k : k + 2]
    rise = q1 - q0
    a, b = h * v0 - rise, rise - h * v1
    values["q"] = q0 + s * (rise + (1 - s) * ((1 - s) * a + s * b))
    if h > _SHORT * max(abs(t[k]), 1.0):
        values["v"] = (rise + (1 - s) * (1 - 3 * s) * a + s * (2 - 3 * s) * b) / h
    return values


def _pyplot() -> Any:
    try:
        from matplotlib import pyplot
    except ImportError:
        raise ImportError("plots need matplotlib: pip install 'hangtime[plot]'") from None
    return pyplot
