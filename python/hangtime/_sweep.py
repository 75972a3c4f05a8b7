"""Sweeps over parameters, by any executor, with a table that is resumed."""

from __future__ import annotations

import csv
import io
import multiprocessing
import os
import signal
import threading
import time
from collections import deque
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from . import _core
from ._core import Mistake
from ._mistakes import NoSuchName, WrongType
from ._result import _pyplot
from ._scene import Scene, Value, _checked, _text, _words

if TYPE_CHECKING:
    from concurrent.futures import Executor

#: A worker hands its rows over after about this time [s]: a call of one costs some milliseconds.
_PATIENCE = 0.25
#: Calls per worker that wait: enough that no worker does, few enough that a stop loses little.
_WAITING = 4
#: Columns of texts, also where all are empty.
_TEXTS = ("status", "message", "sequence")


class Sweep(Sequence[Dict[str, str]]):
    """The table of a sweep: rows in the order of the points, the last parameter fastest.

    ``table["objective"]`` is an array, NaN where a point failed (texts for ``status``, ``message``, ``sequence``); names
    are without units. An index gives a row as a dict of texts.
    """

    def __init__(self, header: str, lines: Iterable[str], parameters: Sequence[str]):
        self._header, self._lines, self.parameters = header, list(lines), tuple(parameters)
        self._rows = list(csv.reader(io.StringIO("\n".join([header, *self._lines]))))

    @property
    def csv(self) -> str:
        """The table as the command line writes it."""
        return "".join(line + "\n" for line in [self._header, *self._lines])

    @property
    def columns(self) -> List[str]:
        """The headings, names with units."""
        return self._rows[0]

    def __len__(self) -> int:
        return len(self._lines)

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str):
            names = [heading.split(" [")[0] for heading in self.columns]
            place = names.index(key) if key in names else -1
            if place < 0:
                raise NoSuchName(f"error: no column `{key}`; there are: {', '.join(names)}")
            cells = [row[place] for row in self._rows[1:]]
            if key in _TEXTS:
                return np.array(cells, dtype=str)
            try:
                return np.array([float(cell) if cell else np.nan for cell in cells])
            except ValueError:
                return np.array(cells)
        if isinstance(key, slice):
            return [self[k] for k in range(*key.indices(len(self)))]
        if not isinstance(key, (int, np.integer)):
            raise WrongType(f"error: {type(key).__name__} is no column and no row; columns are: {', '.join(self.columns)}")
        if not -len(self) <= key < len(self):
            raise IndexError(f"row {key} of {len(self)}")
        return dict(zip(self.columns, self._rows[1:][key]))

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame`` with the columns of the table."""
        try:
            import pandas
        except ImportError:
            raise ImportError("to_pandas needs pandas: pip install 'hangtime[pandas]'") from None
        frame = pandas.DataFrame({heading: self[heading.split(" [")[0]] for heading in self.columns})
        return frame.astype({"point": int})

    def plot(self, what: Optional[str] = None, axes: Any = None) -> Any:
        """Draws a column over the parameter as a line, or over two parameters as a map; returns matplotlib's axes.

        Changes of the contact sequence are marked: by dotted lines, in a map by lines between cells. Without ``what``
        the first recorded column is drawn.
        """
        if not 1 <= len(self.parameters) <= 2:
            raise Mistake(f"error: no picture of a sweep over {len(self.parameters)} parameters; sweep over one or two")
        pyplot = _pyplot()
        axes = axes if axes is not None else pyplot.subplots()[1]
        if what is None:
            records = self.columns[1 + len(self.parameters) + 3 : -1]
            if not records:
                raise Mistake("error: nothing was recorded; name records when you sweep")
            what = records[0].split(" [")[0]
        heading = {column.split(" [")[0]: column for column in self.columns}
        first = self[self.parameters[0]]
        # Of points that failed nothing is known, also no sequence.
        words = np.where(self["status"] == "refused", "", self["sequence"])
        if len(self.parameters) == 1:
            order = np.argsort(first, kind="stable")
            x, y, words = first[order], self[what][order], words[order]
            axes.plot(x, y, marker=".", linewidth=1)
            for k in np.flatnonzero(words[1:] != words[:-1]):
                axes.axvline((x[k] + x[k + 1]) / 2, color="0.5", linestyle=":", linewidth=1)
            axes.set_xlabel(heading[self.parameters[0]])
            axes.set_ylabel(heading[what])
            return axes
        second = self[self.parameters[1]]
        x, i = np.unique(second, return_inverse=True)
        y, j = np.unique(first, return_inverse=True)
        values = np.full((len(y), len(x)), np.nan)
        values[j, i] = self[what]
        names = np.full(values.shape, "", dtype=object)
        names[j, i] = words
        mesh = axes.pcolormesh(_edges(x), _edges(y), values)
        axes.figure.colorbar(mesh, label=heading[what])
        xe, ye = _edges(x), _edges(y)
        for a, b in zip(*np.nonzero(names[:, 1:] != names[:, :-1])):
            axes.plot([xe[b + 1]] * 2, ye[a : a + 2], color="w", linewidth=1)
        for a, b in zip(*np.nonzero(names[1:] != names[:-1])):
            axes.plot(xe[b : b + 2], [ye[a + 1]] * 2, color="w", linewidth=1)
        axes.set_xlabel(heading[self.parameters[1]])
        axes.set_ylabel(heading[self.parameters[0]])
        return axes

    def __repr__(self) -> str:
        statuses = [row[1 + len(self.parameters)] for row in self._rows[1:]]
        counts = ", ".join(f"{statuses.count(name)} {name}" for name in sorted(set(statuses)))
        return f"<hangtime sweep over {', '.join(self.parameters)}: {len(self)} points, {counts}>"

    def _repr_html_(self) -> str:
        return self.to_pandas()._repr_html_()


def _edges(centres: np.ndarray) -> np.ndarray:
    if len(centres) == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    middles = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - middles[0]], middles, [2 * centres[-1] - middles[-1]]])


@lru_cache(maxsize=4)
def _plan(origin: tuple, solve: bool, warm: int, over: tuple, words: tuple, record: tuple) -> Any:
    """A plan, made once in a process."""
    return _core.SweepPlan(Scene(origin)._core, solve, warm, list(over), list(words), list(record))


def _rows(spec: tuple, first: int, last: int) -> Tuple[List[str], int]:
    """What a worker does: rows of chains from ``first`` on, up to ``last`` or until it hands them over; and the next chain."""
    plan = _plan(*spec)
    rows: List[str] = []
    end = time.monotonic() + _PATIENCE
    for chain in range(first, last):
        rows += plan.rows(chain)
        if time.monotonic() >= end:
            return rows, chain + 1
    return rows, last


def _beside_its_parent() -> None:
    """How a worker begins: it ends when its parent does, which answers Ctrl-C for both."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def watch() -> None:
        parent.join()
        os._exit(1)

    if parent is not None:
        threading.Thread(target=watch, daemon=True).start()


