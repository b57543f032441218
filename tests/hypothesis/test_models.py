"""Models, scenarios, limits and kalibr files: accepted values are those that tomllib or yaml reads.
A rejected value is reported with its key. Written and read again, a model is the same.
"""

import math
import tomllib
import unittest
from profile import examples

import asked
from damage import damaged
from davarfleet import limits
from davarlab import kalibr
from davarlab import model as models
from davarlab.effects import table
from davarlab.errors import BadInput
from davarlab.report import parameters
from hypothesis import assume, example, given
from hypothesis import strategies as st

KINDS = sorted(table.TABLE)
BASE = (
    '[sensor]\nrate_hz = 50.0\ncolumn = "gyro_z_dps"\n[[effect]]\nkind = "angle_random_walk"\n'
    "coefficient_deg_per_sqrt_h = 0.3\n"
)
FULL = BASE + (
    '[[effect]]\nkind = "sinusoid"\nfrequency_hz = 0.7\namplitude_dps = 0.02\n[[effect]]\n'
    'kind = "temperature"\ncoefficient_dps_per_degC = 0.02\n[[effect]]\nkind = "low_pass"\n'
    "cutoff_hz = 9.0\norder = 2\n"
)
SCENARIO = FULL + "[simulate]\nduration_s = 30.0\nseed = 3\n"
LIMITS = (
    "at_limit = 0.02\nadequate = true\n[[limit]]\n"
    'coefficient = "angle_random_walk.coefficient_deg_per_sqrt_h"\nmin = 0.1\nmax = 0.4\n'
)
KALIBR = (
    "imu0:\n  gyroscope_noise_density: 1.5e-4\n  gyroscope_random_walk: 2.0e-06\n  rate_hz: 200\n"
)
COMMANDS = [
    ("export",),
    ("add", "warm_up"),
    *(("export", "--to", form) for form in (*sorted(parameters.FORMATS), "plan")),
]
SCALAR = st.one_of(
    st.floats(),
    st.integers(-(2**70), 2**70),
    st.booleans(),
    st.text(max_size=6),
    st.none(),
    st.just(10**400),
    st.just([]),
    st.just({}),
    st.sampled_from((5e-324, 1.7976931348623157e308, -0.0, 1e100, "x", "y", "bilinear")),
)
COLUMNS = st.one_of(
    st.sampled_from(("gyro_z_dps", "gyro_x_rad_s", "accel_x_mps2")),
    st.text(
        st.characters(blacklist_categories=("Cs",), blacklist_characters=",\n\r"),
        min_size=1,
        max_size=8,
    ),
)
COURSES = st.lists(st.floats(1e-3, 1e4), min_size=4, max_size=9).map(
    lambda knots: " ".join(map(repr, knots))
)


def toml_of(value):
    """A value as TOML, if TOML supports it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and not math.isfinite(value):
        return "nan" if value != value else "inf" if value > 0 else "-inf"
    if isinstance(value, str):
        return '"' + "".join(f"\\U{ord(one):08x}" for one in value) + '"'
    if isinstance(value, dict):
        return (
            "{"
            + ", ".join(
                f"{toml_of(key)} = {toml_of(one)}" for key, one in value.items() if one is not None
            )
            + "}"
        )
    if isinstance(value, list):
        return "[" + ", ".join(toml_of(one) for one in value if one is not None) + "]"
    return repr(value)


def text_of(data):
    """Tables of a model file: sensor, simulate, and effect, a list."""
    return "".join(
        f"{name} = {toml_of(value)}\n" for name, value in data.items() if value is not None
    )


@st.composite
def values(draw, parameter):
    if parameter.values:
        return draw(st.sampled_from(parameter.values))
    if parameter.text:
        return draw(COURSES if parameter.name == "course_hz" else COLUMNS)
    low, high = max(parameter.low, -1e99), min(parameter.high, 1e99)
    if parameter.whole:
        return float(draw(st.integers(math.ceil(low), math.floor(min(high, 1e15)))))
    return draw(st.floats(low, high))


def highest_hz(term):
    """The highest frequency of a line; 0 for other effects."""
    course = term.parameters.get("course_hz", "0").split()
    return max(term.parameters.get("frequency_hz", 0), *map(float, course), 0)


@st.composite
def terms(draw):
    """A term within the bounds of the table."""
    effect = table.find(draw(st.sampled_from(KINDS)))
    found = {
        p.name: draw(values(p))
        for p in effect.parameters
        if p.default is None or draw(st.booleans())
    }
    if "start_s" in found:
        found["start_s"], found["stop_s"] = sorted((found["start_s"], found["stop_s"]))
    return models.Term(effect.kind, found)


@st.composite
def entries(draw):
    """A user's description of an effect: most of it is correct."""
    term = draw(terms())
    entry = {"kind": term.kind, **term.parameters}
    for _ in range(draw(st.integers(0, 2))):
        entry[draw(st.sampled_from(["kind", *term.parameters, "other"]))] = draw(SCALAR)
    return entry


