"""MAVLink: pymavlink decodes every packet, with the classes that its generator makes of
tools/dialects/davar.xml too.
"""

import functools
import importlib.util
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
from pymavlink.dialects.v20 import common
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


@functools.cache
def generated():
    """The module that mavgen makes of our dialect."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(XML, folder)
        words = [sys.executable, "-m", "pymavlink.tools.mavgen", "--lang", "Python"]
        words += ["--wire-protocol", "2.0", "-o", "davar_dialect", XML.name]
        subprocess.run(words, cwd=folder, check=True, stdout=subprocess.DEVNULL)
        spec = importlib.util.spec_from_file_location("davar_dialect", f"{folder}/davar_dialect.py")
        module = importlib.util.module_from_spec(spec)
        sys.modules["davar_dialect"] = module
        spec.loader.exec_module(module)
    return module


def decoded(dialect, made, **address):
    """The messages of results, from one stream of bytes."""
    module = generated() if dialect == "gyro_noise" else common
    parser = module.MAVLink(None)
    stream = b"".join(data for _, data in packets(dialect, made, **address))
    found = parser.parse_buffer(stream)
    assert parser.total_receive_errors == 0
    assert parser.total_bytes_received == len(stream)
    return found


class Mavlink(unittest.TestCase):
    def header(self, messages, node, system):
        headers = [message.get_header() for message in messages]
        self.assertEqual({(system, node)}, {(one.srcSystem, one.srcComponent) for one in headers})
        sequence = np.array([one.seq for one in headers])
        self.assertTrue((sequence == np.arange(len(headers)) % 256).all())

    def check(self, made, channel):
        found = decoded("mavlink", made, channel=channel, node=191, system=3)
        self.assertEqual(3 * len(made), len(found))
        self.header(found, 191, 3)
        for first, kind, name in ((0, ARW, "ARW_"), (1, BI, "BI_")):
            named = found[first::3]
            self.assertEqual({"NAMED_VALUE_FLOAT"}, {one.get_type() for one in named})
            self.assertEqual({name + NAMES[channel]}, {one.name for one in named})
            wanted = sent(made["coefficient"][:, kind, 0])
            self.assertEqual(0, mismatches(wanted, [one.value for one in named]))
            ms = (made["time_us"] // 1000).astype("u4")
            self.assertTrue((ms == [one.time_boot_ms for one in named]).all())
        self.check_arrays(made, found[2::3], channel)

    def check_arrays(self, made, arrays, channel):
        self.assertEqual({"DEBUG_FLOAT_ARRAY"}, {one.get_type() for one in arrays})
        self.assertEqual({("davar", channel)}, {(one.name, one.array_id) for one in arrays})
        self.assertTrue((made["time_us"] == [one.time_usec for one in arrays]).all())
        data = np.array([one.data for one in arrays])
        self.assertEqual(0, mismatches(quantities(made), data[:, :13]))
        self.assertEqual(0, mismatches(made["window_samples"].astype("f4"), data[:, 13]))
        self.assertTrue((data[:, 14] == state(made)).all())
        self.assertTrue((data[:, 15] == made["epoch"] % 2**24).all())
        self.assertFalse(data[:, 16:].any())

    def check_gyro_noise(self, made, channel):
        found = decoded("gyro_noise", made, channel=channel)
        self.assertEqual({"GYRO_NOISE"}, {one.get_type() for one in found})
        self.header(found, 42, 7)
        for name in ("time_usec", "epoch", "window_samples", "channel", "state"):
            wanted = {
                "time_usec": made["time_us"],
                "epoch": made["epoch"].astype("u4"),
                "window_samples": made["window_samples"],
                "channel": np.full(len(made), channel),
                "state": state(made),
            }[name]
            self.assertTrue((wanted == [getattr(one, name) for one in found]).all(), name)
        names = [kind + limit for kind in ("arw", "bi", "rrw") for limit in ("", "_low", "_high")]
        names += ["rr", "qn", "kurtosis", "rate_hz"]
        values = [[getattr(one, name) for name in names] for one in found]
        self.assertEqual(0, mismatches(quantities(made), values))

    def test_every_message_is_read(self):
        for made, channel in batches(MESSAGES):
            self.check(made, channel)

    def test_every_message_of_the_proposed_type_is_read(self):
        for made, channel in batches(MESSAGES):
            self.check_gyro_noise(made, channel)


if __name__ == "__main__":
    unittest.main()
