"""Programs from files, which modelling languages write."""

from __future__ import annotations

import json
import os
from html import escape
from typing import Any, Callable, Dict, List, Optional, Union

import numpy as np

from . import _core
from ._core import Mistake
from ._mistakes import NoSuchName, WrongType
from ._result import _may, _must
from ._scene import _checked, _telling, _text


class Program:
    """A solved program. ``program["x[3]"]`` is the value of a variable; arrays are read-only, in the order of the file."""

    x: np.ndarray
    """Variables, shape (variables,)."""
    multipliers: np.ndarray
    """Rates of change of the objective with the right-hand sides of the rows, shape (rows,); 0 for rows that complement
    a variable."""
    lower_multipliers: np.ndarray
    """Rates of change of the objective with the lower bounds of the variables, shape (variables,)."""
    upper_multipliers: np.ndarray
    """The same with the upper bounds."""
    variables: List[str]
    """Names of the variables: those of the ``.col`` file beside the program, or ``x[0]``, ``x[1]``, ..."""
    rows: List[str]
    """Names of the rows: those of the ``.row`` file, or ``c[0]``, ``c[1]``, ..."""
    json: str
    """What ``hangtime nlp`` prints with ``--json``, one line."""
    sol: str
    """The solution file that modelling languages read, as ``hangtime nlp --sol`` writes it."""
    _document: Dict[str, Any]

    @classmethod
    def _of(cls, core: Any) -> "Program":
        program = cls.__new__(cls)
        numbers = [np.frombuffer(part) for part in core.numbers()]
        program.x, program.multipliers, program.lower_multipliers, program.upper_multipliers = numbers
        program.variables, program.rows = core.names()
        program.json, program.sol = core.json, core.sol
        program._document = json.loads(program.json)
        return program

    @property
    def document(self) -> Dict[str, Any]:
        """The same as a dict, with every number of the contract."""
        return self._document

    status: str = _must("status", "``solved``, or the name of what went wrong.")
    diagnosis: Optional[str] = _may("diagnosis", "Why the point is no certified solution.")

    @property
    def objective(self) -> float:
        """Value of the objective of the file; NaN where it has none at the point."""
        value = self._document["objective"]
        return float("nan") if value is None else value

    stationarity: str = _must("stationarity", "The certificate: ``S``, ``B``, or ``none``.")
    second_order: Optional[str] = _may(
        "second_order", "What second derivatives say of a point that is strongly stationary."
    )
    residuals: Dict[str, float] = _must("residuals", "``primal``, ``dual`` and ``complementarity``, unscaled.")
    size: Dict[str, int] = _must("size", "Numbers of variables, rows, pairs and nonzeros.")
    iterations: Dict[str, int] = _must("iterations", "Work done.")
    seconds: Dict[str, float] = _must("seconds", "CPU time [s].")

    def __getitem__(self, name: str) -> float:
        if not isinstance(name, str) or name not in self.variables:
            some = ", ".join(self.variables[:20]) + (", ..." if len(self.variables) > 20 else "")
            raise NoSuchName(f"error: no variable {name!r}; there are: {some}")
        return float(self.x[self.variables.index(name)])

    def __repr__(self) -> str:
        facts = f"{self.status}, objective {self.objective!r}, stationarity {self.stationarity}"
        return f"<hangtime program {self._document['file']}: {facts}>"

    def _repr_html_(self) -> str:
        shown = ("status", "objective", "stationarity", "second_order", "residuals", "size", "iterations")
        rows = [(name, getattr(self, name)) for name in shown]
        cells = "".join(f"<tr><td>{escape(name)}</td><td>{escape(str(value))}</td></tr>" for name, value in rows)
        return f"<table>{cells}</table>"


def nlp(
    path: Union[str, "os.PathLike[str]"],
    *,
    progress: Union[bool, Callable[[Optional[float], str], Any]] = False,
    **options: Any,
) -> Program:
    """Solves the program of a ``.nl`` file, as ``hangtime nlp`` does; such files AMPL, Pyomo and JuMP write.

    Options are those of the protocol of modelling languages: ``tol``, ``constr_viol_tol``, ``max_iter``, ``time_limit``
    [s], ``starts``, and ``warm_start`` (whether multipliers in the file are started from). The interpreter's lock is
    released. Ctrl-C ends the solve with the point that it has reached, whose status is ``interrupted``.
    """
    try:
        path = os.fspath(path)
    except TypeError:
        raise WrongType(f"error: a path is needed, not {type(path).__name__}") from None
    if not isinstance(path, str):
        raise Mistake(f"error: `{path!r}`: give the name of a .nl file as a text")
    pairs = [(name, _option(name, value)) for name, value in options.items() if value is not None]
    with _telling(os.path.basename(path), progress) as told:
        return Program._of(_core.solve_program(_checked(path), pairs, told))


def _option(name: str, value: Any) -> str:
    if value is True or value is False:
        return "yes" if value else "no"
    return _checked(_text(name, value))