TABLES = st.fixed_dictionaries(
    {
        "sensor": st.one_of(
            st.fixed_dictionaries(
                {"column": st.one_of(COLUMNS, SCALAR)},
                optional={"rate_hz": st.one_of(st.floats(1, 1e6), SCALAR)},
            ),
            SCALAR,
        )
    },
    optional={
        "effect": st.one_of(st.lists(entries(), max_size=3), SCALAR),
        "simulate": SCALAR,
        "odd": SCALAR,
    },
)


class Models(asked.Lawful):
    @given(st.floats(1e-3, 1e6) | st.none(), COLUMNS, st.lists(terms(), max_size=4))
    @examples(150)
    def test_written_files_are_read(self, rate_hz, column, made):
        assume(not any(term.parameters.get("column") == column for term in made))
        assume(not rate_hz or not any(highest_hz(term) > rate_hz / 2 for term in made))
        wanted, path = models.Model(rate_hz, column, made), self.work / "m.toml"
        models.write(wanted, path)
        self.assertEqual(models.read(path), wanted)
        with open(path, "rb") as file:
            plain = tomllib.load(file)
        self.assertEqual(
            plain["sensor"], {"column": column} | ({"rate_hz": rate_hz} if rate_hz else {})
        )
        self.assertEqual(len(plain.get("effect", [])), len(made))

    @given(TABLES)
    @examples(300)
    def test_values_equal_those_of_tomllib(self, data):
        path = self.file("m.toml", text_of(data))
        try:
            found = models.read(path)
        except BadInput as why:
            self.assertIn("m.toml", str(why))
            return
        with open(path, "rb") as file:
            plain = tomllib.load(file)
        self.assertEqual(
            (found.column, found.rate_hz),
            (plain["sensor"]["column"], plain["sensor"].get("rate_hz")),
        )
        for term, entry in zip(found.terms, plain.get("effect", []), strict=True):
            said = {"kind": models.kind_said(term.kind, found.column)}
            for parameter in table.find(term.kind).parameters:
                if parameter.name in term.parameters:
                    one, _ = models.as_said(term.kind, parameter, found.column)
                    said[one.name] = term.parameters[parameter.name]
            self.assertEqual(said, entry)

    @given(
        st.one_of(
            TABLES.map(text_of),
            damaged(FULL.encode()),
            st.binary(max_size=80),
            st.text(max_size=80),
        ),
        st.sampled_from(COMMANDS),
    )
    @example("[" * 20000, COMMANDS[0])
    @example("a = " + "[" * 20000 + "]" * 20000, COMMANDS[0])
    @example("a = " + "{a=" * 20000, COMMANDS[0])
    @example("a." * 1000 + "a = 1", COMMANDS[0])
    @example("a = " + "9" * 10000, COMMANDS[0])
    @examples(200)
    def test_every_command_accepts_it_or_reports_why_not(self, text, words):
        out = self.work / "out.h"
        self.asked(out, words[0], self.file("m.toml", text), *words[1:], "-o", out)

    @given(damaged(SCENARIO.encode()))
    @examples(60)
    def test_scenarios(self, text):
        assume(
            b"duration_s = 30.0\n" in text and b"rate_hz = 50.0\n" in text
        )  # otherwise it may be a large one
        self.asked(
            self.work / "out.csv",
            "simulate",
            self.file("s.toml", text),
            "-o",
            self.work / "out.csv",
        )

    @given(
        st.dictionaries(
            st.sampled_from(
                ("duration_s", "seed", "vibration_g", "tilt_g", "temperature_degC", "odd")
            ),
            SCALAR,
            min_size=1,
        ),
        SCALAR,
    )
    @examples(60)
    def test_scenarios_of_any_values(self, settings, rate):
        if isinstance(settings.get("duration_s"), float) and isinstance(rate, float):
            assume(not 0 < settings["duration_s"] * rate < 1e9)
        settings = {"duration_s": 30.0} | settings
        text = FULL.replace("50.0", toml_of(rate)) if rate is not None else FULL
        text += "[simulate]\n" + "".join(
            f"{name} = {toml_of(value)}\n" for name, value in settings.items() if value is not None
        )
        assume(not isinstance(rate, (int, float)) or rate < 1e6)
        assume(not isinstance(settings["duration_s"], (int, float)) or settings["duration_s"] < 1e4)
        self.asked(
            self.work / "out.csv",
            "simulate",
            self.file("s.toml", text),
            "-o",
            self.work / "out.csv",
        )


