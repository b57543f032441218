"""Every mutant of C sources in one build: each place with mutants tests which mutant is active.

`a + b` becomes `(DAVAR_SITE(7, 1) ? a - b : a + b)`. Only one mutant is active at a time, so the
mutated branch contains the original text and the text grows little. libclang finds the places. Code
that the preprocessor or a constant expression decides (array sizes, case labels, static_assert,
bodies of macros, instructions of other machines) has no mutants.
"""

import re
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

from clang.cindex import CursorKind as Kind
from clang.cindex import Index, StorageClass, TypeKind
from mutant import CLASSES, RELATIONS, SWAPS, Mutant, number, one_line

SUFFIXES = (".c", ".h", ".inc")  # of the files that contain code

# Macros whose use is a constant of the library. Options of the build (davar/options.h) are not
# constants of this kind.
STANDARD = set(
    re.findall(
        r"\w+",
        "UINT8_MAX UINT16_MAX UINT32_MAX UINT64_MAX INT16_MAX INT16_MIN INT32_MAX INT32_MIN "
        "INT64_MAX INT64_MIN SIZE_MAX UINT32_C UINT64_C INT32_C INT64_C DBL_MAX FLT_MAX CHAR_BIT "
        "true false",
    )
)
CHOICES = re.compile(r"DAVAR_(TAUS_MAX|Q15|Q31|GRID|LAWS|CENTRED|MANY_REGISTERS|VERSION_\w+)$")
KINDS = "COMPOUND IF FOR WHILE DO CASE DEFAULT"
STATEMENTS = {getattr(Kind, f"{name}_STMT") for name in KINDS.split()}
WIDTHS = (
    "BOOL CHAR_S SCHAR UCHAR SHORT USHORT INT UINT LONG ULONG LONGLONG ULONGLONG INT128 UINT128"
)
INTEGERS = {getattr(TypeKind, name) for name in WIDTHS.split()}
FLOATS = {TypeKind.FLOAT, TypeKind.DOUBLE}


@dataclass
class Site:
    """A section of the text with mutants; each is a pair (Mutant, replacement)."""

    start: int
    end: int
    mutants: list = field(default_factory=list)
    is_void: bool = False
    table: tuple = ()  # of an element of a file's table: (start, end) of the declaration, its name


def flat(text):
    """One line, without comments."""
    return one_line(re.sub(r"/\*.*?\*/|//[^\n]*", " ", text, flags=re.DOTALL))


class File:
    def __init__(self, root, name):
        self.name, self.text = name, (root / name).read_text()
        self.raw = self.text.encode()
        assert len(self.raw) == len(self.text), f"{name}: not ASCII"  # libclang counts bytes
        self.sites = {}

    def add(self, span, function, kind, after, is_void=False, before=None, table=()):
        start, end = span
        site = self.sites.setdefault((start, end), Site(start, end, [], is_void, table))
        before = before or flat(self.text[start:end])
        line = self.text.count("\n", 0, start)
        mutant = Mutant(
            self.name,
            function,
            line + 1,
            kind,
            before,
            flat(after),
            flat(self.text.splitlines()[line]),
        )
        if all(other.after != mutant.after for other, _ in site.mutants):
            site.mutants.append((mutant, after))


