"""Scenes: declared by a file, by a text, or shipped."""

from __future__ import annotations

import math
import numbers
import os
import sys
import time
from contextlib import contextmanager
from typing import Any, Callable, Iterator, List, Literal, Mapping, NamedTuple, Optional, Sequence, Union

from . import _core
from ._core import Mistake
from ._mistakes import NoSuchFile, NoSuchName, WrongType
from ._result import Estimate, Gradient, Run, Solution

Value = Union[float, int, str]
#: A name or several.
Names = Union[str, Sequence[str]]
#: What tells how far a run is: true for a line in the terminal, or what is called with the time reached [s] and a text.
Telling = Union[bool, Callable[[Optional[float], str], Any]]
Method = Literal["fesd", "event", "moreau", "smooth", "fixed"]
Scheme = Literal["radau-iia", "gauss-legendre"]
_OPTIONS: dict = {}


class Parameter(NamedTuple):
    """A parameter of a scene."""

    name: str
    unit: str
    """Declared unit; empty for a number."""
    value: float
    """Value without settings, in that unit."""
    documentation: str


def _options(command: str) -> frozenset:
    if command not in _OPTIONS:
        _OPTIONS[command] = frozenset(name.replace("-", "_") for name in _core.options(command))
    return _OPTIONS[command]


def _text(name: str, value: Any) -> str:
    """A value as it would stand on the command line: a number with all its digits, or a text with a unit."""
    if isinstance(value, str):
        return value
    if not isinstance(value, (bool, bytes)) and getattr(value, "shape", None) == ():
        value = value.item()
    if isinstance(value, numbers.Integral) and not isinstance(value, bool):
        return str(int(value))
    if isinstance(value, numbers.Real) and not isinstance(value, bool):
        value = float(value)
        return repr(value) if math.isfinite(value) else str(value)
    raise WrongType(
        f"error: `{name}` is {type(value).__name__}: give a number in the declared unit, or a text such as '15 km/h'"
    )


def _words(command: str, parameters: Optional[Mapping[str, Value]], keywords: Mapping[str, Any]) -> List[str]:
    """Keywords as the words that stand behind the scene on the command line."""
    if parameters is not None and not isinstance(parameters, Mapping):
        raise WrongType(f"error: `parameters` is {type(parameters).__name__}: give a dict of values by name")
    settings = dict(parameters or {})
    words = []
    for name, value in keywords.items():
        if name not in _options(command):
            if name in settings:
                raise Mistake(f"error: `{name}` is given twice; keep one of them")
            settings[name] = value
        elif value is None or value is False:
            continue
        elif value is True:
            words.append(f"--{name.replace('_', '-')}")
        elif name in ("gradient", "gradient_of"):
            words.append(f"--{name.replace('_', '-')}={_names(name, value)}")
        else:
            words.append(f"--{name.replace('_', '-')}={_text(name, value)}")
    for name, value in settings.items():
        if not isinstance(name, str):
            raise Mistake(f"error: `parameters`: {name!r} is no name; give a dict of values by name")
        words.append(f"--set={name}={_text(name, value)}")
    return [_checked(word) for word in words]


def _given(arguments: Mapping[str, Any], others: Sequence[str]) -> dict:
    """The options among the arguments of a method that were given."""
    return {name: value for name, value in arguments.items() if name not in others and value is not None}


def _names(option: str, value: Any) -> str:
    """Names, one or several, as one word."""
    names = [value] if isinstance(value, str) else value
    if not isinstance(names, (list, tuple)) or not names or not all(isinstance(name, str) for name in names):
        raise Mistake(f"error: `{option}`: found {value!r}; give a name or a list of names")
    return ",".join(names)


def _checked(text: str) -> str:
    """The text, if it is one that can be handed on: no lone surrogates."""
    try:
        text.encode()
    except UnicodeEncodeError:
        raise Mistake(f"error: {text!r} is no valid text; write it in Unicode") from None
    return text


class _Bar:
    """A line in the terminal, or below a cell, that says how far a run is."""

    def __init__(self, name: str, end: Optional[float] = None):
        self.name, self.end, self.width = name, end, 0
        self.start = time.monotonic()

    def __call__(self, reached: Optional[float], words: str) -> None:
        line = f"{self.name} {time.monotonic() - self.start:.0f} s: {words}"[:118]
        sys.stderr.write("\r" + line.ljust(self.width))
        sys.stderr.flush()
        self.width = len(line)

    def close(self) -> None:
        if self.width:
            sys.stderr.write("\r" + " " * self.width + "\r")
            sys.stderr.flush()


@contextmanager
def _telling(name: str, progress: Any) -> Iterator[Optional[Callable[[Optional[float], str], Any]]]:
    """What a run is to tell its progress, if anything: a callable that was given, or a line that ends with the run."""
    if callable(progress):
        yield progress
    elif progress is None or progress is False:
        yield None
    elif progress is True:
        bar = _Bar(name)
        try:
            yield bar
        finally:
            bar.close()
    else:
        raise WrongType(f"error: `progress` is {type(progress).__name__}: give True, or what is called with time and text")


