"""The problem sets: where they are published, and how their problems are stated as `.nl` files."""

import csv
import json
import pathlib
import re
import subprocess

import casadi as ca

import cutest
import nl_writer

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
TARGET = ROOT / "target" / "problems"

# repository, commit, folder of the problems, end of their names
SOURCES = {
    "macmpec": ("https://github.com/mrsaurabhtanwar/MPECSSCODEPAPER", "293e497", "benchmarks/macmpec/macmpec-json", ".nl.json"),
    "mpeclib": ("https://github.com/mrsaurabhtanwar/MPECSSCODEPAPER", "293e497", "benchmarks/mpeclib/mpeclib-json", ".nl.json"),
    "tsc": ("https://github.com/blegat/MacMPEC.jl", "6e1375a", "data/ampl", ".dat"),
    "nosbench": ("https://github.com/nosnoc/nosbench", "8f44ce4", "problems/casadi", ".json"),
    "cutest": ("https://github.com/GrattonToint/S2MPJ", "35c9dcab", "python_problems", ".py"),
}


class Source:
    """A pinned commit: its id is the checksum of every file in it, and each file is checked against it."""

    def __init__(self, name, clones):
        self.url, self.commit, self.folder, self.end = SOURCES[name]
        repository = self.url.split("/")[-1]
        given = [path for path in clones if repository in str(path)]
        self.path = given[0] if given else TARGET / "sources" / repository
        if not self.path.exists():
            self.path.parent.mkdir(parents=True, exist_ok=True)
            subprocess.run(["git", "clone", "--quiet", self.url, self.path], check=True)
        listing = self.git("ls-tree", "-r", self.commit, f"{self.folder}/").decode()
        entries = (line.split(None, 3)[2:] for line in listing.splitlines())
        self.files = {path.split("/")[-1]: checksum for checksum, path in entries}

    def git(self, *arguments, **options):
        return subprocess.run(["git", "-C", self.path, *arguments], check=True, capture_output=True, **options).stdout

    def names(self):
        return sorted(name[: -len(self.end)] for name in self.files if name.endswith(self.end))

    def read(self, file):
        """The bytes of a file, or `None` where the clone does not hold it."""
        checksum = self.files[file]
        try:
            data = self.git("cat-file", "blob", checksum)
        except subprocess.CalledProcessError:
            return None
        if self.git("hash-object", "--stdin", input=data).decode().strip() != checksum:
            raise SystemExit(f"{file}: its checksum is not {checksum}; clone {self.url} again")
        return data


def vector(values):
    return [float(value) for value in (values if isinstance(values, list) else [values])]


class Statement:
    """A program under construction: variables may be added for sides that are none."""

    def __init__(self, names, lower, upper, start):
        self.x = [ca.SX.sym(name) for name in names]
        self.bounds = list(zip(lower, upper))
        self.start = list(start)
        self.rows = []
        self.index = {symbol.__hash__(): k for k, symbol in enumerate(self.x)}

    def variable(self, expression, lower, upper):
        """The variable that an expression with these bounds is, or a new one with a row."""
        known = self.index.get(expression.__hash__()) if expression.is_symbolic() else None
        if known is not None and self.bounds[known] == (lower, upper):
            return known
        self.x.append(ca.SX.sym(f"side{len(self.x)}"))
        self.bounds.append((lower, upper))
        self.start.append(0.0)
        self.rows.append((self.x[-1] - expression, (0.0, 0.0)))
        return len(self.x) - 1

    def complement(self, body, side, lower, upper):
        flags = (lower > -float("inf")) + 2 * (upper < float("inf"))
        self.rows.append((body, ("complements", flags, self.variable(side, lower, upper))))

    def text(self, objective):
        return nl_writer.write(ca.vertcat(*self.x), objective, self.rows, self.bounds, self.start)


def from_json(data, objective_key):
    problem = json.loads(data)
    size = len(vector(problem["w0"]))
    statement = Statement([f"w{k}" for k in range(size)], vector(problem["lbw"]), vector(problem["ubw"]), vector(problem["w0"]))
    w = ca.vertcat(*statement.x)
    arguments = [w] + ([ca.DM(vector(problem["p0"]))] if "p0" in problem else [])

    def call(key):
        if problem.get(key) is None:
            return []
        function = ca.Function.deserialize(problem[key])
        return ca.vertsplit(ca.SX(function(*arguments[: function.n_in()]))) if function.numel_out() else []

    for row, lower, upper in zip(call("g_fun"), vector(problem["lbg"]), vector(problem["ubg"])):
        statement.rows.append((row, (lower, upper)))
    bodies, sides = call("G_fun"), call("H_fun")
    infinite = float("inf")
    lower = vector(problem.get("lbH", [0.0] * len(sides)))
    upper = vector(problem.get("ubH", [infinite] * len(sides)))
    for body, side, l, u in zip(bodies, sides, lower, upper):
        if (l, u) == (0.0, infinite) and not side.is_symbolic() and body.is_symbolic():
            body, side = side, body
        statement.complement(body, side, l, u)
    objective = call(objective_key)
    return statement.text(objective[0] if objective else ca.SX(0))


