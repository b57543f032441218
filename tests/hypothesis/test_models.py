"""Models, scenarios, limits and data sheets of any values: accepted ones are those that tomllib,
yaml or float() reads; a rejected one is reported with its file. Written and read again, a model is
the same.
"""

import math
import tomllib

import yaml
from davarfleet import limits
from davarlab import kalibr
from davarlab import model as models
from davarlab.effects import table
from davarlab.errors import BadInput
from hypothesis import assume, example, given
from hypothesis import strategies as st
from lawful import damaged, examples
from models_made import COLUMNS, SCALAR, SIZES, terms, text_of, toml_of

RAD = math.pi / 180
BASE = (
    '[sensor]\nrate_hz = {rate}\ncolumn = "gyro_z_dps"\n[[effect]]\nkind = "angle_random_walk"\n'
    'coefficient_deg_per_sqrt_h = 0.3\n[[effect]]\nkind = "low_pass"\ncutoff_hz = 9.0\norder = 2\n'
)
LIMITS = (
    "at_limit = 0.02\nadequate = true\n[[limit]]\n"
    'coefficient = "angle_random_walk.coefficient_deg_per_sqrt_h"\nmin = 0.1\nmax = 0.4\n'
)
SHEET = {  # unit: the effect, and its size in deg and s
    "deg/sqrt(h)": ("angle_random_walk", 1 / 60),
    "deg/s/sqrt(Hz)": ("angle_random_walk", 1.0),
    "mdps/√Hz": ("angle_random_walk", 1e-3),
    "rad/s/sqrt(Hz)": ("angle_random_walk", 180 / math.pi),
    "°/h": ("bias_instability", 1 / 3600),
    "deg/h/sqrt(h)": ("rate_random_walk", 1 / 216000),
}
UNIT_PARTS = ("deg", "°", "mdps", "ug", "m", "s", "hr", "Hz", "sqrt", "√", "rt", "per", "rms", "1σ")
UNIT_SIGNS = ("/", "*", "-", "(", ")", "^", "2", "-1", "1/2", ".5", " ", "²", "½", "⁻¹", "é", "\0")


def highest_hz(term):
    """The highest frequency of a line; 0 for other effects."""
    course = term.parameters.get("course_hz", "0").split()
    return max(term.parameters.get("frequency_hz", 0), *map(float, course), 0)


@st.composite
def entries(draw):
    """A user's description of an effect: most of it is correct."""
    term = draw(terms())
    entry = {"kind": term.kind, **term.parameters}
    for _ in range(draw(st.integers(0, 2))):
        entry[draw(st.sampled_from(["kind", *term.parameters, "other"]))] = draw(SCALAR)
    return entry


SENSORS = st.fixed_dictionaries(
    {"column": COLUMNS | SCALAR}, optional={"rate_hz": st.floats(1, 1e6) | SCALAR}
)
TABLES = st.fixed_dictionaries(
    {"sensor": SENSORS | SCALAR},
    optional={
        "effect": st.lists(entries(), max_size=3) | SCALAR,
        "simulate": SCALAR,
        "odd": SCALAR,
    },
)


def read_by(read, path):
    """(what it reads, what tomllib reads); None if it rejects the file by name."""
    try:
        found = read(path)
    except BadInput as why:
        assert path.name in str(why)
        return None
    return found, tomllib.loads(path.read_text(encoding="utf-8"))


def differs(term):
    """Is the reference of noise_follows, at which it is stated, away from its origin, at which
    it is 0."""
    if term.kind != "noise_follows":
        return True
    origin, reference = (term.parameters[name] for name in ("origin", "reference"))
    most = max(abs(origin), abs(reference))
    return most > 1e-29 and abs(reference - origin) > 1e-8 * most


@given(rate_hz=st.floats(1e-3, 1e6) | st.none(), column=COLUMNS, made=st.lists(terms(), max_size=4))
@examples(120)
def test_a_written_model_is_read(work, rate_hz, column, made):
    assume(not any(term.parameters.get("column") == column for term in made))
    assume(all(differs(term) for term in made))
    assume(not rate_hz or not any(highest_hz(term) > rate_hz / 2 for term in made))
    wanted = models.Model(rate_hz, column, made)
    models.write(wanted, work / "m.toml")
    found, plain = read_by(models.read, work / "m.toml")
    assert found == wanted
    assert plain["sensor"] == {"column": column} | ({"rate_hz": rate_hz} if rate_hz else {})
    assert len(plain.get("effect", [])) == len(made)


@given(data=TABLES)
@examples(250)
def test_a_model_has_the_values_of_tomllib(work, data):
    read = read_by(models.read, work.file("m.toml", text_of(data)))
    if not read:
        return
    found, plain = read
    sensor = plain["sensor"]
    assert (found.column, found.rate_hz) == (sensor["column"], sensor.get("rate_hz"))
    for term, entry in zip(found.terms, plain.get("effect", []), strict=True):
        said = {"kind": models.kind_said(term.kind, found.column)}
        for parameter in table.find(term.kind).parameters:
            if parameter.name in term.parameters:
                said[models.name_said(parameter.name, found.column)] = term.parameters[
                    parameter.name
                ]
        assert said == entry


