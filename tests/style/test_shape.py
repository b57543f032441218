"""The shape of the library in figures: prints one table, and checks the figures with a goal. It
reads only the text of the tree; nothing is built.
"""

import re
import statistics
import unittest
from collections import Counter

from test_style import bare, c_files, functions, includes, listed, resolve, text_of

DEPTH_MAX = 6
FOLLOWED_MAX = 5
COMPLEXITY_MAX = 10
# An int16 from davar_push_q15 to the sum of its squared differences: each file, and the function
# that the previous file calls there.
FOLLOWED = (
    ("lib/src/pipeline/q15.c", "davar_push_q15"),
    ("lib/src/pipeline/push.inc", "pipeline_push_all"),
    ("lib/src/pipeline/slide.inc", "sliding_glide"),
    ("lib/src/pipeline/type_q15.inc", "sum_slide"),
)


def depth(name, below, way=()):
    """Number of files in the longest chain of includes that begins with this one."""
    assert name not in way, f"{name} includes itself"
    if name not in below:
        own = [
            target for target in (resolve(name, included) for included in includes(name)) if target
        ]
        below[name] = 1 + max((depth(target, below, (*way, name)) for target in own), default=0)
    return below[name]


def complexities_of(text):
    """Yields (name, cyclomatic complexity) of every function; assertions do not count."""
    code = bare(text).splitlines()
    for line, name, lines in functions(text):
        kept = [part for part in code[line - 1 : line + lines - 2] if part.lstrip()[:1] != "#"]
        body = re.sub(r"DAVAR_ASSERT\([^;]*;", "", "\n".join(kept))
        yield name, 1 + len(re.findall(r"\b(?:if|for|while|case)\b|&&|\|\||\?", body))


def complexities(name):
    return complexities_of(text_of(name))


def comment_share(names):
    """Percent of the lines that are comment only."""
    lines = comments = 0
    for name in names:
        inside = False
        for line in text_of(name).splitlines():
            text = line.strip()
            lines += 1
            comments += inside or text.startswith("/*")
            inside = (inside or text.startswith("/*")) and "*/" not in text
    return 100 * comments / lines


def called_once(names):
    """(static functions with one call, all static functions)."""
    text = "\n".join(bare(text_of(name)) for name in names)
    static = {
        match
        for name in names
        for match in re.findall(
            r"^[^\n;]*\bstatic\b[^;{}()]*?\b(\w+)\((?=[^;]*?\{)", bare(text_of(name)), re.MULTILINE
        )
    }
    uses = Counter(re.findall(r"\b\w+\b", text))
    return sum(uses[name] == 2 for name in static), len(static)  # its definition and one use


class Shape(unittest.TestCase):
    def setUp(self):
        self.files = c_files("lib/")
        self.below = {}

    def test_the_table(self):
        lengths = sorted(lines for name in self.files for _, _, lines in functions(text_of(name)))
        deepest = max(self.files, key=lambda name: depth(name, self.below))
        once, static = called_once(self.files)
        public = [name for name in self.files if name.startswith("lib/include/")]
        private = [name for name in self.files if name not in public and name.endswith(".h")]
        rest = [name for name in self.files if not name.endswith(".h")]
        rooms = {}
        for name in self.files:
            room = "include" if name in public else name.split("/")[2]
            rooms[room] = rooms.get(room, 0) + len(text_of(name).splitlines())
        example = re.search(r"^```c\n(.*?)^```", text_of("README.md"), re.DOTALL | re.MULTILINE)[1]
        tracked = listed()
        rows = {
            "lines / files of lib/": f"{sum(rooms.values())} / {len(self.files)}",
            "lines by room": ", ".join(f"{room} {lines}" for room, lines in rooms.items()),
            "function median / 95 % / longest": (
                f"{statistics.median(lengths):g} / "
                f"{lengths[len(lengths) * 95 // 100]} / {lengths[-1]}"
            ),
            "static functions with one caller": f"{100 * once / static:.0f} % of {static}",
            "comment lines %, public .h / private .h / .c and .inc": " / ".join(
                f"{comment_share(names):.0f}" for names in (public, private, rest)
            ),
            "longest chain of includes": f"{depth(deepest, self.below)} files ({deepest})",
            "files to follow one sample": (
                f"{len(FOLLOWED)} ({' > '.join(name.split('/')[-1] for name, _ in FOLLOWED)})"
            ),
            "lines of the first example": str(len(example.splitlines())),
            "tracked files / of these fuzz inputs": (
                f"{len(tracked)} / {sum(name.startswith('tests/fuzz/corpus/') for name in tracked)}"
            ),
        }
        print("\n" + "\n".join(f"{name:<56} {value}" for name, value in rows.items()), flush=True)
        self.assertGreater(len(lengths), 500, "the functions were not recognised")

    def test_no_chain_of_includes_is_long(self):
        self.assertEqual([], [name for name in self.files if depth(name, self.below) > DEPTH_MAX])

    def test_no_function_has_many_branches(self):
        many = [
            f"{name}: {function} {branches}"
            for name in self.files
            for function, branches in complexities(name)
            if branches > COMPLEXITY_MAX
        ]
        self.assertEqual([], many)

    def test_every_branch_counts(self):
        text = "int f(int a)\n{\n    while (a && !(a > 3 || a < 1)) {\n"
        text += "        a = a ? 1 : 0; /* if */\n    }\n    return a;\n}\n"
        self.assertEqual([("f", 5)], list(complexities_of(text)))

    def test_a_sample_is_followed_through_few_files(self):
        self.assertLessEqual(len(FOLLOWED), FOLLOWED_MAX)
        for name, function in FOLLOWED:
            self.assertIn(function, [found for _, found, _ in functions(text_of(name))], name)
        for (name, _), (_, called) in zip(FOLLOWED, FOLLOWED[1:], strict=False):
            self.assertRegex(
                bare(text_of(name)), rf"\b{called}\(", f"{name} does not call {called}"
            )


if __name__ == "__main__":
    unittest.main()
