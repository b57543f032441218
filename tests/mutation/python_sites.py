"""The mutants of a Python file, found and applied in its syntax tree.

Not mutated: text, annotations, decorators, imports, asserts, and the keywords of PLAIN.
"""

import ast
import copy
import re

from mutant import CLASSES, RELATIONS, SWAPS, Mutant, number, one_line

BINARY = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.FloorDiv: "//",
    ast.Mod: "%",
    ast.Pow: "**",
    ast.LShift: "<<",
    ast.RShift: ">>",
    ast.BitAnd: "&",
    ast.BitOr: "|",
    ast.BitXor: "^",
}
COMPARISON = {
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
    ast.Eq: "==",
    ast.NotEq: "!=",
    ast.Is: "is",
    ast.IsNot: "is not",
    ast.In: "in",
    ast.NotIn: "not in",
}
NEGATED = {"is": "is not", "is not": "is", "in": "not in", "not in": "in"}
NODE = {text: kind for table in (BINARY, COMPARISON) for kind, text in table.items()}
# Keywords that decide the look of a figure or a file, or nothing here.
PLAIN = re.compile(
    "figsize|fontsize|linewidth|lw|alpha|zorder|dpi|labelpad|indent|width|markersize|capsize|pad|"
    "length|rotation|exist_ok|parents|check|flush|daemon|text|capture_output"
)
LISTS = ("body", "orelse", "finalbody", "handlers", "cases")
SKIPPED = (ast.Import, ast.ImportFrom, ast.Global, ast.Nonlocal, ast.Assert)
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


class Place:
    """A statement with mutants. body and index: where it stands; None: it runs at import, and
    `names` are those that it defines.
    """

    def __init__(self, body=None, index=0, names=()):
        self.body, self.index, self.names = body, index, set(names)
        self.mutants = []
        self.changes = []  # (node, field, index in the field or None, new value) of each mutant