SETTINGS = ("duration_s", "seed", "vibration_g", "tilt_g", "temperature_degC", "odd")


@given(settings=st.dictionaries(st.sampled_from(SETTINGS), SCALAR, min_size=1), rate=SCALAR)
@examples(60)
def test_scenarios_of_any_values(work, settings, rate):
    settings = {"duration_s": 30.0} | settings
    duration = settings["duration_s"]
    for value, most in ((rate, 1e6), (duration, 1e4)):  # otherwise it is a long one
        assume(not isinstance(value, (int, float)) or value < most)
    if isinstance(rate, float) and isinstance(duration, float):
        assume(not 0 < duration * rate < 1e9)
    text = BASE.format(rate=50.0 if rate is None else toml_of(rate))
    path = work.file("s.toml", f"{text}[simulate]\n{text_of(settings)}")
    work.lawful("out.csv", "simulate", path, "-o", "OUT")


LIMIT = st.dictionaries(st.sampled_from(("coefficient", "min", "max", "odd")), SCALAR)
TOP = st.sampled_from(("at_limit", "adequate", "limit", "odd"))


@given(
    text=damaged(LIMITS.encode())
    | st.dictionaries(TOP, SCALAR | st.lists(LIMIT, max_size=2)).map(text_of)
)
@example(LIMITS)
@examples(150)
def test_limits_have_the_values_of_tomllib(work, text):
    read = read_by(limits.read, work.file("l.toml", text))
    if not read:
        return
    found, plain = read
    wanted = (plain.get("at_limit", 0.025), plain.get("adequate", False))
    assert (found.at_limit, found.adequate) == wanted
    sides = [
        (one["coefficient"], float(one[name]), side)
        for one in plain.get("limit", [])
        for name, side in (("min", -1), ("max", 1))
        if name in one
    ]
    assert [(one.coefficient, one.value, one.side) for one in found.limits] == sides


@given(
    unit=st.sampled_from(sorted(SHEET)),
    number=st.floats(0, 1e29).map(repr) | st.text("0123456789.eE+-_ \u0661", max_size=12),
)
@examples(150)
def test_a_number_of_a_data_sheet_is_that_of_float(unit, number):
    try:
        found = kalibr.of_sheet([number + unit], "gyro_z_dps", None)
    except BadInput:
        return
    kind, factor = SHEET[unit]
    assert found.kinds == [kind]
    size = table.find(kind).dps(found.terms[0].parameters)
    assert math.isclose(size, float(number) * factor, rel_tol=1e-14), number


@given(unit=st.lists(st.sampled_from(UNIT_PARTS + UNIT_SIGNS), max_size=12).map("".join))
@example("(" * 5000)
@example("h^9" * 15 + "deg")
@examples(300)
def test_any_unit_of_a_data_sheet_is_one_or_rejected(unit):
    for column in ("gyro_z_dps", "accel_z_g"):
        try:
            found = kalibr.of_sheet([f"5{unit}"], column, None)
        except BadInput as why:
            assert str(why).startswith(f"5{unit}".split(" ")[0]), why
            continue
        (term,) = found.terms
        assert 0 < table.find(term.kind).dps(term.parameters) < math.inf


@given(white=SIZES, walk=SIZES, rate_hz=st.floats(1e-3, 1e6))
@example(0.3, 5e-3, 100.0)
@examples(60)
def test_an_exported_kalibr_file_has_numbers_and_comes_back(work, white, walk, rate_hz):
    sizes = {"angle_random_walk": white, "rate_random_walk": walk}
    models.write(kalibr.model_of(sizes, "gyro_z_dps", rate_hz), work / "m.toml")
    words = ("export", work / "m.toml", "--to", "kalibr", "-o", "OUT")
    if work.lawful("imu.yaml", *words).status != 0:
        return
    found = yaml.safe_load((work / "imu.yaml").read_text())
    wanted = {
        "gyroscope_noise_density": white * RAD / 60,
        "gyroscope_random_walk": walk * RAD / 216000,
        "update_rate": rate_hz,
    }
    for name, value in wanted.items():
        assert isinstance(found[name], (float, int)), found[name]  # YAML 1.1 may take it for text
        assert math.isclose(found[name], value, rel_tol=1e-5, abs_tol=1e-300), name
    work.lawful("back.toml", "sheet", "--kalibr", work / "imu.yaml", "-o", "OUT")
    for term, was in zip(models.read(work / "back.toml").terms, (white, walk), strict=True):
        (size,) = term.parameters.values()
        assert math.isclose(size, was, rel_tol=1e-5, abs_tol=1e-300)