class Finder:
    """Walks one translation unit; adds its sites in these files, each once."""

    def __init__(self, root, files, macros):
        self.root, self.files, self.macros = root, files, macros

    def span(self, cursor):
        return cursor.extent.start.offset, cursor.extent.end.offset

    def text(self, cursor):
        start, end = self.span(cursor)
        return self.file.text[start:end]

    def unit(self, unit):
        for cursor in unit.cursor.get_children():
            source = cursor.location.file
            name = str(Path(source.name).resolve()) if source else ""
            self.file = self.files.get(name)
            if not self.file:
                continue
            if cursor.kind == Kind.FUNCTION_DECL and cursor.is_definition():
                self.function = cursor.spelling
                body = [
                    child for child in cursor.get_children() if child.kind == Kind.COMPOUND_STMT
                ]
                if body and self.text(body[0]).startswith("{"):
                    self.visit(body[0], cursor)
            elif cursor.kind == Kind.VAR_DECL:
                self.table(cursor)

    def table(self, cursor):
        """The numbers of a table next to the functions, or of a static one in a function, which may
        as well be created at each call.
        """
        start, end = self.span(cursor)
        text = self.file.text[start:end]
        if "{" not in text or not text.startswith("static const "):
            return
        self.function = cursor.spelling
        for child in cursor.get_children():
            if child.kind == Kind.INIT_LIST_EXPR:
                for leaf in child.walk_preorder():
                    if leaf.kind in (Kind.INTEGER_LITERAL, Kind.FLOATING_LITERAL):
                        self.constant(leaf, (start, end, cursor.spelling))

    def visit(self, cursor, parent, place=0):
        kind = cursor.kind
        if kind in (
            Kind.CXX_UNARY_EXPR,
            Kind.STATIC_ASSERT,
            Kind.ASM_STMT,
        ):  # sizeof; the compiler decides it
            return
        if kind == Kind.VAR_DECL and cursor.storage_class == StorageClass.STATIC:
            return self.lasting(cursor)
        if self.macro_constant(cursor):
            return None
        self.mutate(cursor, parent, place)
        children = list(cursor.get_children())
        if kind == Kind.CASE_STMT:
            children = children[1:]
        if kind == Kind.VAR_DECL and cursor.type.kind == TypeKind.CONSTANTARRAY:
            children = [child for child in children if child.kind == Kind.INIT_LIST_EXPR]
        for at, child in enumerate(children):
            self.visit(child, cursor, at)
        return None

    def lasting(self, cursor):
        """static const in a function: an array of numbers is created at each call (see
        Text.render).
        """
        if cursor.type.kind != TypeKind.CONSTANTARRAY or not self.text(cursor).startswith(
            "static const "
        ):
            return
        self.file.lasting.add(self.span(cursor)[0])
        for leaf in cursor.walk_preorder():
            if leaf.kind == Kind.INIT_LIST_EXPR:
                for number in leaf.get_children():
                    if number.kind in (Kind.INTEGER_LITERAL, Kind.FLOATING_LITERAL):
                        self.constant(number)
                    elif number.kind in (Kind.UNARY_OPERATOR, Kind.UNEXPOSED_EXPR):
                        for part in number.walk_preorder():
                            if part.kind in (Kind.INTEGER_LITERAL, Kind.FLOATING_LITERAL):
                                self.constant(part)

    def macro_constant(self, cursor):
        """A named constant where it is used. True: there are no other sites here."""
        if not cursor.kind.is_expression() and cursor.kind != Kind.NULL_STMT:
            return False
        text = self.text(cursor)
        if re.match(r"(DAVAR_ASSERT|assert|static_assert|_Static_assert)\b", text):
            return True
        named = re.fullmatch(r"(\w+)(\([^()]*\))?", text)
        if not named or named.group(1) not in self.macros:
            return False
        if cursor.type.get_canonical().kind in INTEGERS | FLOATS:
            self.constant(cursor)
        return True

    def constant(self, cursor, table=()):
        span, text, kind = self.span(cursor), self.text(cursor), cursor.type.get_canonical().kind
        number = re.fullmatch(r"(\w+)(\([^()]*\))?", text)
        named = number and number.group(1) in (self.macros if not number.group(2) else STANDARD)
        if CHOICES.match(text) or not (text[:1].isdigit() or named):
            return

        def add(after):
            self.file.add(span, self.function, "constant", after, table=table)

        if text in ("true", "false"):
            add("false" if text == "true" else "true")
        elif kind in FLOATS:
            f = "F" if kind == TypeKind.FLOAT else ""
            add(f"({text} + 1.0{f})")
            if not re.fullmatch(r"0(\.0*)?F?", text):
                add(f"({text} * 1.01{f})")
        elif kind in INTEGERS:
            add(f"({text} + 1)")
            if not re.fullmatch(r"0[xX]?0*[uUlL]*", text):
                add(f"({text} - 1)")

    def mutate(self, cursor, parent, place):
        kind, span, children = cursor.kind, self.span(cursor), list(cursor.get_children())
        parts = [self.span(child) for child in children]
        source = self.file.text
        if kind in (Kind.INTEGER_LITERAL, Kind.FLOATING_LITERAL):
            if not (parent.kind == Kind.UNEXPOSED_EXPR and parent.type.kind == TypeKind.POINTER):
                self.constant(cursor)
        elif kind in (Kind.BINARY_OPERATOR, Kind.COMPOUND_ASSIGNMENT_OPERATOR) and len(parts) == 2:
            self.binary(cursor, span, children, parts)
        elif kind == Kind.UNARY_OPERATOR and len(parts) == 1:
            self.unary(span, parts[0])
        self.condition(cursor, children)
        if parent.kind in STATEMENTS:
            self.statement(cursor, parent, place)
        jumps = kind in (Kind.BREAK_STMT, Kind.CONTINUE_STMT)
        if jumps and source[slice(*span)] in ("break", "continue"):
            self.file.add(span, self.function, "statement", "", is_void=True)

    def binary(self, cursor, span, children, parts):
        (start, left), (right, end) = parts
        if not (span[0] == start < left <= right < end == span[1]):
            return
        a, b = self.file.text[start:left], self.file.text[right:end]
        op = flat(self.file.text[left:right])
        is_assignment = cursor.kind == Kind.COMPOUND_ASSIGNMENT_OPERATOR
        plain = op[:-1] if is_assignment else op
        pointers = [
            child.type.get_canonical().kind in (TypeKind.POINTER, TypeKind.CONSTANTARRAY)
            for child in children
        ]
        if plain in RELATIONS:
            for other in RELATIONS[plain]:
                self.operator(span, "relational", op, other, a, b)
        elif plain in SWAPS and not (all(pointers) and plain in "+-"):
            other = SWAPS[plain]
            floats = [child.type.get_canonical().kind in FLOATS for child in children]
            if any(floats) and plain in ("%", "<<", ">>", "&", "|", "^"):
                return
            self.operator(span, CLASSES[plain], op, other + ("=" if is_assignment else ""), a, b)

    def operator(self, span, kind, op, other, a, b):
        after = f"{flat(a)} {other} {flat(b)}"
        self.file.add(span, self.function, kind, after, is_void=False)

    def unary(self, span, part):
        text = self.file.text
        before, after = text[span[0] : part[0]].strip(), text[part[1] : span[1]].strip()
        operand = flat(text[slice(*part)])
        if before in ("!", "-", "~") and not after:
            if before == "!" or before == "~":
                self.file.add(
                    span,
                    self.function,
                    "logical" if before == "!" else "bitwise",
                    f"{'!!' if before == '!' else ''}{operand}",
                )
            else:
                self.file.add(span, self.function, "arithmetic", f"{operand}")
        elif {before, after} == {"", "++"} or {before, after} == {"", "--"}:
            swapped = {"++": "--", "--": "++", "": ""}
            self.file.add(
                span, self.function, "arithmetic", f"{swapped[before]}{operand}{swapped[after]}"
            )

    def condition(self, cursor, children):
        """Negated, unless it is a comparison or a conjunction, which has its own mutants."""
        if cursor.kind in (Kind.IF_STMT, Kind.WHILE_STMT, Kind.CONDITIONAL_OPERATOR) and children:
            condition = children[0]
        elif cursor.kind == Kind.DO_STMT and len(children) == 2:
            condition = children[1]
        else:
            return
        span = self.span(condition)
        text = self.file.text[slice(*span)]
        if not text or re.match(r"\w+$", text) and text in self.macros:
            return
        inner = condition
        while (
            inner.kind in (Kind.UNEXPOSED_EXPR, Kind.PAREN_EXPR)
            and len(list(inner.get_children())) == 1
        ):
            inner = next(inner.get_children())
        if inner.kind in (Kind.BINARY_OPERATOR, Kind.UNARY_OPERATOR):
            return
        outer = self.span(cursor)
        if outer[0] <= span[0] < span[1] <= outer[1] and span != outer:
            self.file.add(span, self.function, "condition", f"!({flat(text)})")

    def statement(self, cursor, parent, place):
        """Deleted: a call, an assignment, a step."""
        while cursor.kind == Kind.UNEXPOSED_EXPR and len(list(cursor.get_children())) == 1:
            cursor = next(cursor.get_children())
        span = self.span(cursor)
        text = self.file.text[slice(*span)]
        siblings = list(parent.get_children())
        if (
            parent.kind == Kind.IF_STMT
            and place == 0
            or parent.kind == Kind.WHILE_STMT
            and place == 0
            or parent.kind == Kind.DO_STMT
            and place == 1
            or parent.kind == Kind.FOR_STMT
            and place != len(siblings) - 1
            or parent.kind == Kind.CASE_STMT
            and place == 0
        ):
            return
        is_step = cursor.kind == Kind.UNARY_OPERATOR and re.search(r"\+\+|--", text)
        is_assignment = cursor.kind == Kind.COMPOUND_ASSIGNMENT_OPERATOR or (
            cursor.kind == Kind.BINARY_OPERATOR and "=" in text
        )
        is_call = cursor.kind == Kind.CALL_EXPR and "(" in text
        if (
            (is_step or is_assignment or is_call)
            and not re.match(r"(static_)?assert\b|DAVAR_ASSERT|\(void\)", text)
            and re.match(r"\s*;", self.file.text[span[1] :])
        ):
            site = self.file.sites.get(span)
            if site:
                site.is_void = True
            self.file.add(span, self.function, "statement", "", is_void=True)


