"""Writes `.nl` files (text) from CasADi expressions: parts that stand twice become common expressions."""

import casadi as ca

BINARY = {ca.OP_ADD: 0, ca.OP_SUB: 1, ca.OP_MUL: 2, ca.OP_DIV: 3, ca.OP_POW: 5, ca.OP_CONSTPOW: 5, ca.OP_ATAN2: 48,
          ca.OP_LT: 22, ca.OP_LE: 23, ca.OP_EQ: 24, ca.OP_NE: 30}
LISTS = {ca.OP_FMIN: 11, ca.OP_FMAX: 12}
UNARY = {ca.OP_NEG: 16, ca.OP_EXP: 44, ca.OP_LOG: 43, ca.OP_SQRT: 39, ca.OP_SIN: 41, ca.OP_COS: 46, ca.OP_TAN: 38,
         ca.OP_ASIN: 51, ca.OP_ACOS: 53, ca.OP_ATAN: 49, ca.OP_SINH: 40, ca.OP_COSH: 45, ca.OP_TANH: 37,
         ca.OP_ASINH: 50, ca.OP_ACOSH: 52, ca.OP_ATANH: 47, ca.OP_FABS: 15}


def number(value):
    return f"n{float(value)!r}"


class Expressions:
    """The instructions of an SX function of one vector, without reuse of memory."""

    def __init__(self, function):
        self.nodes, self.outputs = [], {}
        place = {}
        for k in range(function.n_instructions()):
            code = function.instruction_id(k)
            reads, writes = function.instruction_input(k), function.instruction_output(k)
            if code == ca.OP_OUTPUT:
                self.outputs[tuple(writes)] = place[reads[0]]
                continue
            if code == ca.OP_CONST:
                node = ("constant", function.instruction_constant(k))
            elif code == ca.OP_INPUT:
                node = ("input", reads[1])
            else:
                node = (code, *[place[r] for r in reads])
            self.nodes.append(node)
            place[writes[0]] = len(self.nodes) - 1
        uses = [0] * len(self.nodes)
        for node in self.nodes:
            if node[0] not in ("constant", "input"):
                for operand in node[1:]:
                    uses[operand] += 1
        for root in self.outputs.values():
            uses[root] += 1
        shared = [i for i, node in enumerate(self.nodes) if uses[i] > 1 and node[0] not in ("constant", "input")]
        self.common = {node: rank for rank, node in enumerate(shared)}

    def lines(self, root, variables, whole=False):
        """Prefix notation; `whole` writes the node itself out even if it is common."""
        lines, stack = [], [(root, whole)]
        while stack:
            item, whole = stack.pop()
            if isinstance(item, str):
                lines.append(item)
                continue
            if item in self.common and not whole:
                lines.append(f"v{variables + self.common[item]}")
                continue
            code, *operands = self.nodes[item]
            if code == "constant":
                lines.append(number(operands[0]))
                continue
            if code == "input":
                lines.append(f"v{operands[0]}")
                continue
            if code in BINARY:
                head, parts = [f"o{BINARY[code]}"], operands
            elif code in LISTS:
                head, parts = [f"o{LISTS[code]}", str(len(operands))], operands
            elif code in UNARY:
                head, parts = [f"o{UNARY[code]}"], operands
            elif code == ca.OP_SQ:
                head, parts = ["o5"], [operands[0], "n2"]
            elif code == ca.OP_TWICE:
                head, parts = ["o2"], ["n2", operands[0]]
            elif code == ca.OP_INV:
                head, parts = ["o3"], ["n1", operands[0]]
            elif code == ca.OP_IF_ELSE_ZERO:
                head, parts = ["o35"], [*operands, "n0"]
            else:
                raise ValueError(f"CasADi operation {code} has no operator in .nl files")
            lines.extend(head)
            stack.extend((part, False) for part in reversed(parts))
        return lines


def bound(lower, upper):
    infinite = float("inf")
    if lower == -infinite and upper == infinite:
        return "3"
    if lower == -infinite:
        return f"1 {upper!r}"
    if upper == infinite:
        return f"2 {lower!r}"
    return f"4 {lower!r}" if lower == upper else f"0 {lower!r} {upper!r}"


def write(x, objective, rows, bounds, start):
    """The text of a file. `rows` are (expression, (lower, upper)) or (expression, ("complements", flags, variable)); all
    expressions are SX in the symbols `x`."""
    functions = ca.Function("all", [x], [ca.vertcat(objective, *[row for row, _ in rows])])
    variables = x.numel()
    expressions = Expressions(functions)
    ranges = sum(1 for _, demand in rows if demand[0] != "complements" and demand[0] != demand[1])
    lines = ["g3 1 1 0", f" {variables} {len(rows)} 1 {ranges} 0", f" {len(rows)} 1", " 0 0", f" {variables} {variables} {variables}",
             " 0 0 0 1", " 0 0 0 0 0", " 0 0", " 0 0", f" {len(expressions.common)} 0 0 0 0"]
    for node, rank in expressions.common.items():
        lines += [f"V{variables + rank} 0 0", *expressions.lines(node, variables, whole=True)]
    roots = [expressions.outputs.get((0, k)) for k in range(len(rows) + 1)]
    body = lambda root: ["n0"] if root is None else expressions.lines(root, variables)
    for k in range(len(rows)):
        lines += [f"C{k}", *body(roots[k + 1])]
    lines += ["O0 0", *body(roots[0])]
    lines += [f"x{variables}", *[f"{k} {float(value)!r}" for k, value in enumerate(start)]]
    lines.append("r")
    for _, demand in rows:
        lines.append(f"5 {demand[1]} {demand[2] + 1}" if demand[0] == "complements" else bound(*map(float, demand)))
    lines.append("b")
    lines += [bound(float(lower), float(upper)) for lower, upper in bounds]
    return "\n".join(lines) + "\n"