def _own_workers() -> Any:
    from concurrent.futures import ProcessPoolExecutor

    # Fresh processes: a forked one has no threads of those that the solver started before.
    return ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn"), initializer=_beside_its_parent)


def _end(pool: Any) -> None:
    """Ends workers that may be in the middle of a long run."""
    workers = list((getattr(pool, "_processes", None) or {}).values())
    pool.shutdown(wait=False, cancel_futures=True)
    for worker in workers:
        worker.terminate()


def sweep(
    scene: Scene,
    over: Mapping[str, Iterable[Value]],
    what: str = "simulate",
    record: Sequence[str] = (),
    *,
    parameters: Optional[Mapping[str, Value]] = None,
    executor: Optional[Executor] = None,
    store: Any = None,
    warm: Union[bool, int] = False,
    **keywords: Any,
) -> Sweep:
    """Simulates or solves a scene over the values of its parameters.

    ``over`` gives values by parameter; every combination is a point. ``what`` is ``"simulate"`` or ``"solve"``,
    ``record`` names numbers: ``objective``, ``final_time``, ``horizon``, ``stationarity``, ``resimulation_error``,
    ``events``, ``final.NAME`` and ``final.dot(NAME)`` of a coordinate, ``output.NAME`` at the end, ``max(NAME)`` and ``min(NAME)``
    along the motion, ``force(NAME)`` for the largest force of a contact or joint, ``time(EVENT CONTACT N)``, such as
    ``time(impact floor 1)``. Other keywords are those of ``Scene.simulate`` or
    ``Scene.solve``. ``executor`` is any ``concurrent.futures.Executor``, such as Dask's ``client.get_executor()``; by
    default fresh processes, for which a script needs the usual ``if __name__ == "__main__":``. What a row holds depends
    neither on the workers nor on their order; a point that fails is a row whose status says so.

    With ``warm``, solves start from each other: the last parameter is cut into chains of ``warm`` points (``True``: 10). The
    first point of a chain starts from nothing; every other one from the motion found at the point before it, and from
    nothing where that leads to no solution. So rows depend on the values and on ``warm`` alone. A chain is computed by one
    worker; one that was cut is computed anew. Neighbours may stay in a local optimum that a start from nothing leaves.

    ``store`` is the path of a CSV file: rows are kept there and not computed again, also by ``hangtime sweep --resume``,
    whose table is the same. With a name that ends with .parquet (``pip install 'hangtime[parquet]'``) rows are kept in a CSV
    file beside it until all are known.
    """
    if not isinstance(scene, Scene):
        raise WrongType(f"error: the scene is {type(scene).__name__}: give what load, scene or scenes returned")
    if not isinstance(what, str) or what not in ("simulate", "solve"):
        raise Mistake(f"error: what = {what!r}: give 'simulate' or 'solve'")
    if not isinstance(over, Mapping):
        raise WrongType(f"error: `over` is {type(over).__name__}: give a dict of values by parameter")
    if isinstance(record, str) or not all(isinstance(name, str) for name in record):
        raise Mistake("error: `record`: give a list of names")
    spec = (
        scene._origin,
        what == "solve",
        _chain(warm),
        tuple(_axis(name, values) for name, values in over.items()),
        tuple(_words(what, parameters, keywords)),
        tuple(_checked(name) for name in record),
    )
    plan = _plan(*spec)
    kept = None if store is None else _opened(store, plan)
    lines = [] if kept is None else kept.lines
    own = None
    try:
        missing = len(lines) < len(plan)
        if missing and executor is not None and not callable(getattr(executor, "submit", None)):
            raise WrongType(f"error: `executor` is {type(executor).__name__}: give one of concurrent.futures, or None")
        if missing and executor is None:
            own = _own_workers()
        for row in _computed(own if executor is None else executor, spec, plan, len(lines)):
            lines.append(row)
            if kept is not None:
                kept.add(row)
        if own is not None:
            own.shutdown()
            own = None
    except KeyboardInterrupt:
        if kept is None:
            raise
        raise KeyboardInterrupt(
            f"{len(lines)} of {len(plan)} points are stored; the same call goes on from there, and so does --resume"
        ) from None
    finally:
        if own is not None:
            _end(own)
        if kept is not None:
            kept.close()
    table = Sweep(plan.header, lines, list(over))
    if kept is not None:
        kept.finish(table)
    return table


