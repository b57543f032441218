"""The frames of the C encoder, read by cantools with tools/davar.dbc: random values, every message.
tests/property/test_fields.c shows that the decoder inverts the encoder.
"""

import math
import struct

import pytest
from crccheck.crc import Crc8SaeJ1850
from senders import dbc, probe

BASE, STEP = 0x5D0, 16
SESSION, TAUS = 165, 32  # of wire_probe
OF_NO_RESULT = (5, 6, 9, 11)  # Health, Setup, Raw, and End itself
# By davar_noise_t: the name of the uncertainty of an absent ARW.
REASONS = ("absent", "beyond", "mixed", "constant", "coarse", "filtered")
COEFFICIENTS = (
    *("QuantizationDeg", "ArwDegPerSqrtH", "BiasInstabilityDegPerH"),
    *("RateRandomWalkDegPerHPerSqrtH", "RateRampDegPerH2"),
)


def fnv1a(data):
    """FNV-1a of 32 bits from its definition: start 2166136261, factor 16777619."""
    value = 2166136261
    for byte in data:
        value = (value ^ byte) * 16777619 % 2**32
    return value


def single(value):
    """The nearest float32, as a double."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


def is_float(expected, found):
    both = math.isnan(expected) and math.isnan(found)
    return both or single(expected) == single(found)


def is_scaled(expected, found, unit, bits):
    if math.isnan(expected):
        return found == "absent"
    if expected >= (2**bits - 2.5) * unit:  # rounded, all ones except the last bit
        return found == "beyond"
    return abs(expected - found) <= 0.5000001 * unit


def relative(value, low, high):
    if value and not math.isnan(value):
        return 0.5 * (high - low) / value
    return math.inf if value == 0 and high > low else math.nan


def is_arw(values, signals, unit, bits):
    found, uncertainty = signals["ArwRelativeUncertainty"], relative(*values["C"][1])
    if math.isnan(values["C"][1][0]):
        good = found == REASONS[int(values["R"][5])]
    elif uncertainty > (2**bits - 9) * unit:  # the higher raw values are named
        good = found == "beyond"
    else:
        good = is_scaled(uncertainty, found, unit, bits)
    return good and is_float(values["C"][1][0], signals["ArwDegPerSqrtH"])


def is_state(values, signals, modulus=2**32):
    epoch, window, unstable = map(int, values["R"][:3])
    found = tuple(signals[name] for name in ("Epoch", "WindowSamples", "Unstable"))
    return found == (epoch % modulus, min(window, 2**19 - 1), unstable)


def is_stationary(values, signals, unit=1e-5, bits=(24, 24)):
    kurtosis, contribution = map(float, values["R"][3:5])
    return is_scaled(kurtosis, signals["Kurtosis"], 1e-3, bits[0]) and is_scaled(
        contribution, signals["Contribution"], unit, bits[1]
    )


def is_change(values, signals):
    alarm, young, m, age, dispersion, *told = values["G"]
    found = tuple(signals[name] for name in ("Alarm", "Young", "ChangeClusterSamples"))
    item = signals["ChangeItem"]
    if item > 0:
        name = ("ChangeOlderDps", "ChangeNewerDps", "ChangeGain")[item - 1]
        good = is_float(told[item - 1], signals[name])
    else:
        good = signals["CutAge"] == min(age, 2**20 - 1)
        good = good and is_scaled(dispersion, signals["Dispersion"], 0.01, 12)
    return good and found == (alarm, young, m)


def is_adev(values, signals):
    tau = values["T"][signals["TauIndex"]]
    uncertainty = signals["AdevRelativeUncertainty"]
    return is_float(tau[0], signals["AdevDps"]) and is_scaled(relative(*tau), uncertainty, 1e-3, 11)


def is_coefficient(values, signals):
    kind = signals["Kind"].value
    return is_float(values["C"][kind % 5][kind // 5], signals[str(signals["Kind"])])


def is_health(values, signals):
    item = signals["HealthIndex"]
    return (signals["Session"], signals[str(item)]) == (SESSION, values["H"][item.value])


def is_monitor(values, signals):
    health, worst, *deviations = values["M"]
    index = signals["MonitorIndex"]
    if index < 32:
        return is_float(deviations[index], signals["ModelDeviation"])
    expected = "absent" if worst == TAUS else worst
    return is_float(health, signals["ModelHealth"]) and signals["WorstTau"] == expected


def is_floor(values, signals):
    why, *floor = values["L"]
    kind = signals["FloorKind"]
    name = ("FloorDegPerSqrtH", "FloorLowDegPerSqrtH", "FloorHighDegPerSqrtH")[kind]
    return signals["FloorWhy"].value == why and is_float(floor[kind], signals[name])


def is_end(values, signals):
    found = tuple(signals[name] for name in ("Session", "Frames", "Digest"))
    return found == (SESSION, *values["E"])


def is_setup(values, signals):
    item = signals["Item"]
    if item < 2:
        name, expected = (("RateHz", single(99.3)), ("Stride", 4000000000))[item]
    else:
        last = 2**32 - 1 if item - 32 == TAUS - 1 else 2 ** (item - 32)
        name, expected = "ClusterSamples", last
    return (signals["Session"], signals[name]) == (SESSION, expected)


def is_fd(values, signals):
    rates = [*zip(COEFFICIENTS, values["C"])]
    rates += [(f"Adev{index}Dps", values["T"][index]) for index in range(8)]
    return (
        is_state(values, signals, 2**24)
        and is_stationary(values, signals, 1e-3, (16, 12))
        and is_arw(values, signals, 1e-3, 12)
        and all(is_float(one[0], signals[name]) for name, one in rates)
    )


CHECKS = {
    "Arw": lambda values, signals: is_arw(values, signals, 1e-4, 16),
    "State": is_state,
    "Stationarity": is_stationary,
    "Adev": is_adev,
    "Coefficient": is_coefficient,
    "Health": is_health,
    "Setup": is_setup,
    "Monitor": is_monitor,
    "ResultFd": is_fd,
    "Change": is_change,
    "End": is_end,
    "Floor": is_floor,
}


def results(seed, count, content, channel, *floor):
    """Yields (values, frames) of random results; frames are (identifier, data)."""
    values, frames = None, []
    for line in [*probe("encode", seed, count, content, channel, *floor), "R end"]:
        kind, *word = line.split()
        if kind == "R":
            if values:
                yield values, frames
            values, frames = {"R": word, "T": [], "C": [], "H": []}, []
        elif kind == "F":
            slcan = word[2] if len(word) > 2 else None
            frames.append((int(word[0], 16), bytes.fromhex(word[1]), slcan))
        elif kind in "MGL":
            values[kind] = [float(number) for number in word]
        elif kind == "H":
            values["H"].append(int(word[1]))
        else:
            values[kind].append([float(number) for number in word[1:]])


HEAD, TAIL = ["State", "Stationarity", "Arw"], ["Health", "Setup", "End"]
ADEVS, REST = ["Adev"] * TAUS, ["Adev"] * (TAUS - 8)
MONITOR = ["Monitor"] * (TAUS + 1)
FLOOR = ["Floor"] * 3


@pytest.mark.parametrize(
    ("seed", "content", "channel", "names"),
    [
        (1, 0, 3, [*HEAD, *TAIL]),
        (2, 7, 0, [*HEAD, *ADEVS, *["Coefficient"] * 15, *TAIL]),
        (3, 3, 5, [*HEAD, *ADEVS, *["Coefficient"] * 5, *TAIL]),
        (4, 15, 0, ["ResultFd", *REST, *TAIL]),
        (7, 16, 1, [*HEAD, *MONITOR, *TAIL]),
        (8, 24, 0, ["ResultFd", *REST, *MONITOR, *TAIL]),
        # law glr reports its changes
        (9, 0, 8, [*HEAD, "Change", *TAIL]),
        (10, 3, 34, [*HEAD, *["Change"] * 4, *ADEVS, *["Coefficient"] * 5, *TAIL]),
        (11, 8, 9, ["ResultFd", *["Change"] * 4, *REST, *TAIL]),
        (12, 0, 0, [*HEAD, *FLOOR, *TAIL]),
        (13, 24, 9, ["ResultFd", *["Change"] * 4, *REST, *MONITOR, *FLOOR, *TAIL]),
    ],
)
@pytest.mark.parametrize("count", [60, pytest.param(300, marks=pytest.mark.slow)])
def test_every_frame_has_the_values_of_its_result(seed, content, channel, names, count):
    numbers, state = {}, None
    floor = ["floor"] if "Floor" in names else []
    for values, frames in results(seed, count, content, channel, *floor):
        seen = []
        own = [(one, data) for one, data, _ in frames if (one - BASE) % STEP not in OF_NO_RESULT]
        digests = [fnv1a(one.to_bytes(2, "little") + data[1:]) for one, data in own]
        values["E"] = (len(own), sum(digests) % 2**32)
        for identifier, data, slcan in frames:
            message = dbc().get_message_by_frame_id(identifier - STEP * channel)
            signals = message.decode(data)
            name = message.name.removeprefix("DAVAR_")
            seen.append(name)
            crc = Crc8SaeJ1850.calc(identifier.to_bytes(2, "little") + data[1:])
            assert (message.length, signals["Crc"]) == (len(data), crc)
            assert signals["Counter"] == numbers.get(name, 0)
            numbers[name] = (signals["Counter"] + 1) % 16
            state = signals["Counter"] if name in ("State", "ResultFd") else state
            assert signals.get("Result", state) == state
            assert slcan in (None, f"t{identifier:03X}8{data.hex().upper()}")
            assert CHECKS[name](values, signals), (name, signals)
        assert seen == names
