"""Units and numbers at the limits of a double: factors compared with the unit's name, exports with
yaml and formulas computed here, printed numbers with float().
"""

import argparse
import json
import math
import re
import struct
import unittest
from decimal import Decimal
from profile import examples

import asked
import yaml
from davarlab import kalibr
from davarlab import model as models
from davarlab.commands import option_types
from davarlab.data import guess
from davarlab.effects import table
from davarlab.inference.estimate import Estimate
from davarlab.report import parameters, terminal, values, words
from davarlab.wire import raw
from hypothesis import example, given
from hypothesis import strategies as st

RAD = math.pi / 180
WORDS = {
    "deg": 1.0,
    "mdeg": 1e-3,
    "rad": 180 / math.pi,
    "s": 1.0,
    "h": 3600.0,
    "ms": 1e-3,
    "us": 1e-6,
    "ns": 1e-9,
    "Hz": 1.0,
    "m": 1.0,
    "degC": 1.0,
    "sqrt": math.sqrt,
    "ug": 9.80665e-6,
    "mg": 9.80665e-3,
    "g": 9.80665,
    "samples": 1.0,
    "dps": 1.0,
}
SIZES = st.one_of(
    st.floats(0, 1e9, exclude_min=True), st.sampled_from((5e-324, 1e-300, 1e-5, 2e-6, 1.0, 1e6))
)
DOUBLES = st.one_of(
    st.floats(),
    st.sampled_from((5e-324, 1.7976931348623157e308, -0.0, 1e-4, 9999.5, 999999.5, 1e6)),
)


def meaning(unit):
    """A unit in deg, m and s, computed from its name."""
    return eval(unit.replace("^", "**"), {"__builtins__": {}}, WORDS)


class Units(unittest.TestCase):
    def test_every_unit_of_a_sheet_matches_its_name(self):
        for sheet, column in ((kalibr.SHEET, "gyro_z_dps"), (kalibr.ACCEL_SHEET, "accel_z_g")):
            for unit in sheet:
                term = kalibr.of_sheet([f"3.5{unit}"], column, None).terms[0]
                self.assertAlmostEqual(
                    table.find(term.kind).dps(term.parameters) / (3.5 * meaning(unit)),
                    1,
                    places=12,
                    msg=unit,
                )

    def test_every_unit_of_a_model_matches_its_name(self):
        asked_of = [
            (effect.kind, one)
            for effect in table.TABLE.values()
            for one in effect.parameters
            if re.fullmatch(r"deg/(s|h|sqrt\(h\)|h/sqrt\(h\)|h\^2)", one.unit)
        ]
        self.assertGreater(len(asked_of), 8)
        for kind, one in asked_of:
            self.assertAlmostEqual(
                one.scale / meaning(one.unit), 1, places=12, msg=f"{kind} {one.name}"
            )

    def test_every_unit_of_a_log_matches_its_name(self):
        for quantity, base in (("time", "s"), ("gyro", "deg/s"), ("accel", "g")):
            for unit, factor in guess.UNITS[quantity].items():
                self.assertAlmostEqual(
                    factor / (meaning(unit) / meaning(base)), 1, places=12, msg=unit
                )


def model_of(white, walk, rate_hz, flicker=None):
    sizes = {"angle_random_walk": white, "rate_random_walk": walk} | (
        {"bias_instability": flicker} if flicker else {}
    )
    return kalibr.model_of(sizes, "gyro_z_dps", rate_hz)


class Exports(asked.Lawful):
    def exported(self, model, *options):
        """The text of an exported model, or None if the export is rejected."""
        path, out = self.work / "m.toml", self.work / "out.h"
        models.write(model, path)
        done = self.asked(out, "export", path, "-o", out, *options)
        text = out.read_text() if done.returncode == 0 else None
        self.assertNotRegex(text or "", r"(?i)(?<![a-z])(nan|inf)(?![a-z])")
        return text

    @given(SIZES, SIZES, st.floats(1e-3, 1e6))
    @example(0.3, 5e-3, 100.0)
    @examples(80)
    def test_kalibr_reads_numbers_and_back_they_are_the_same(self, white, walk, rate_hz):
        text = self.exported(model_of(white, walk, rate_hz), "--to", "kalibr")
        if text is None:
            return
        found = yaml.safe_load(text)
        wanted = {
            "gyroscope_noise_density": white * RAD / 60,
            "gyroscope_random_walk": walk * RAD / 216000,
            "update_rate": rate_hz,
        }
        for name, value in wanted.items():
            self.assertIsInstance(
                found[name], (float, int), f"{name}: {found[name]!r} is text to YAML 1.1"
            )
            self.assertTrue(
                math.isclose(found[name], value, rel_tol=1e-5, abs_tol=1e-300),
                (name, found[name], value),
            )
        path, back = self.file("imu.yaml", text), self.work / "back.toml"
        self.assertEqual(asked.run("sheet", "--kalibr", path, "-o", back).returncode, 0)
        for term, was in zip(models.read(back).terms, (white, walk), strict=True):
            self.assertTrue(
                math.isclose(
                    next(iter(term.parameters.values())), was, rel_tol=1e-5, abs_tol=1e-300
                )
            )

    @given(
        SIZES,
        SIZES,
        st.floats(1e-300, 1e300),
        st.sampled_from(sorted(parameters.FORMATS)),
        DOUBLES,
        DOUBLES,
    )
    @examples(150)
    def test_no_format_prints_bad_numbers(self, white, walk, rate_hz, form, inflate, seconds):
        if 0 < inflate < math.inf and 0 < seconds < math.inf:
            self.exported(
                model_of(white, walk, rate_hz),
                "--to",
                form,
                "--inflate",
                repr(inflate),
                "--bias-time",
                repr(seconds),
            )
            self.exported(
                kalibr.model_of(
                    {"angle_random_walk": white, "bias_instability": walk}, "gyro_z_dps", rate_hz
                ),
                "--to",
                form,
                "--bias-time",
                repr(seconds),
            )

    @given(SIZES, SIZES, st.floats(1e-9, 1e9), st.integers(100, 4000))
    @examples(40)
    def test_tables_for_the_device_are_those_of_the_formulas(self, white, walk, rate_hz, window):
        text = self.exported(model_of(white, walk, rate_hz), "--window", str(window))
        if text is None:
            return
        rows = re.findall(r"\{ (\d+)U, (\S+), (\S+) \}", text)
        self.assertEqual(len(rows), int(re.search(r"TAU_COUNT (\d+)", text)[1]))
        for _, adev, _ in rows:
            self.assertGreater(float(adev), 0)