def traffic(data):
    """TSC: the average waiting time at a signalized intersection (Ribeiro and Simoes, 2010), in its own words

        min sum_i 1/lambda_i (L0_i/2 + sum_j L_ij + L_i,2N+1/2) / (2N + 1)
        s.t. 0 <= L_ij <= xmax, gmin <= y <= gmax, L_ij the larger one of the queue before plus its change, and of what comes in.
    """
    text = re.sub(r"#.*", "", data.decode())
    scalars = {name: float(value) for name, value in re.findall(r"param\s+(\w+)\s*:=\s*([-\d.eE+]+)\s*;", text)}
    tables = {name: [float(v) for v in values.split()[1::2]] for name, values in re.findall(r"param\s+(\w+)\s*:=([^;]*);", text)}
    count, streams = int(scalars["N"]), len(tables["lambda"])
    last = 2 * count + 1
    names = [f"L{i}_{j}" for i in range(streams) for j in range(last)] + ["red", "green"]
    bounds = [(0.0, scalars["xmax"])] * (streams * last) + [(scalars["gmin"], scalars["gmax"])] * 2
    statement = Statement(names, [b[0] for b in bounds], [b[1] for b in bounds], [0.0] * len(names))
    queue = lambda i, j: statement.x[i * last + j]
    y = statement.x[-2:]
    objective, pairs, infinite = 0, [], float("inf")
    for i in range(streams):
        b1, b2, b3, b4, b5, b6 = (tables.get(f"b{k}", [0.0] * streams)[i] for k in range(1, 7))
        share = 1 / (2 * (2 * count + 1))
        inner = sum(queue(i, j) for j in range(last - 1)) * 2 * share
        objective += (share * tables["L0"][i] + inner + share * queue(i, last - 1)) / tables["lambda"][i]
        for j in range(last):
            before = tables["L0"][i] if j == 0 else queue(i, j - 1)
            falls = j % 2 == 1 or j == 0
            change, least = (b1 * y[1] + b3, b5) if falls else (b2 * y[0] + b4, b6)
            pairs.append((queue(i, j) - before - change, queue(i, j) - least))
    for first, second in pairs:
        statement.rows += [(first, (0.0, infinite)), (second, (0.0, infinite))]
    for first, second in pairs:
        statement.complement(first, second, 0.0, infinite)
    return statement.text(objective)


def state_cutest(source, problem, text, path):
    """Writes the file of a problem, or beside it why there is none; whether it was written."""
    reason = path.with_suffix(".skipped")
    if reason.exists():
        return False
    library = source.git("show", f"{source.commit}:s2mpjlib.py").decode()
    try:
        path.write_text(cutest.state(library, problem, text))
    except cutest.Skipped as skipped:
        reason.write_text(f"{skipped}\n")
        return False
    return True


def fetch(name, clones):
    """States every problem that can be had as a file; returns paths and how many were not there."""
    folder = TARGET / name
    folder.mkdir(parents=True, exist_ok=True)
    missing = 0
    parts = {"macmpec": [("macmpec", lambda data: from_json(data, "f_fun")), ("tsc", traffic)],
             "mpeclib": [("mpeclib", lambda data: from_json(data, "f_fun"))],
             "nosbench": [("nosbench", lambda data: from_json(data, "augmented_objective_fun"))],
             "cutest": [("cutest", None)]}
    for part, state in parts[name]:
        source = Source(part, clones)
        for problem in source.names():
            if part == "tsc" and not problem.startswith("TSC-"):
                continue
            path = folder / f"{problem}.nl"
            if path.exists():
                continue
            data = source.read(problem + source.end)
            if data is None:
                missing += 1
                continue
            if part == "cutest":
                missing += not state_cutest(source, problem, data.decode(), path)
                continue
            path.write_text(state(data))
    return sorted(folder.glob("*.nl")), missing


def known(name):
    """Best known objectives by problem; infinite where the problem is known to be infeasible."""
    table = HERE / f"{name}.csv"
    if not table.exists():
        return {}
    with open(table, newline="") as file:
        rows = [(row["name"], row["best"].replace("infeasible", "inf")) for row in csv.DictReader(file)]
        return {name: float(best) for name, best in rows if best}