class Scene:
    """A mechanical system with impacts, as declared in the modelling language.

    Made by :func:`load`, :func:`scene` and :data:`scenes`. Scenes pickle.
    """

    def __init__(self, origin: tuple):
        self._origin = origin
        kind, name, text = origin
        self._core = _core.Scene.of_text(name, text) if kind == "text" else _core.Scene.open(name)

    def __reduce__(self):
        return Scene, (self._origin,)

    @property
    def name(self) -> str:
        """Name of the scene."""
        return self._core.name

    @property
    def title(self) -> str:
        """What it is, in one line."""
        return self._core.title

    @property
    def text(self) -> Optional[str]:
        """The text that declares it; ``None`` for a shipped scene."""
        return self._origin[2]

    @property
    def check(self) -> str:
        """Warnings about its text, as the command line prints them; empty if there are none."""
        return self._core.warnings

    @property
    def parameters(self) -> dict:
        """The parameters by name: unit, value without settings, documentation."""
        return {row[0]: Parameter(*row) for row in self._core.parameters()}

    def explain(self, *, parameters: Optional[Mapping[str, Value]] = None, size: bool = False, **keywords: Any) -> str:
        """Derived equations, sparsity patterns and operation counts; with ``size`` the sizes of every formulation."""
        return self._core.explain(_words("explain", parameters, {"size": size, **keywords}))

    def simulate(
        self,
        *,
        parameters: Optional[Mapping[str, Value]] = None,
        progress: Telling = False,
        method: Optional[Method] = None,
        scheme: Optional[Scheme] = None,
        stages: Optional[int] = None,
        steps: Optional[int] = None,
        elements: Optional[int] = None,
        formulation: Optional[Literal["active-set", "time-freezing"]] = None,
        tolerance: Optional[float] = None,
        max_step: Optional[Value] = None,
        width: Optional[float] = None,
        horizon: Optional[Value] = None,
        gradient: Optional[Names] = None,
        gradient_of: Optional[Names] = None,
        gradient_mode: Optional[Literal["forward", "adjoint"]] = None,
        rows: Optional[int] = None,
        time_limit: Optional[Value] = None,
        **values: Value,
    ) -> Run:
        """Simulates the scene.

        ``values`` are parameters of the scene, as numbers in the declared unit or texts with a unit (``"15 km/h"``); all other keywords
        are options of ``hangtime simulate``, times in seconds. Further options, such as ``no_exit_condition=True``, are taken as well. The
        motion is differentiated by the names in ``gradient``, for :attr:`Run.gradient`: all of it, or with ``gradient_of`` values at the
        end alone (``"objective"``, coordinates, outputs, ``"event_times[0]"``). A parameter with the name of an option is set by
        ``parameters={"name": value}``.

        The interpreter's lock is released. Ctrl-C raises ``KeyboardInterrupt``.
        """
        options = _given(locals(), ("self", "parameters", "progress", "values"))
        words = _words("simulate", parameters, {**options, **values})
        return Run._of(self._run("simulate", words, values, progress), self, "simulate", words)

    def gradient(
        self, *names: str, parameters: Optional[Mapping[str, Value]] = None, **keywords: Any
    ) -> Gradient:
        """Derivatives of a simulated motion by parameters or initial values, exact through impacts.

        Names are those of parameters, or of coordinates and velocities ``dot(NAME)`` at the start; without any, all
        parameters. Keywords are those of :meth:`simulate`; with ``gradient_of`` the derivatives are those of chosen values at the
        end, computed backwards where they are fewer than the names. For an optimum: ``solve(gradient=[...]).gradient``.
        """
        asked = list(names) or list(self.parameters)
        if not asked:
            raise Mistake("error: the scene has no parameters; give names of coordinates to differentiate by")
        run = self.simulate(parameters=parameters, gradient=asked, **keywords)
        if run.gradient is None:
            raise Mistake(f"error: no derivatives: {run.status}")
        return run.gradient

    def solve(
        self,
        *,
        parameters: Optional[Mapping[str, Value]] = None,
        start: Optional[Solution] = None,
        progress: Telling = False,
        intervals: Optional[int] = None,
        controls: Optional[Literal["constant", "linear"]] = None,
        grid: Optional[Literal["equal", "aligned"]] = None,
        formulation: Optional[Literal["auto", "time-freezing"]] = None,
        scheme: Optional[Scheme] = None,
        stages: Optional[int] = None,
        elements: Optional[int] = None,
        starts: Optional[int] = None,
        patience: Optional[float] = None,
        horizon: Optional[Value] = None,
        gradient: Optional[Names] = None,
        rows: Optional[int] = None,
        time_limit: Optional[Value] = None,
        **values: Value,
    ) -> Union[Solution, Estimate]:
        """Solves the scene's problem of optimal control, or estimates parameters where it compares with measurements.

        ``values`` are parameters, as in :meth:`simulate`; all other keywords are options of ``hangtime solve``. The optimum is
        differentiated by the parameters in ``gradient``. ``start`` is an earlier solution of the scene, for other parameters or
        intervals, whose motion is started from. Ctrl-C ends the solve with the best motion so far, whose status is ``interrupted``.
        """
        options = _given(locals(), ("self", "parameters", "start", "progress", "values"))
        words = _words("solve", parameters, {**options, **values})
        more = {} if start is None else {"start": _native(start)}
        run = self._run("solve", words, values, progress, **more)
        kind = Estimate if run.is_estimate else Solution
        return kind._of(run, self, "solve", words)

    def _run(self, command: str, words: List[str], keywords: Mapping[str, Any], progress: Any, **more: Any) -> Any:
        with _telling(self.name, progress) as told:
            try:
                return getattr(self._core, command)(words, told, **more)
            except Mistake as mistake:
                if any(f"has no parameter `{name}`" in str(mistake) for name in keywords):
                    # As Python refuses a keyword that a function does not have.
                    raise WrongType(str(mistake)) from None
                raise

    def __repr__(self) -> str:
        return f"<hangtime scene {self.name}: {self.title}>"

    def _repr_html_(self) -> str:
        from html import escape

        rows = "".join(
            f"<tr><td>{escape(p.name)}</td><td>{p.value!r}</td><td>{escape(p.unit)}</td>"
            f"<td>{escape(p.documentation)}</td></tr>"
            for p in self.parameters.values()
        )
        return (
            f"<b>{escape(self.name)}</b>: {escape(self.title)}<table><tr><th>parameter</th><th>value</th><th>unit</th>"
            f"<th></th></tr>{rows}</table>"
        )