def find(root, folders, compiler_flags):
    """{path: File} of these folders, with the sites of every mutant that a compiler may accept."""
    names = sorted(
        path for folder in folders for path in (root / folder).rglob("*") if path.suffix in SUFFIXES
    )
    files = {}
    macros = set(STANDARD)
    for path in names:
        file = File(root, str(path.relative_to(root)))
        file.lasting = set()
        files[str(path.resolve())] = file
        macros.update(
            re.findall(r"^[ \t]*#[ \t]*define[ \t]+([A-Z]\w*)(?![\w(])", file.text, re.MULTILINE)
        )
    finder = Finder(root, files, macros)
    index = Index.create()
    for path in names:
        if path.suffix == ".c":
            unit = index.parse(str(path), args=compiler_flags)
            errors = [str(note) for note in unit.diagnostics if note.severity >= 3]
            if errors:
                raise RuntimeError(f"{path}: {errors[0]}")
            finder.unit(unit)
    return {file.name: file for file in files.values()}


def numbered(files, without=()):
    """Numbers the mutants from 1 and returns them; `without`: sites {(file, start, end)} that no
    compiler accepts.
    """
    mutants = []
    for name, file in sorted(files.items()):
        wanted = [file.sites[span] for span in sorted(file.sites) if (name, *span) not in without]
        places = [[mutant for mutant, _ in site.mutants] for site in wanted if site.mutants]
        mutants += number(places, 1 + len(mutants))
    return mutants


