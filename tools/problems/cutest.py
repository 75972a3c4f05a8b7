"""CUTEst problems as `.nl` files: the Python classes of S2MPJ with CasADi symbols in place of numbers."""

import signal
import types

import casadi as ca
import numpy as np

import nl_writer

# numbers of this size are infinite in SIF
INFINITE = 1e20
# more variables, rows or seconds of processor time than that are not stated
LARGEST, SECONDS = 3000, 10


class Skipped(Exception):
    """Why a problem is not stated."""


class Symbol:
    """A number that is not known yet, as an entry of NumPy's arrays, which call the methods below."""

    def __init__(self, value):
        self.value = value

    def __bool__(self):
        raise Skipped("a branch depends on the variables")

    __float__ = __int__ = __index__ = __bool__


def of(value):
    return value.value if isinstance(value, Symbol) else ca.SX(float(value))


def binary(name):
    return lambda a, b: Symbol(getattr(of(a), name)(of(b)))


for operation in ("add", "sub", "mul", "truediv", "pow"):
    setattr(Symbol, f"__{operation}__", binary(f"__{operation}__"))
    setattr(Symbol, f"__r{operation}__", lambda a, b, name=f"__{operation}__": Symbol(getattr(of(b), name)(of(a))))
for comparison in ("lt", "le", "gt", "ge", "eq", "ne"):
    setattr(Symbol, f"__{comparison}__", lambda a, b: a.__bool__())
Symbol.__neg__ = lambda a: Symbol(-a.value)
Symbol.__pos__ = lambda a: a
Symbol.__abs__ = lambda a: Symbol(ca.fabs(a.value))
Symbol.arctan2 = lambda a, b: Symbol(ca.atan2(of(a), of(b)))
Symbol.log10 = lambda a: Symbol(ca.log(a.value) / np.log(10.0))
for function in ("sin", "cos", "tan", "arcsin", "arccos", "arctan", "sinh", "cosh", "tanh", "exp", "log", "sqrt"):
    setattr(Symbol, function, lambda a, name=function.replace("arc", "a"): Symbol(getattr(ca, name)(a.value)))


class Arrays(types.ModuleType):
    """NumPy, but for arrays that take symbols."""

    def __getattr__(self, name):
        return getattr(np, name)

    zeros = staticmethod(lambda shape, **_: np.full(shape, 0.0, dtype=object))


def scalar(value):
    while isinstance(value, np.ndarray):
        value = value.reshape(-1)[0]
    return value if isinstance(value, Symbol) else float(value)


def load(library, name, text):
    """An instance of the class of a problem with its default size; its functions take symbols."""
    names = {}
    exec(compile(library, "s2mpjlib", "exec"), names)
    text = text.replace("from s2mpjlib import *", "")
    build, mark, functions = text.partition("    @staticmethod")
    names["symbolic_arrays"], names["symbolic_scalar"] = Arrays("arrays"), scalar
    functions = functions.replace("import numpy as np", "np = symbolic_arrays").replace("to_scalar(", "symbolic_scalar(")
    exec(compile(build + mark + functions, name, "exec"), names)
    return names[next(key for key, item in names.items() if isinstance(item, type) and getattr(item, "name", None) == name)]()


def entry(values, index):
    """An entry of a list that may be shorter, or `None`."""
    return values[index] if values is not None and index < len(values) else None


class Groups:
    """The groups of a problem: functions of a constant, a linear term and weighted elements."""

    def __init__(self, problem, x):
        self.problem, self.x = problem, x
        self.linear = problem.A.tocsr() if hasattr(problem, "A") else None
        if self.linear is not None:
            self.linear.sum_duplicates()
        problem.getglobs()

    def value(self, group):
        problem, x = self.problem, self.x
        constant = entry(getattr(problem, "gconst", None), group)
        total = 0.0 if constant is None else -scalar(constant)
        if self.linear is not None and group < self.linear.shape[0]:
            row = self.linear[group]
            for column, factor in zip(row.indices, row.data):
                total = total + x[column] * float(factor)
        elements = entry(getattr(problem, "grelt", None), group)
        weights = entry(getattr(problem, "grelw", None), group)
        for rank, element in enumerate([] if elements is None else elements):
            element = int(element)
            variables = np.array([[x[int(v)]] for v in problem.elvar[element]], dtype=object)
            part = scalar(getattr(problem, problem.elftype[element])(problem, 1, variables, element))
            total = total + (part if weights is None or weights[rank] is None else part * float(weights[rank]))
        function = entry(getattr(problem, "grftype", None), group)
        if function is not None and function != "TRIVIAL":
            total = scalar(getattr(problem, function)(problem, 1, total, group))
        scale = entry(getattr(problem, "gscale", None), group)
        return total if scale is None or abs(scale) <= 1e-15 else total * (1.0 / float(scale))

    def objective(self):
        total = sum((self.value(int(group)) for group in getattr(self.problem, "objgrps", [])), 0.0)
        if hasattr(self.problem, "H"):
            square = self.problem.H.tocoo()
            for i, j, factor in zip(square.row, square.col, square.data):
                total = total + self.x[i] * self.x[j] * (0.5 * float(factor))
        return total

    def rows(self):
        return [self.value(int(group)) for group in getattr(self.problem, "congrps", [])]


def limits(lower, upper, count):
    read = lambda values, infinite: [infinite] * count if values is None else [float(v) for v in np.asarray(values, dtype=float).reshape(-1)]
    far = lambda v: v if abs(v) < INFINITE else float("inf") * np.sign(v)
    return [(far(l), far(u)) for l, u in zip(read(lower, -float("inf")), read(upper, float("inf")))]


def state(library, name, text):
    """The text of the `.nl` file of a problem; [`Skipped`] says why there is none."""

    def late(*_):
        raise Skipped(f"more than {SECONDS} s")

    signal.signal(signal.SIGVTALRM, late)
    signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS, 1.0)
    try:
        problem = load(library, name, text)
        kinds = getattr(problem, "xtype", [])
        if any(kind in ("b", "i") for kind in kinds):
            raise Skipped("integers")
        n, m = problem.n, getattr(problem, "m", 0)
        if max(n, m) > LARGEST:
            raise Skipped(f"{n} variables, {m} rows")
        symbols = [ca.SX.sym(f"x{k}") for k in range(n)]
        groups = Groups(problem, [Symbol(symbol) for symbol in symbols])
        objective, rows = of(groups.objective()), [of(row) for row in groups.rows()]
        ranges = limits(getattr(problem, "clower", None), getattr(problem, "cupper", None), m)
        bounds = limits(problem.xlower, problem.xupper, n)
        start = np.asarray(problem.x0, dtype=float).reshape(-1)
        return nl_writer.write(ca.vertcat(*symbols), objective, list(zip(rows, ranges)), bounds, start)
    except Skipped:
        raise
    except Exception as error:
        # what the class does with a number that it cannot do with a symbol, or a mistake in it
        raise Skipped(f"{type(error).__name__}: {error}") from error
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
