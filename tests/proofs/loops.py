"""Finds the loops of the library that are counted, by their text: such a loop ends for any input.
Reads every branch of the preprocessor. Standard library only.

A loop is counted if it is a `for` whose variable moves by one towards a bound (or is halved down to
0), and neither the variable nor the bound is written in its body. Where the bound is a member, no
function that the body can reach writes a member of that name.

Manual use: loops.py prints every loop of the library and the way in which it ends.
"""

import re
import sys
from collections import namedtuple
from functools import cache
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests/style"))
from c_text import bare, c_files, text_of

Loop = namedtuple("Loop", "file line function head body outer whole")
WRITES = r"\s*(?:(?:[-+*/%&|^]|<<|>>)?=(?!=)|\+\+|--)"


def closing(text, at):
    """Index after the bracket that closes the one at `at`."""
    depth = 0
    for bracket in re.finditer(r"[(){}]", text[at:]):
        depth += 1 if bracket.group() in "({" else -1
        if depth == 0:
            return at + bracket.end()
    raise ValueError("a bracket is not closed")


@cache
def definitions(name):
    """[(function, start, end)] of a file; `start` is where its parameters begin."""
    text = bare(text_of(name))
    found, end = [], 0
    for head in re.finditer(r"^(?!typedef|static const)\w[^;{}=]*?\)\s*\{", text, re.MULTILINE):
        if head.start() < end:
            continue
        end = closing(text, head.end() - 1)
        function = re.search(r"NUMBER\((\w+)\)|(\w+)\s*\(", head.group())
        found.append((function[1] or function[2], head.start(), end))
    return found


def loops_of(name):
    """The loops of a file, outer ones first."""
    text = bare(text_of(name))
    for function, start, end in definitions(name):
        whole, inside = text[start:end], []
        for word in re.finditer(r"\b(for|while|do)\b", whole):
            at = word.end()
            if word[1] != "do":
                at = closing(whole, whole.index("(", at))
            if whole[at:].lstrip().startswith(";"):
                continue  # the end of a `do`
            body_end = closing(whole, whole.index("{", at))
            if word[1] == "do":
                condition = closing(whole, whole.index("(", body_end))
                head = "do " + whole[body_end:condition]
            else:
                head = whole[word.start() : at]
            inside = [outer for outer in inside if outer[0] > word.start()]
            yield Loop(
                name,
                text.count("\n", 0, start + word.start()) + 1,
                function,
                " ".join(head.split()),
                whole[at:body_end],
                tuple(outer[1] for outer in inside),
                whole,
            )
            inside.append((body_end, " ".join(head.split())))


@cache
def sources():
    return tuple(c_files("lib/src/", "lib/include/", "addons/"))


@cache
def bodies():
    """{function: the text of all its definitions}."""
    found = {}
    for name in sources():
        for function, start, end in definitions(name):
            found[function] = found.get(function, "") + bare(text_of(name))[start:end]
    return found


def reached(text):
    """The text and that of every function it can reach; None if it calls through a pointer."""
    seen, waiting, all_text = set(), [text], []
    while waiting:
        part = waiting.pop()
        if re.search(r"(?:->|\.)\w+\(", part):
            return None
        all_text.append(part)
        for called in set(re.findall(r"\b(\w+)\)?\(", part)) - seen:
            seen.add(called)
            waiting += [bodies()[called]] if called in bodies() else []
    return "\n".join(all_text)


def is_written(name, text):
    return bool(
        re.search(rf"(?<![\w.>]){name}\b{WRITES}|(?:\+\+|--){name}\b", text)
        or re.search(rf"(?<!&)(?<![\w)] )&{name}\b(?!\s*[\[.]|->)", text)
    )


def is_stable(bound, body):
    """The bound has the same value at each turn of the loop."""
    if re.search(r"\w\(|\[|[^-]>|\*\w", bound):
        return False
    for root in re.findall(r"(?<![\w.>])[a-z_]\w*", bound):
        if is_written(root, body):
            return False
    members = set(re.findall(r"(?:->|\.)(\w+)", bound))
    if not members:
        return True
    text = reached(body)
    return text is not None and not any(
        re.search(
            rf"(?:->|\.){member}\b{WRITES}|&[\w>.\[\]-]*(?:->|\.){member}\b(?!\s*[\[.]|->)", text
        )
        for member in members
    )


def conjuncts(condition):
    parts = [part.strip() for part in condition.split("&&")]
    return [re.sub(r"^\((.*)\)$", r"\1", part) for part in parts]


def moves(loop, variable, sign, bound, step):
    """The variable moves one way, and the bound stands."""
    if is_written(variable, loop.body):
        return False
    if sign in ("<", "<="):
        rises = re.search(rf"\b{variable}\+\+", step)
        ends = (
            sign == "<" or re.fullmatch(r"\d+U?|[A-Z]\w*", bound) or is_counted_outside(loop, bound)
        )
        return bool(rises and ends and is_stable(bound, loop.body))
    if sign in (">", ">="):
        falls = re.search(rf"\b{variable}(?:--| >>= 1U)", step)
        return bool(
            falls
            and re.fullmatch(r"[01]U?", bound)
            and (sign == ">" or bound == "1" or "int " + variable in loop.head)
        )
    first = re.search(rf"\b{variable} = ([^;,]+);", loop.head)
    start = re.escape(first[1]) if first else variable
    started = rf"\bconst {bound} = (?:{variable}|{start}) \+ [^;]+;"
    others = re.sub(rf"\b{variable}\+\+", "", loop.whole.replace(step, ""))
    return bool(
        re.search(started, loop.whole)
        and re.search(rf"\b{variable}\+\+", step)
        and not is_written(bound, loop.body)
        and not re.search(rf"\b{variable}(?:\+=|-=|--)", others)
    )


def is_counted_outside(loop, bound):
    return any(re.search(rf"\b{bound} < .*; {bound}\+\+", head) for head in loop.outer)


def is_counted(loop):
    loop = as_for(loop)
    head = re.fullmatch(r"for \((.*?); ?(.*); ?(.*)\)", loop.head)
    if not head:
        return False
    for condition in conjuncts(head[2]):
        tested = re.fullmatch(r"(\w+) (<|<=|>|>=|!=) (.+)", condition)
        if tested and moves(loop, *tested.groups(), head[3]):
            return True
    return False


def as_for(loop):
    """A `while` whose body ends with `x++;` and has no `continue`, as the `for` that it is."""
    head = re.fullmatch(r"while \((.*)\)", loop.head)
    last = re.search(r"(\w+)\+\+;\s*\}\Z", loop.body)
    if not head or not last or "continue" in loop.body:
        return loop
    return loop._replace(
        head=f"for (; {head[1]}; {last[1]}++)", body=loop.body[: last.start()] + "}"
    )


def all_loops():
    return [loop for name in sources() for loop in loops_of(name)]


def main():
    for loop in all_loops():
        print(
            "counted" if is_counted(loop) else "-------",
            f"{loop.file}:{loop.line}: {loop.function}: {loop.head}",
        )


if __name__ == "__main__":
    main()
