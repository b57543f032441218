"""DroneCAN: the dronecan package decodes every frame, and its RawIMU has our covariance."""

import subprocess
import unittest

import dronecan
import numpy as np
from dronecan.transport import Frame, Transfer, TransferManager, bits_from_bytes, bytes_from_bits
from random_results import MESSAGES, NAMES, PROBE, batches, mismatches, packets, quantities

KEYS = ("AR", "AL", "AH", "BI", "BL", "BH")


def decoded(made, **address):
    """[Transfer] of results, received one frame at a time."""
    manager, found = TransferManager(), []
    for identifier, data in packets("dronecan", made, **address):
        frames = manager.receive_frame(Frame(identifier, data))
        assert frames, "a frame completes no transfer"
        transfer = Transfer()
        transfer.from_frames(frames)
        found.append(transfer)
    return found


class KeyValue(unittest.TestCase):
    def check(self, made, channel, node):
        found = decoded(made, channel=channel, node=node)
        self.assertEqual(6 * len(made), len(found))
        types = {dronecan.get_dronecan_data_type(one.payload).full_name for one in found}
        self.assertEqual({"uavcan.protocol.debug.KeyValue"}, types)
        self.assertEqual(
            {(node, 24)}, {(one.source_node_id, one.transfer_priority) for one in found}
        )
        numbers = np.array([one.transfer_id for one in found])
        self.assertTrue((numbers == np.arange(len(found)) % 32).all())
        wanted = quantities(made)
        for first, key in enumerate(KEYS):
            mine = found[first::6]
            self.assertEqual(
                {key + NAMES[channel]}, {bytes(one.payload.key).decode() for one in mine}
            )
            self.assertEqual(0, mismatches(wanted[:, first], [one.payload.value for one in mine]))

    def test_every_frame_is_read(self):
        for made, channel in batches(MESSAGES / 6):
            self.check(made, channel, 1 + 14 * channel)


class Covariance(unittest.TestCase):
    """The diagonal of RawIMU is its last array, so that it is the end of the payload."""

    def test_raw_imu_has_the_variances_as_float16(self):
        source = np.random.default_rng(1)
        variances = 10.0 ** source.uniform(-12, 6, (2000, 6))
        variances[source.random(variances.shape) < 0.1] = np.nan
        variances[:6, 0] = np.inf, 1e31, 65519.0, 65520.0, 1e-40, 65504.0
        diagonals = subprocess.run(
            [PROBE, "covariance"], input=variances.tobytes(), stdout=subprocess.PIPE, check=True
        ).stdout
        with np.errstate(over="ignore"):
            wanted = variances.astype("f2").astype("f8")
        wanted[variances < 2.0**-24] = 2.0**-24  # never 0: that would mean no noise
        for row, expected in enumerate(wanted):
            plain = dronecan.uavcan.equipment.ahrs.RawIMU()
            plain.integration_interval = float(row)
            plain.accelerometer_integral[2] = 9.5
            payload = bytes_from_bits(plain._pack()) + diagonals[12 * row : 12 * row + 12]
            found = dronecan.uavcan.equipment.ahrs.RawIMU()
            found._unpack(bits_from_bytes(payload))
            self.assertEqual(
                (float(row), 9.5), (found.integration_interval, found.accelerometer_integral[2])
            )
            np.testing.assert_array_equal(expected, list(found.covariance))


if __name__ == "__main__":
    unittest.main()