def _axis(name: Any, values: Any) -> str:
    if not isinstance(name, str):
        raise Mistake(f"error: `over`: {name!r} is no name of a parameter")
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise WrongType(f"error: `over`: the values of `{name}` are {type(values).__name__}: give a list or an array")
    return _checked(f"{name}={','.join(_text(name, value) for value in values)}")


def _chain(warm: Any) -> int:
    if warm is True:
        return int(_core.WARM_CHAIN)
    if warm is False or warm is None:
        return 1
    if not isinstance(warm, (int, np.integer)) or not 2 <= warm <= 2**31:
        raise Mistake(f"error: `warm`: found {warm!r}; give True, or the points of a chain, a whole number from 2")
    return int(warm)


def _computed(executor: Any, spec: tuple, plan: Any, done: int) -> Iterable[str]:
    """Rows from point ``done`` on, in order; only so many calls wait at a time, each of about as many points as fit into its time."""
    first = next((k for k in range(plan.chains) if plan.chain(k)[1] > done), plan.chains) if spec[2] > 1 else done
    # Of a chain that was begun, the points that are known are computed once more: others start from them.
    known = done - plan.chain(first)[0] if first < plan.chains else 0
    most = _WAITING * (os.cpu_count() or 1)
    waiting: Any = deque()
    ahead, size = first, 1
    try:
        while waiting or ahead < plan.chains:
            while ahead < plan.chains and len(waiting) < most:
                last = min(ahead + size, plan.chains)
                waiting.append((ahead, last, executor.submit(_rows, spec, ahead, last)))
                ahead = last
            start, last, future = waiting[0]
            rows, reached = future.result()
            waiting.popleft()
            if reached < last:
                waiting.appendleft((reached, last, executor.submit(_rows, spec, reached, last)))
                size = reached - start
            else:
                size = max(size, 2 * (last - start))
            yield from rows[known:]
            known = max(0, known - len(rows))
    finally:
        for _, _, future in waiting:
            future.cancel()