def render(file, without=()):
    """The file's text with all its mutants."""
    sites = [
        site
        for span, site in file.sites.items()
        if (file.name, *span) not in without and site.mutants
    ]
    plain = sorted(
        (site for site in sites if not site.table), key=lambda site: (site.start, -site.end)
    )
    tables = {}
    for site in sites:
        if site.table:
            tables.setdefault(site.table, []).append(site)

    def stretch(start, end, inside):
        out, at, rest = [], start, list(inside)
        while rest:
            site = rest.pop(0)
            below = []
            while rest and rest[0].start < site.end:
                below.append(rest.pop(0))
            out += [copied(at, site.start), wrapped(site, stretch(site.start, site.end, below))]
            at = site.end
        return "".join([*out, copied(at, end)])

    def copied(start, end):
        text = file.text[start:end]
        changed = [(at, "const") for at in file.lasting if start <= at < end]
        changed += [(at, "static") for at, last, _ in tables if start <= at and last < end]
        for at, kept in sorted(changed, reverse=True):
            before, after = text[: at - start], text[at - start :]
            text = before + after.replace("static const", kept, 1)
        return text

    text = stretch(0, len(file.text), plain)
    if not tables:
        return text
    # Code that writes a table's mutant over it before main(), after the last line of code.
    extra = []
    for (first, last, name), entries in sorted(tables.items()):
        for site in entries:
            for mutant, after in site.mutants:
                other = file.text[first : site.start] + after + file.text[site.end : last]
                other = re.sub(rf"\b{name}\b", f"{name}_mutant", flat(other), count=1)
                extra.append(
                    "__attribute__((constructor(102))) static void "
                    f"davar_table_{mutant.id}(void) {{ {other}; "
                    f"if (DAVAR_SITE({site.mutants[0][0].id}U, {len(site.mutants)}U) && "
                    f"davar_mutant == {mutant.id}U) "
                    f"__builtin_memcpy((void *)&{name}, &{name}_mutant, sizeof {name}); }}\n"
                )
    close = text.rstrip().rfind("#endif") if text.rstrip().endswith("#endif") else len(text)
    return text[:close] + "".join(extra) + text[close:]


def wrapped(site, text):
    first, count = site.mutants[0][0].id, len(site.mutants)
    asked = f"DAVAR_SITE({first}U, {count}U)"
    if text in ("break", "continue"):
        return f"if (!{asked}) {text}"
    choices = f"({'(void)' if site.is_void else ''}({text}))"
    inner = ""
    for mutant, after in site.mutants:
        value = "(void)0" if not after else f"{'(void)' if site.is_void else ''}({after})"
        inner = value if not inner else f"(davar_mutant == {mutant.id}U ? {value} : {inner})"
    return f"({asked} ? {inner} : {choices})"


def compiler_flags(root):
    """The paths of the sources' headers, and of the compiler's own, which libclang needs."""
    builtin = subprocess.run(
        ["gcc", "-print-file-name=include"], check=True, text=True, stdout=subprocess.PIPE
    ).stdout.strip()
    folders = ["lib/include", "lib/src", "host_sim", "gateway"]
    places = [*(root / "port").iterdir(), *root.glob("addons/*/*")]
    folders += sorted(str(path.relative_to(root)) for path in places)
    return [
        *("-std=c11", "-DNDEBUG", "-D_GNU_SOURCE", "-isystem", builtin),
        *(f"-I{root / folder}" for folder in folders),
    ]
