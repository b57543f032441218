"""Every loop of the library ends: it is counted, by its text, or loops.txt gives the reason."""

import unittest
from collections import Counter
from pathlib import Path

from loops import Loop, all_loops, is_counted

ROWS = [
    tuple(line.split(" | "))
    for line in Path(__file__).with_name("loops.txt").read_text().splitlines()
    if line and not line.startswith("#")
]
KINDS = ("asserted", "bounded", "domain", "retry")


def written(head, body, whole=""):
    return Loop("a.c", 1, "f", head, body, (), whole)


class Loops(unittest.TestCase):
    def test_every_loop_is_counted_or_listed(self):
        loops = all_loops()
        self.assertGreater(len(loops), 250, "the loops were not recognised")
        found = Counter(loop[0:1] + loop[2:4] for loop in loops if not is_counted(loop))
        self.assertEqual(Counter(row[:3] for row in ROWS), found)
        kinds = Counter(row[3] for row in ROWS)
        self.assertLessEqual(set(kinds), set(KINDS))
        counts = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
        print(f"{len(loops)} loops: {len(loops) - len(ROWS)} counted, {counts}", flush=True)

    def test_an_asserted_loop_has_its_assertion(self):
        body = {loop[0:1] + loop[2:4]: " ".join(loop.body.split()) for loop in all_loops()}
        for *loop, kind, reason in ROWS:
            if kind == "asserted":
                self.assertRegex(reason, r"^DAVAR_ASSERT\(.*\);$")
                self.assertIn(reason, body[tuple(loop)])

    def test_faults_are_not_counted(self):
        up = "for (uint32_t i = 0U; i < count; i++)"
        self.assertTrue(is_counted(written(up, "{ a[i] = 0U; }")))
        for body in ("{ i--; }", "{ count++; }", "{ f(&i); }", "{ f(&count); }", "{ i = 0U; }"):
            self.assertFalse(is_counted(written(up, body)), body)
        for head in (
            "for (uint32_t i = 0U; i < count; i += n)",
            "for (uint32_t i = 0U; i < count;)",
            "for (uint32_t i = 9U; i >= 0U; i--)",
            "for (uint32_t i = 0U; i <= count; i++)",
            "for (uint32_t i = 0U; i != count; i++)",
            "for (uint32_t i = 0U; i < next(count); i++)",
            "while (i < count)",
        ):
            self.assertFalse(is_counted(written(head, "{ a[i] = 0U; }")), head)
        members = "for (uint32_t i = 0U; i < stage->count; i++)"
        self.assertTrue(is_counted(written(members, "{ a[i] = 0U; }")))
        for body in ("{ stage->count++; }", "{ law->judge(stage); }", "{ f(&stage->count); }"):
            self.assertFalse(is_counted(written(members, body)), body)
        self.assertTrue(is_counted(written("while (i < count)", "{ f(a[i]); i++; }")))
        self.assertFalse(
            is_counted(written("while (i < count)", "{ if (a[i]) { continue; } i++; }"))
        )


if __name__ == "__main__":
    unittest.main()
