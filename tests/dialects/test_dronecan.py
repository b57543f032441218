"""DroneCAN: the dronecan package decodes every frame, and its RawIMU has our covariance."""

import subprocess

import dronecan
import numpy as np
import pytest
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


@pytest.mark.parametrize("number", MESSAGES)
def test_every_frame_is_read(number):
    for made, channel in batches(number / 6):
        node = 1 + 14 * channel
        found = decoded(made, channel=channel, node=node)
        assert len(found) == 6 * len(made)
        types = {dronecan.get_dronecan_data_type(one.payload).full_name for one in found}
        assert types == {"uavcan.protocol.debug.KeyValue"}
        assert {(one.source_node_id, one.transfer_priority) for one in found} == {(node, 24)}
        assert [one.transfer_id for one in found] == [n % 32 for n in range(len(found))]
        wanted = quantities(made)
        for first, key in enumerate(KEYS):
            mine = [one.payload for one in found[first::6]]
            assert {bytes(one.key).decode() for one in mine} == {key + NAMES[channel]}
            assert mismatches(wanted[:, first], [one.value for one in mine]) == 0


def test_raw_imu_has_the_variances_as_float16():
    """The diagonal of RawIMU is its last array, so that it is the end of the payload."""
    source = np.random.default_rng(1)
    variances = 10.0 ** source.uniform(-12, 6, (400, 6))
    variances[source.random(variances.shape) < 0.1] = np.nan
    variances[:6, 0] = np.inf, 1e31, 65519.0, 65520.0, 1e-40, 65504.0
    words = [PROBE, "covariance"]
    done = subprocess.run(words, input=variances.tobytes(), stdout=subprocess.PIPE, check=True)
    with np.errstate(over="ignore"):
        wanted = variances.astype("f2").astype("f8")
    wanted[variances < 2.0**-24] = 2.0**-24  # never 0: that would mean no noise
    for row, expected in enumerate(wanted):
        plain = dronecan.uavcan.equipment.ahrs.RawIMU()
        plain.integration_interval = float(row)
        plain.accelerometer_integral[2] = 9.5
        payload = bytes_from_bits(plain._pack()) + done.stdout[12 * row : 12 * row + 12]
        found = dronecan.uavcan.equipment.ahrs.RawIMU()
        found._unpack(bits_from_bytes(payload))
        assert found.integration_interval == float(row)
        assert found.accelerometer_integral[2] == 9.5
        np.testing.assert_array_equal(expected, list(found.covariance))