class File:
    """The places of a file. Its mutants are numbered from `first`."""

    def __init__(self, name, text, first=1):
        self.name, self.lines, self.places = name, text.splitlines(), []
        self.tree = ast.parse(text)
        self.statements(self.tree.body, "module", True)
        self.places = [place for place in self.places if place.mutants]
        self.mutants = number([place.mutants for place in self.places], first)

    def mutated(self, chosen):
        """The tree with one mutant."""
        for place in self.places:
            for mutant, (node, field, at, new) in zip(place.mutants, place.changes):
                if mutant.id == chosen:
                    if at is None:
                        setattr(node, field, new)
                    else:
                        getattr(node, field)[at] = new
        return ast.fix_missing_locations(self.tree)

    def recording(self):
        """The tree in which each statement with mutants first sets its byte in davar_reached."""
        for place in sorted(self.places, key=lambda place: -place.index):
            if place.body is not None:
                mark = ast.parse(f"davar_reached[{place.mutants[0].id}] = 1").body[0]
                old = place.body[place.index]
                place.body.insert(place.index, ast.copy_location(mark, old))
        return ast.fix_missing_locations(self.tree)

    def statements(self, body, function, at_import, names=()):
        for index, statement in enumerate(body):
            is_text = isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)
            if isinstance(statement, SKIPPED) or is_text:
                continue
            if at_import:
                place = Place(names={*names, *mentioned(statement, ast.Store)})
            else:
                place = Place(body, index)
            self.places.append(place)
            self.statement(statement, body, place, function, at_import)

    def statement(self, node, body, place, function, at_import):
        self.function = function
        if isinstance(node, FUNCTIONS + (ast.ClassDef,)):
            inner = node.name if function == "module" else f"{function}.{node.name}"
            if isinstance(node, ast.ClassDef):
                return self.statements(node.body, inner, True, {node.name})
            has_text = len(node.body) > 1 and isinstance(node.body[0], ast.Expr)
            place = Place(node.body, int(has_text))
            self.places.append(place)
            self.function = inner
            for default in (*node.args.defaults, *filter(None, node.args.kw_defaults)):
                self.expression(default, node.args, place)
            return self.statements(node.body, inner, False)
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            return None
        self.removal(node, body, place)
        for field, value in ast.iter_fields(node):
            if field in LISTS and isinstance(value, list):
                for one in value:
                    if isinstance(one, (ast.ExceptHandler, ast.match_case)):
                        self.statements(one.body, function, at_import)
                if value and isinstance(value[0], ast.stmt):
                    self.statements(value, function, at_import)
                self.function = function
            elif field not in ("annotation", "target", "targets", "type_comment"):
                self.fields(node, field, value, place)
        for target in (*getattr(node, "targets", ()), getattr(node, "target", None)):
            if target is not None and not isinstance(target, ast.Name):
                self.expression(target, node, place)
        return None

    def fields(self, node, field, value, place):
        for at, one in enumerate(value) if isinstance(value, list) else ((None, value),):
            if isinstance(one, ast.AST):
                self.change_constant(one, node, field, at, place)
                self.change_condition(one, node, field, at, place)
                self.expression(one, node, place)

    def add(self, place, kind, node, before, after, change):
        line = self.lines[node.lineno - 1]
        mutant = Mutant(
            *(self.name, self.function, node.lineno, kind),
            *(one_line(before), one_line(after), one_line(line)),
        )
        place.mutants.append(mutant)
        place.changes.append(change)

    def swap(self, place, kind, node, field, at, other):
        """Another operator in `node`."""
        before = ast.unparse(node)
        changed = copy.deepcopy(node)
        change = (node, field, at, NODE[other]())
        if at is None:
            setattr(changed, field, change[3])
        else:
            getattr(changed, field)[at] = change[3]
        self.add(place, kind, node, before, ast.unparse(changed), change)

    def expression(self, node, parent, place):
        if is_plain(node):
            return
        if isinstance(node, ast.BinOp):
            self.operator(node, (node.left, node.right), place)
        elif isinstance(node, ast.Compare):
            for at, operator in enumerate(node.ops):
                text = COMPARISON[type(operator)]
                others = RELATIONS.get(text) or (NEGATED.get(text) or SWAPS[text],)
                for other in others:
                    self.swap(place, "relational", node, "ops", at, other)
        elif isinstance(node, ast.BoolOp):
            other = ast.Or() if isinstance(node.op, ast.And) else ast.And()
            after = ast.unparse(ast.BoolOp(other, node.values))
            change = (node, "op", None, other)
            self.add(place, "logical", node, ast.unparse(node), after, change)
        for field, value in ast.iter_fields(node):
            if not (isinstance(node, ast.FormattedValue) and field == "format_spec"):
                self.fields(node, field, value, place)

    def operator(self, node, operands, place):
        text = BINARY.get(type(node.op))
        if text and not any(map(is_text, operands)):
            self.swap(place, CLASSES[text], node, "op", None, SWAPS[text])

    def change_constant(self, node, parent, field, at, place):
        """Numbers and truth values; a minus, a `not` removed."""
        if is_plain(parent):
            return
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.Not, ast.Invert)):
            kind = {ast.USub: "arithmetic", ast.Not: "logical"}.get(type(node.op), "bitwise")
            before, after = ast.unparse(node), ast.unparse(node.operand)
            self.add(place, kind, node, before, after, (parent, field, at, node.operand))
        if not isinstance(node, ast.Constant):
            return
        value = node.value
        if isinstance(value, bool):
            others = [not value]
        elif isinstance(value, int):
            others = [value + 1, value - 1] if value else [1]
        elif isinstance(value, float):
            others = [value + 1.0, value * 1.01] if value else [1.0]
        else:
            others = []
        for other in others:
            new = ast.copy_location(ast.Constant(other), node)
            self.add(place, "constant", node, repr(value), repr(other), (parent, field, at, new))

    def change_condition(self, node, parent, field, at, place):
        """Negated, unless it is a comparison or a conjunction, which has its own mutants."""
        decides = field in ("test", "ifs") and isinstance(
            parent, (ast.If, ast.While, ast.IfExp, ast.comprehension)
        )
        if decides and not isinstance(node, (ast.Compare, ast.BoolOp, ast.UnaryOp, ast.Constant)):
            new = ast.copy_location(ast.UnaryOp(ast.Not(), node), node)
            before = ast.unparse(node)
            self.add(place, "condition", node, before, f"not {before}", (parent, field, at, new))

    def removal(self, node, body, place):
        """Removed: a call, a step, an assignment to a part, break, continue."""
        is_call = isinstance(node, ast.Expr) and isinstance(node.value, (ast.Call, ast.Await))
        is_part = isinstance(node, ast.Assign) and all(
            isinstance(target, (ast.Attribute, ast.Subscript)) for target in node.targets
        )
        if is_call or is_part or isinstance(node, (ast.AugAssign, ast.Break, ast.Continue)):
            holder = ast.Module(body, [])  # its list is the statement's own
            change = (holder, "body", body.index(node), ast.copy_location(ast.Pass(), node))
            self.add(place, "statement", node, ast.unparse(node), "", change)
        if isinstance(node, ast.AugAssign):
            self.operator(node, (node.value,), place)


def mentioned(node, context=(ast.Load, ast.Store, ast.Del)):
    """The names and attributes in a statement."""
    for one in ast.walk(node):
        if isinstance(one, (ast.Name, ast.Attribute)) and isinstance(one.ctx, context):
            yield one.id if isinstance(one, ast.Name) else one.attr


def is_plain(node):
    return isinstance(node, ast.keyword) and bool(PLAIN.fullmatch(node.arg or ""))


def is_text(node):
    return isinstance(node, ast.JoinedStr) or (
        isinstance(node, ast.Constant) and isinstance(node.value, (str, bytes))
    )
