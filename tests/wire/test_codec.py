"""The C codec compared with tools/davar.dbc, read by cantools: random values, every message, both
directions.
"""

import math
import random
import struct
import subprocess

import pytest
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


def crc8(data, crc=0xFF):
    """CRC-8/SAE-J1850, bit by bit by its definition: polynomial 0x1D, start and final xor 0xFF."""
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = ((crc << 1) ^ 0x1D) & 0xFF if crc & 0x80 else crc << 1
    return crc ^ 0xFF


def crc_of(identifier, data):
    return crc8(identifier.to_bytes(2, "little") + bytes(data[1:]))


def fnv1a(data):
    """FNV-1a of 32 bits from its definition: start 2166136261, factor 16777619."""
    value = 2166136261
    for byte in data:
        value = (value ^ byte) * 16777619 % 2**32
    return value


def test_the_check_values_are_the_published_ones():
    assert crc8(b"123456789") == 0x4B
    assert [fnv1a(data) for data in (b"", b"a", b"foobar")] == [0x811C9DC5, 0xE40C292C, 0xBF9CF968]


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


# --- the encoder: what the frames of a result must have, of its values


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
}


def results(seed, count, content, channel=0):
    """Yields (values, frames) of random results; frames are (identifier, data)."""
    values, frames = None, []
    for line in [*probe("encode", seed, count, content, channel), "R end"]:
        kind, *word = line.split()
        if kind == "R":
            if values:
                yield values, frames
            values, frames = {"R": word, "T": [], "C": [], "H": []}, []
        elif kind == "F":
            slcan = word[2] if len(word) > 2 else None
            frames.append((int(word[0], 16), bytes.fromhex(word[1]), slcan))
        elif kind in "MG":
            values[kind] = [float(number) for number in word]
        elif kind == "H":
            values["H"].append(int(word[1]))
        else:
            values[kind].append([float(number) for number in word[1:]])


HEAD, TAIL = ["State", "Stationarity", "Arw"], ["Health", "Setup", "End"]
ADEVS, REST = ["Adev"] * TAUS, ["Adev"] * (TAUS - 8)
MONITOR = ["Monitor"] * (TAUS + 1)


@pytest.mark.parametrize(
    ("seed", "content", "channel", "names"),
    [
        (1, 0, 3, [*HEAD, *TAIL]),
        (2, 7, 0, [*HEAD, *ADEVS, *["Coefficient"] * 15, *TAIL]),
        (3, 3, 5, [*HEAD, *ADEVS, *["Coefficient"] * 5, *TAIL]),
        (4, 15, 0, ["ResultFd", *REST, *TAIL]),
        (7, 16, 1, [*HEAD, *MONITOR, *TAIL]),
        (8, 24, 0, ["ResultFd", *REST, *MONITOR, *TAIL]),
        # policy glr reports its changes
        (9, 0, 8, [*HEAD, "Change", *TAIL]),
        (10, 3, 34, [*HEAD, *["Change"] * 4, *ADEVS, *["Coefficient"] * 5, *TAIL]),
        (11, 8, 9, ["ResultFd", *["Change"] * 4, *REST, *TAIL]),
    ],
)
@pytest.mark.parametrize("count", [60, pytest.param(300, marks=pytest.mark.slow)])
def test_every_frame_has_the_values_of_its_result(seed, content, channel, names, count):
    numbers, state = {}, None
    for values, frames in results(seed, count, content, channel):
        seen = []
        own = [(one, data) for one, data, _ in frames if (one - BASE) % STEP not in OF_NO_RESULT]
        digests = [fnv1a(one.to_bytes(2, "little") + data[1:]) for one, data in own]
        values["E"] = (len(own), sum(digests) % 2**32)
        for identifier, data, slcan in frames:
            message = dbc().get_message_by_frame_id(identifier - STEP * channel)
            signals = message.decode(data)
            name = message.name.removeprefix("DAVAR_")
            seen.append(name)
            assert (message.length, signals["Crc"]) == (len(data), crc_of(identifier, data))
            assert signals["Counter"] == numbers.get(name, 0)
            numbers[name] = (signals["Counter"] + 1) % 16
            state = signals["Counter"] if name in ("State", "ResultFd") else state
            assert signals.get("Result", state) == state
            assert slcan in (None, f"t{identifier:03X}8{data.hex().upper()}")
            assert CHECKS[name](values, signals), (name, signals)
        assert seen == names


def test_a_channel_beyond_the_standard_identifiers_is_rejected():
    with pytest.raises(subprocess.CalledProcessError):
        probe("encode", 1, 1, 0, 35)


# --- the decoder


def possible(message, signals):
    """True if a sender may send these values, by lib/WIRE.md, "Invalid values"."""
    counts = ("WindowSamples", "Stride", "ClusterSamples", "RateHz", "UnitPerCount", "Frames")
    if any(name in counts and not value > 0 for name, value in signals.items()):
        return False
    for name, value in signals.items():
        if message.get_signal_by_name(name).is_float and not ("High" in name and value == math.inf):
            size = abs(value) if name in ("ModelDeviation", "RateDps") else value
            if not (math.isnan(size) or size == 0 or 1e-30 <= size <= 1e30):
                return False
    return True


