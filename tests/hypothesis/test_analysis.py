"""compare, fit, diagnose and improve on recordings and models of any size: a result with status 0
or 1, or an error; never anything else.
"""

import numpy as np
from davarlab import model as models
from davarlab.data import recording as recordings
from hypothesis import given
from hypothesis import strategies as st
from lawful import check_law, examples, run
from models_made import terms

SHAPES = {
    "noise": lambda n, rng: rng.standard_normal(n),
    "constant": lambda n, rng: np.ones(n),
    "ramp": lambda n, rng: np.linspace(0, 1, n),
    "sine": lambda n, rng: np.sin(0.3 * np.arange(n)),
    "two values": lambda n, rng: rng.integers(0, 2, n) * 1.0,
    "counts": lambda n, rng: np.round(rng.standard_normal(n) * 2) / 2,
    "walk": lambda n, rng: np.cumsum(rng.standard_normal(n)),
    "stuck": lambda n, rng: rng.standard_normal(n) * (np.arange(n) < n // 2),
    "late": lambda n, rng: rng.standard_normal(n) * (np.arange(n) > n - 5),
    "spikes": lambda n, rng: rng.standard_normal(n) * (1 + 1e6 * (rng.random(n) < 0.01)),
    "slow sine": lambda n, rng: np.sin(6.3e-4 * np.arange(n)),
    "saw tooth": lambda n, rng: np.arange(n) % 7 * 1.0,
    "repeated": lambda n, rng: np.repeat(rng.standard_normal(n), 3)[:n],
    "heavy": lambda n, rng: rng.standard_cauchy(n),
}
CLOCKS = {
    "even": lambda n, rng: np.arange(n) * 1.0,
    "jitter": lambda n, rng: np.arange(n) + 0.3 * rng.random(n),
    "gaps": lambda n, rng: np.arange(n) + 1000.0 * np.cumsum(rng.random(n) < 0.005),
    "lost": lambda n, rng: np.arange(n) + np.cumsum(rng.random(n) < 0.2) * 1.0,
    "uneven": lambda n, rng: np.cumsum(rng.exponential(size=n)),
    "twice": lambda n, rng: np.arange(n) // 2 * 1.0,
    "stands": lambda n, rng: np.ones(n),
    "denormal": lambda n, rng: 5e-324 * np.arange(n),
}
EXTRA = st.dictionaries(
    st.sampled_from(("temp_degC", "accel_x_g", "accel_y_g", "accel_z_g", "gyro_x_dps", "volt")),
    st.sampled_from(sorted(SHAPES)),
    max_size=3,
)


@given(
    command=st.sampled_from(("compare", "fit", "diagnose", "improve")),
    shape=st.sampled_from(sorted(SHAPES)),
    clock=st.sampled_from(sorted(CLOCKS)),
    extra=EXTRA,
    size=st.sampled_from((1.0, 1.0, 1e-3, 1e-12, 1e12, 1e-20, 1e20)),
    rate_hz=st.sampled_from((50.0, 50.0, 1000.0, 1e-6, 1e8)),
    count=st.sampled_from((1000, 1001, 1500)),
    added=st.lists(terms(), max_size=2),
    report=st.booleans(),
    seed=st.integers(0, 99),
)
@examples(3)
def test_a_result_or_an_error(
    work, command, shape, clock, extra, size, rate_hz, count, added, report, seed
):
    rng = np.random.default_rng(seed)
    columns = {"time_s": CLOCKS[clock](count, rng) / rate_hz}
    columns["gyro_z_dps"] = size * SHAPES[shape](count, rng)
    columns |= {name: SHAPES[kind](count, rng) for name, kind in extra.items()}
    path, model = work / "r.csv", work / "m.toml"
    recordings.write_columns(columns, {}, path)
    white = {"coefficient_deg_per_sqrt_h": 0.3 * min(max(size, 1e-9), 1e6)}
    terms_of = [models.Term("angle_random_walk", white), *added]
    models.write(models.Model(None, "gyro_z_dps", terms_of), model)
    outputs = {"-o": work / "out.toml"} if command == "improve" else {}
    outputs |= {"--report": work / "page.html"} if report and command != "fit" else {}
    for output in outputs.values():
        output.unlink(missing_ok=True)
    done = run(command, path, "-m", model, *sum(outputs.items(), ()))
    # an error names the recording or the model
    named = model.name if model.name in done.err.rsplit("davarlab: ", 1)[-1] else path.name
    check_law(done, named, (0, 1) if command in ("compare", "improve") else (0,))
    for output in outputs.values():
        assert output.exists() == (done.status < 2)
    if command == "improve" and done.status < 2:
        models.read(outputs["-o"])