class Imports(asked.Lawful):
    @given(
        DOUBLES.map(repr), st.sampled_from(("--scale gyro_z_dps=", "--scale time_s=", "--rate "))
    )
    @examples(100)
    def test_factors_and_rates_of_any_size(self, value, option):
        rows = "".join(f"{place / 50},{place % 7 - 3}\n" for place in range(20))
        words_of = (option + value).split()
        out = self.work / "out.csv"
        out.unlink(missing_ok=True)
        path = self.file("r.csv", f"time_s,gyro_z_dps\n{rows}")
        done = asked.run("import", path, "-o", out, *words_of)
        self.assertIn(done.returncode, (0, 2), done.stderr)
        self.assertEqual(out.exists(), done.returncode == 0)
        if done.returncode == 0:
            self.assertNotRegex(out.read_text(), "nan|inf")


def close(text, value, relative):
    """True if the text of a number gives the same double."""
    if not math.isfinite(value):
        return float(text) == value or value != value and float(text) != float(text)
    return abs(Decimal(text) - Decimal(value)) <= abs(Decimal(value)) * Decimal(relative) + Decimal(
        "5e-324"
    )


class Said(unittest.TestCase):
    @given(DOUBLES, st.integers(3, 9))
    @examples(300)
    def test_a_number_for_people_is_that_number(self, value, digits):
        said = words.number(value, digits)
        if value != value:
            self.assertEqual(said, "–")
        elif math.isinf(value):
            self.assertEqual(said, "−∞" if value < 0 else "∞")
        else:
            plain = (
                said.replace("−", "-")
                .replace("·10", "e")
                .translate(str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-"))
            )
            mantissa, _, power = plain.partition("e")
            self.assertTrue(
                close(f"{mantissa}e{power or 0}", value, 0.51 * 10 ** (2 - digits)), (said, value)
            )

    @given(DOUBLES, DOUBLES, DOUBLES)
    @examples(100)
    def test_intervals_of_any_numbers(self, value, low, high):
        said = terminal.interval(Estimate(value, low, high))
        for end, was in zip(re.fullmatch(r"95 %: (\S+) \.\. (\S+)", said).groups(), (low, high)):
            self.assertTrue(close(end, was, 1e-4), said)
        words.bounds(Estimate(value, low, high))
        words.chance(value)

    @given(
        st.recursive(
            DOUBLES,
            lambda inner: (
                st.lists(inner, max_size=3)
                | st.dictionaries(st.text(max_size=3), inner, max_size=3)
            ),
        )
    )
    @examples(100)
    def test_json_has_no_infinity(self, value):
        plain = values.plain(value)
        self.assertEqual(json.loads(json.dumps(plain, allow_nan=False)), plain)

    @given(st.floats(width=32, allow_nan=False))
    @examples(300)
    def test_a_single_is_written_as_it_was_meant(self, single):
        self.assertEqual(struct.pack("<f", raw.written(single)), struct.pack("<f", single))

    @given(
        st.one_of(
            st.text(max_size=12), DOUBLES.map(repr), st.integers().map(str), st.just("9" * 5000)
        ),
        st.sampled_from(
            (
                option_types.whole,
                option_types.natural,
                option_types.positive,
                option_types.identifier,
                option_types.channel,
                option_types.port,
            )
        ),
    )
    @examples(300)
    def test_options_are_numbers_or_rejected(self, text, kind):
        try:
            value = kind(text)
        except (argparse.ArgumentTypeError, ValueError):
            return
        self.assertTrue(math.isfinite(value) and value >= 0)
        self.assertEqual(
            value,
            int(text, 16)
            if kind is option_types.identifier
            else float(text)
            if kind is option_types.positive
            else int(text),
        )


if __name__ == "__main__":
    unittest.main()