class _Store:
    """Rows of a sweep in a CSV file, each as soon as it is known.

    To a Parquet file no rows can be added: there they are kept in a CSV file beside it until all are known, and the whole
    table replaces that. Its metadata hold the rows as texts, from which it is read again to the last digit.
    """

    def __init__(self, path: str, plan: Any):
        self._parquet = path if path.endswith(".parquet") else None
        self._rows = path if self._parquet is None else path + ".csv"
        self._table: Any = None
        if self._parquet is not None:
            arrow = _arrow()
            if os.path.exists(path):
                text = (arrow.read_schema(path).metadata or {}).get(_ROWS, b"")
                self.lines = _read(path, text, plan)
                return
        self._table = _core.SweepTable(self._rows, plan)
        self.lines = list(self._table.rows)

    def add(self, row: str) -> None:
        self._table.append(row)

    def close(self) -> None:
        if self._table is not None:
            self._table.close()

    def finish(self, table: Sweep) -> None:
        """Writes the table, where rows alone do not make it up."""
        if self._parquet is None or self._table is None:
            return
        import pyarrow

        columns = pyarrow.Table.from_pandas(table.to_pandas(), preserve_index=False)
        columns = columns.replace_schema_metadata({**(columns.schema.metadata or {}), _ROWS: table.csv.encode()})
        whole = self._parquet + ".new"
        _arrow().write_table(columns, whole)
        os.replace(whole, self._parquet)
        os.remove(self._rows)


#: Key of the metadata of a Parquet file under which the rows stand as texts.
_ROWS = b"hangtime.rows"


def _arrow() -> Any:
    try:
        import pandas  # noqa: F401
        from pyarrow import parquet
    except ImportError:
        raise Mistake(
            "error: `store`: Parquet files need pandas and pyarrow: pip install 'hangtime[parquet]'; "
            "or give a name that ends with .csv"
        ) from None
    return parquet


def _opened(store: Any, plan: Any) -> _Store:
    try:
        path = os.fspath(store)
        if not isinstance(path, str) or not path.endswith((".csv", ".parquet")):
            raise Mistake(
                f"error: `store`: found {store!r}; give a name that ends with .csv or .parquet; "
                "table.to_pandas() writes other formats"
            )
        return _Store(path, plan)
    except Mistake:
        raise
    except (OSError, TypeError, ValueError) as error:
        raise Mistake(f"error: `store`: {error}; give the path of a file that can be written") from None


def _read(path: str, text: bytes, plan: Any) -> List[str]:
    """The rows of a table that was stored whole."""
    lines = text.decode("utf-8", "replace").splitlines() or [""]
    rows = lines[1:]
    fits = lines[0] == plan.header and len(rows) == len(plan)
    if not fits or any(not row.startswith(f"{k},") or not row.endswith("," + plan.mark) for k, row in enumerate(rows)):
        raise _of_another(path)
    return rows


def _of_another(path: str) -> Mistake:
    return Mistake(f"error: store `{path}` holds rows of another sweep; give another file, or remove it")
