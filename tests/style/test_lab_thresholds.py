"""The numbers that decide in davarlab are in thresholds.py: frozen, once, with unit and source."""

import ast
import re
import unittest
from collections import Counter
from pathlib import Path

LAB = Path(__file__).resolve().parents[2] / "tools/lab/davarlab"
TABLE = LAB / "thresholds.py"
DECIDING = ("inference", "candidates", "diagnosis")  # rooms whose numbers decide
SOURCE = re.compile(
    r"DESIGN \d|choice|measured|chi-square|normal distribution|null recordings|Vuong|true models"
)


def is_number(node):
    return (
        isinstance(node, ast.Constant)
        and isinstance(node.value, int | float)
        and not isinstance(node.value, bool)
    )


def numeric_constants(tree):
    """Upper-case names that a module gives a value with a number in it."""
    for node in tree.body:
        targets = (
            node.targets
            if isinstance(node, ast.Assign)
            else [node.target]
            if isinstance(node, ast.AnnAssign)
            else []
        )
        names = [
            name.id
            for target in targets
            for name in ast.walk(target)
            if isinstance(name, ast.Name) and name.id.isupper()
        ]
        if names and any(map(is_number, ast.walk(node.value))):
            yield from names


def fields():
    """(class, field, arguments of its of()) of the table."""
    for group in ast.parse(TABLE.read_text()).body:
        if isinstance(group, ast.ClassDef):
            for node in group.body:
                if isinstance(node, ast.AnnAssign):
                    yield group, node.target.id, node.value.args


class TestThresholds(unittest.TestCase):
    def test_the_deciding_rooms_have_no_numbers_of_their_own(self):
        found = [
            f"{path.relative_to(LAB)}: {name}"
            for room in DECIDING
            for path in sorted((LAB / room).glob("*.py"))
            for name in numeric_constants(ast.parse(path.read_text()))
        ]
        self.assertEqual(found, [], "belongs in thresholds.py")

    def test_a_number_in_a_tuple_or_a_mapping_is_found(self):
        found = numeric_constants(ast.parse("A, B = (1, 2)\nC = {'x': 0.5}\nD = 'text'\ne = 3\n"))
        self.assertEqual(list(found), ["A", "B", "C"])

    def test_every_group_is_frozen(self):
        groups = {group.name: group for group, _, _ in fields()}
        self.assertGreater(len(groups), 5)
        for name, group in groups.items():
            self.assertEqual(ast.unparse(group.decorator_list[0]), "dataclass(frozen=True)", name)

    def test_each_has_value_unit_source_and_meaning(self):
        for group, name, arguments in fields():
            self.assertEqual(len(arguments), 4, name)
            for text in arguments[1:]:
                self.assertTrue(ast.literal_eval(text).strip(), name)
            self.assertRegex(ast.literal_eval(arguments[2]), SOURCE, f"{group.name}.{name}")

    def test_a_name_and_a_meaning_stand_once(self):
        for what in (
            [name for _, name, _ in fields()],
            [ast.unparse(arguments[3]) for _, _, arguments in fields()],
        ):
            self.assertEqual([one for one, count in Counter(what).items() if count > 1], [])

    def test_each_is_used(self):
        text = "".join(
            path.read_text()
            for package in (LAB, LAB.with_name("davarfleet"))
            for path in package.rglob("*.py")
            if path != TABLE
        )
        unused = [
            f"{group.name.upper()}.{name}"
            for group, name, _ in fields()
            if not re.search(rf"\b{group.name.upper()}\.{name}\b", text)
        ]
        self.assertEqual(unused, [])


if __name__ == "__main__":
    unittest.main()