def _native(start: Any) -> Any:
    """The run of a solution that a solve is to start from."""
    if not isinstance(start, Solution):
        raise WrongType(f"error: `start` is {type(start).__name__}: give what solve returned")
    if start._native is None:
        raise Mistake("error: `start` was pickled, which keeps no motion to start from; solve it again")
    return start._native


def load(path: Union[str, "os.PathLike[str]"]) -> Scene:
    """The scene of a file, whose name ends with ``.hang``.

    The text is read once: the scene stays what it was when the file changes.
    """
    try:
        path = os.fspath(path)
    except TypeError:
        raise WrongType(f"error: a path is needed, not {type(path).__name__}") from None
    if not isinstance(path, str) or not path.endswith(".hang"):
        raise Mistake(f"error: `{path!r}`: give a scene file, whose name ends with .hang")
    # The native part reads it as the command line does, and refuses it with the same words.
    try:
        _core.Scene.open(_checked(path))
    except Mistake as mistake:
        if os.path.exists(path):
            raise
        raise NoSuchFile(str(mistake)) from None
    try:
        with open(path, encoding="utf-8") as file:
            text = file.read()
    except (OSError, ValueError) as error:
        raise Mistake(f"error: {path}: {error}; give a scene file that can be read") from None
    # Files that it names are looked for beside it, wherever the working folder is by then.
    return Scene(("text", os.path.splitext(os.path.abspath(path))[0], text))


def scene(text: str, name: str = "scene") -> Scene:
    """The scene that a text declares, under a name."""
    for what, value in (("text", text), ("name", name)):
        if not isinstance(value, str):
            raise WrongType(f"error: the {what} of a scene is {type(value).__name__}: give a text")
    return Scene(("text", _checked(name), _checked(text)))


class _Scenes:
    """The shipped scenes, as attributes and by name: ``scenes.ski_jump``, ``scenes["ski-jump"]``."""

    def __getattr__(self, name: str) -> Scene:
        known = name.replace("_", "-")
        if known not in _core.scene_names():
            raise AttributeError(f"no shipped scene `{name}`; there are: {', '.join(dir(self))}")
        return self[known]

    def __getitem__(self, name: str) -> Scene:
        if not isinstance(name, str) or name.endswith(".hang"):
            raise NoSuchName(f"error: {name!r} is no name of a shipped scene; they are: {', '.join(self)}")
        if name not in _core.scene_names():
            raise NoSuchName(f"error: no shipped scene `{name}`; they are: {', '.join(self)}")
        return Scene(("shipped", _checked(name), None))

    def __iter__(self) -> Iterator[str]:
        return iter(_core.scene_names())

    def __len__(self) -> int:
        return len(_core.scene_names())

    def __dir__(self) -> List[str]:
        return [name.replace("-", "_") for name in _core.scene_names()]


scenes = _Scenes()