class Others(asked.Lawful):
    @given(
        st.one_of(
            damaged(LIMITS.encode()),
            st.dictionaries(
                st.sampled_from(("at_limit", "adequate", "limit", "odd")),
                st.one_of(
                    SCALAR,
                    st.lists(
                        st.dictionaries(
                            st.sampled_from(("coefficient", "min", "max", "odd")), SCALAR
                        ),
                        max_size=2,
                    ),
                ),
            ).map(text_of),
        )
    )
    @examples(200)
    def test_limits(self, text):
        path = self.file("l.toml", text)
        try:
            found = limits.read(path)
        except BadInput as why:
            self.assertIn("l.toml", str(why))
            return
        with open(path, "rb") as file:
            plain = tomllib.load(file)
        self.assertEqual(
            (found.at_limit, found.adequate),
            (plain.get("at_limit", 0.025), plain.get("adequate", False)),
        )
        wanted = [
            (one["coefficient"], float(one[name]), side)
            for one in plain.get("limit", [])
            for name, side in (("min", -1), ("max", 1))
            if name in one
        ]
        self.assertEqual([(one.coefficient, one.value, one.side) for one in found.limits], wanted)

    @given(
        st.one_of(
            damaged(KALIBR.encode()),
            st.binary(max_size=60),
            st.text(max_size=60),
            st.dictionaries(
                st.sampled_from(
                    ("gyroscope_noise_density", "gyroscope_random_walk", "imu0", "rate_hz")
                ),
                SCALAR,
            ).map(repr),
        )
    )
    @example("imu0: " + "[" * 20000)
    @example(
        "a: &a [x, x]\nb: &b [*a, *a, *a, *a, *a, *a]\nc: &c [*b, *b, *b, *b]\n"
        "gyroscope_noise_density: *c"
    )
    @example("gyroscope_noise_density: 2024-99-99\n")
    @example("gyroscope_noise_density: !!int x\n")
    @examples(150)
    def test_kalibr(self, text):
        out = self.work / "out.toml"
        path = self.file("imu.yaml", text)
        done = run_sheet(self, path, out)
        if done.returncode == 0:
            models.read(out)

    @given(
        st.sampled_from(sorted(kalibr.SHEET)),
        st.one_of(st.floats(0, 1e29).map(repr), st.text("0123456789.eE+-_ \u0661", max_size=12)),
    )
    @examples(150)
    def test_sheets(self, unit, number):
        try:
            found = kalibr.of_sheet([number + unit], "gyro_z_dps", None)
        except BadInput:
            return
        kind, factor = kalibr.SHEET[unit]
        self.assertEqual(found.kinds, [kind])
        self.assertTrue(
            math.isclose(
                table.find(kind).dps(found.terms[0].parameters),
                float(number) * factor,
                rel_tol=1e-14,
            ),
            number,
        )


def run_sheet(test, path, out):
    out.unlink(missing_ok=True)
    done = asked.run("sheet", "--kalibr", path, "-o", out)
    test.keeps_the_law(done, path)
    test.assertEqual(out.exists(), done.returncode == 0)
    return done


if __name__ == "__main__":
    unittest.main()
