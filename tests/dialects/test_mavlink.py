"""MAVLink: pymavlink decodes every packet, with the classes that its generator makes of
tools/dialects/davar.xml too.
"""

import importlib.util
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from pymavlink.dialects.v20 import common
from pymavlink.generator import mavgen
from random_results import (
    ARW,
    BI,
    MESSAGES,
    NAMES,
    batches,
    mismatches,
    packets,
    quantities,
    sent,
    state,
)

XML = Path(__file__).resolve().parents[2] / "tools/dialects/davar.xml"
TERMS = [kind + limit for kind in ("arw", "bi", "rrw") for limit in ("", "_low", "_high")]


@pytest.fixture(scope="module")
def generated(tmp_path_factory):
    """The module that mavgen makes of our dialect."""
    folder = tmp_path_factory.mktemp("mavlink")
    shutil.copy(XML, folder)
    made = folder / "davar_dialect.py"
    mavgen.mavgen(mavgen.Opts(str(made.with_suffix("")), "2.0", "Python"), [folder / XML.name])
    spec = importlib.util.spec_from_file_location("davar_dialect", made)
    module = importlib.util.module_from_spec(spec)
    sys.modules["davar_dialect"] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules["davar_dialect"]


def decoded(module, dialect, made, node, system, channel, floor=0):
    """The messages of results, from one stream of bytes. They are numbered."""
    parser = module.MAVLink(None)
    made = packets(dialect, made, channel=channel, node=node, system=system, floor=floor)
    stream = b"".join(data for _, data in made)
    found = parser.parse_buffer(stream)
    assert (parser.total_receive_errors, parser.total_bytes_received) == (0, len(stream))
    headers = [message.get_header() for message in found]
    assert {(one.srcSystem, one.srcComponent) for one in headers} == {(system, node)}
    assert [one.seq for one in headers] == [n % 256 for n in range(len(headers))]
    return found


@pytest.mark.parametrize("number", MESSAGES)
def test_every_message_is_read(number):
    for made, channel in batches(number):
        found = decoded(common, "mavlink", made, 191, 3, channel)
        assert len(found) == 3 * len(made)
        for first, kind, name in ((0, ARW, "ARW_"), (1, BI, "BI_")):
            named = found[first::3]
            types = {(one.get_type(), one.name) for one in named}
            assert types == {("NAMED_VALUE_FLOAT", name + NAMES[channel])}
            wanted = sent(made["coefficient"][:, kind, 0])
            assert mismatches(wanted, [one.value for one in named]) == 0
            ms = (made["time_us"] // 1000).astype("u4")
            assert (ms == [one.time_boot_ms for one in named]).all()
        arrays = found[2::3]
        types = {(one.get_type(), one.name, one.array_id) for one in arrays}
        assert types == {("DEBUG_FLOAT_ARRAY", "davar", channel)}
        assert (made["time_us"] == [one.time_usec for one in arrays]).all()
        data = np.array([one.data for one in arrays])
        assert mismatches(quantities(made), data[:, :13]) == 0
        assert mismatches(made["window_samples"].astype("f4"), data[:, 13]) == 0
        assert (data[:, 14] == state(made)).all()
        assert (data[:, 15] == made["epoch"] % 2**24).all()
        assert not data[:, 16:].any()


def test_the_floor_is_a_named_value_and_at_the_end_of_the_array():
    for made, channel in batches(1000):
        found = decoded(common, "mavlink", made, 191, 3, channel, floor=1)
        assert len(found) == 4 * len(made)
        floor, low, high = (sent(made["floor"][:, at], at == 2) for at in range(3))
        assert {one.name for one in found[3::4]} == {"FLR_" + NAMES[channel]}
        assert mismatches(floor, [one.value for one in found[3::4]]) == 0
        data = np.array([one.data for one in found[2::4]])
        assert mismatches(np.stack([floor, low, high], axis=1), data[:, 16:19]) == 0
        assert (data[:, 19] == made["floor_why"]).all()
        assert not data[:, 20:].any()


@pytest.mark.parametrize("number", MESSAGES)
def test_every_message_of_the_proposed_type_is_read(generated, number):
    for made, channel in batches(number):
        found = decoded(generated, "gyro_noise", made, 42, 7, channel)
        assert {one.get_type() for one in found} == {"GYRO_NOISE"}
        wanted = {
            "time_usec": made["time_us"],
            "epoch": made["epoch"].astype("u4"),
            "window_samples": made["window_samples"],
            "channel": np.full(len(made), channel),
            "state": state(made),
        }
        for name, values in wanted.items():
            assert (values == [getattr(one, name) for one in found]).all(), name
        names = [*TERMS, "rr", "qn", "kurtosis", "rate_hz"]
        values = [[getattr(one, name) for name in names] for one in found]
        assert mismatches(quantities(made), values) == 0