# Places in a line of wire_probe decode: D message channel counter result index value number window
# unstable relative kurtosis contribution ...
SCALED = {"ArwRelativeUncertainty": 10, "AdevRelativeUncertainty": 10, "Kurtosis": 11}
SCALED |= {"Contribution": 12, "Dispersion": 34}
AT_INDEX = (
    "TauIndex",
    "Kind",
    "HealthIndex",
    "Item",
    "MonitorIndex",
    "Form",
    "ChangeItem",
    "Frames",
)
WHOLE = {
    **dict.fromkeys((*AT_INDEX, "Frames"), 5),
    **dict.fromkeys(("Epoch", "Stride", "ClusterSamples", "Index", "Digest"), 7),
    **{"WindowSamples": 8, "Unstable": 9, "WorstTau": 26, "Session": 27, "Count": 28, "Count0": 28},
    **{"Count1": 29, "Alarm": 30, "Young": 31, "ChangeClusterSamples": 32, "CutAge": 33},
}


def is_decoded(message, name, value, word):
    signal = message.get_signal_by_name(name)
    if name in SCALED:
        found = float(word[SCALED[name]])
        if round(value / float(signal.scale)) == 2**signal.length - 1:
            return math.isnan(found)
        return abs(found - value) <= 1e-6 * abs(value)
    if name in WHOLE:
        return value == int(word[WHOLE[name]])
    if message.name == "DAVAR_ResultFd" and name in COEFFICIENTS:
        return is_float(value, float(word[13 + COEFFICIENTS.index(name)]))
    if name.startswith("Adev") and name != "AdevDps":
        return is_float(value, float(word[18 + int(name[4])]))
    if signal.is_float:
        return is_float(value, float(word[6]))
    if message.name == "DAVAR_Health" and name not in ("Crc", "Counter", "Result"):
        return value == int(word[7])
    return True


def random_frame(source):
    """(message, channel, data) with valid multiplexers, half of them with float32 near 1."""
    message = source.choice(dbc().messages)
    raw = bytearray(source.randbytes(message.length))
    if source.random() < 0.5:
        for at in range(7, message.length, 4):
            raw[at], raw[at - 1] = 0x3F, raw[at - 1] & 0x7F | 0x40
    selectors = {
        "DAVAR_Setup": (0, 1, 2, 32, 40),
        "DAVAR_Monitor": range(33),
        "DAVAR_Coefficient": range(15),
        "DAVAR_Health": range(15),
    }
    raw[2] = source.choice(selectors.get(message.name, (raw[2],)))
    if message.name == "DAVAR_Raw":
        raw[1] = raw[1] & 0xCF | source.randrange(3) << 4
    channel = source.randrange(35)
    raw[0] = crc_of(message.frame_id + STEP * channel, raw)
    return message, channel, bytes(raw)


def decoded(frames):
    """The answers of the device's decoder, in words."""
    lines = "".join(f"{identifier:03X}#{data.hex()}\n" for identifier, data in frames)
    return [line.split() for line in probe("decode", stdin=lines)]


@pytest.mark.parametrize("count", [2000, pytest.param(6000, marks=pytest.mark.slow)])
def test_cantools_encodes_what_the_device_decodes(count):
    source = random.Random(5)
    frames = [random_frame(source) for _ in range(count)]
    answers = decoded(
        (message.frame_id + STEP * channel, data) for message, channel, data in frames
    )
    good = 0
    for (message, channel, data), word in zip(frames, answers, strict=True):
        signals = message.decode(data, decode_choices=False)
        if not possible(message, signals):
            assert word == ["E", "4"], signals
            continue
        good += 1
        head = ["D", message.frame_id - BASE, channel, signals["Counter"]]
        assert word[:4] == list(map(str, head))
        for name, value in signals.items():
            assert is_decoded(message, name, value, word), (name, value, word)
    assert good > count / 6


@pytest.mark.parametrize("name", ["DAVAR_Arw", "DAVAR_ResultFd"])
def test_a_reason_is_decoded_only_where_arw_is_absent(name):
    message = dbc().get_message_by_name(name)
    top = 2 ** message.get_signal_by_name("ArwRelativeUncertainty").length - 1
    zeros = {signal.name: 0 for signal in message.signals}
    zeros |= {"WindowSamples": 600} if "WindowSamples" in zeros else {}
    cases = [(arw, code) for arw in (math.nan, 0.3) for code in (*range(9), top)]
    frames = []
    for arw, code in cases:
        signals = zeros | {"ArwDegPerSqrtH": arw, "ArwRelativeUncertainty": top - code}
        data = message.encode(signals, scaling=False)
        frames.append((message.frame_id, bytes([crc_of(message.frame_id, data)]) + data[1:]))
    for (arw, code), word in zip(cases, decoded(frames), strict=True):
        reason = code if code < len(REASONS) and math.isnan(arw) else 0
        assert (word[0], int(word[35])) == ("D", reason)
        assert math.isnan(float(word[10])) == (code == 0 or reason > 0)


def test_damaged_and_foreign_frames_are_reported():
    identifier, data, _ = next(results(6, 1, 0))[1][0]

    def unknown(kind, *head):
        """A frame with the right Crc and an index that does not exist."""
        body = bytes([0, *head]) + bytes(7 - len(head))
        return kind, bytes([crc_of(kind, body)]) + body[1:]

    cases = [
        ((identifier, data), ["D", "1"]),
        ((identifier, bytes([data[0] ^ 1]) + data[1:]), ["E", "3"]),
        ((0x5CF, data), ["E", "1"]),
        ((0x5DC, data), ["E", "1"]),
        ((0x5D1, data[:7]), ["E", "2"]),
        (unknown(0x5D5, 0, 99), ["E", "4"]),  # HealthIndex
        (unknown(0x5D7, 0, 33), ["E", "4"]),  # MonitorIndex
        (unknown(0x5D9, 0x30), ["E", "4"]),  # Form
    ]
    answers = decoded(frame for frame, _ in cases)
    assert [word[:2] for word in answers] == [expected for _, expected in cases]
