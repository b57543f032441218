"""The C codec compared with tools/davar.dbc, read by cantools: random values, every message, both
directions.
"""

import math
import os
import random
import struct
import subprocess
import unittest
from pathlib import Path

import cantools

ROOT = Path(__file__).resolve().parents[2]
PROBE = os.environ.get("DAVAR_WIRE_PROBE", "wire_probe")
DBC = cantools.database.load_file(ROOT / "tools/davar.dbc", strict=True)
BASE, STEP = 0x5D0, 16
SESSION, TAUS = 165, 32  # of wire_probe
OF_NO_RESULT = (5, 6, 9, 11)  # Health, Setup, Raw, and End itself
# By davar_noise_t: the name of the uncertainty of an absent ARW.
REASONS = ("absent", "beyond", "mixed", "constant", "coarse", "filtered")
COEFFICIENTS = (
    "QuantizationDeg",
    "ArwDegPerSqrtH",
    "BiasInstabilityDegPerH",
    "RateRandomWalkDegPerHPerSqrtH",
    "RateRampDegPerH2",
)


def crc8(data, crc=0xFF):
    """CRC-8/SAE-J1850, bit by bit by its definition: polynomial 0x1D, start and final xor 0xFF."""
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = ((crc << 1) ^ 0x1D) & 0xFF if crc & 0x80 else crc << 1
    return crc ^ 0xFF


def fnv1a(data):
    """FNV-1a of 32 bits from its definition: start 2166136261, factor 16777619."""
    value = 2166136261
    for byte in data:
        value = (value ^ byte) * 16777619 % 2**32
    return value


def single(value):
    """The nearest float32, as a double."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


def probe(*arguments, stdin=None):
    done = subprocess.run(
        [PROBE, *map(str, arguments)], input=stdin, text=True, stdout=subprocess.PIPE, check=True
    )
    return done.stdout.splitlines()


def results(seed, count, content, channel=0):
    """Yields (values, frames) of random results; frames are (identifier, data)."""
    values, frames = None, []
    for line in [*probe("encode", seed, count, content, channel), "R end"]:
        word = line.split()
        if word[0] == "R":
            if values:
                yield values, frames
            values, frames = {"R": word[1:], "T": [], "C": [], "H": []}, []
        elif word[0] == "F":
            frames.append(
                (int(word[1], 16), bytes.fromhex(word[2]), word[3] if len(word) > 3 else None)
            )
        elif word[0] in "MG":
            values[word[0]] = [float(number) for number in word[1:]]
        elif word[0] == "H":
            values["H"].append(int(word[2]))
        else:
            values[word[0]].append([float(number) for number in word[2:]])


def possible(message, signals):
    """True if a sender may send these values, by lib/WIRE.md, "Invalid values"."""

    def magnitude(value):
        return math.isnan(value) or value == 0 or 1e-30 <= value <= 1e30

    for name, value in signals.items():
        signal = message.get_signal_by_name(name)
        if (
            name
            in ("WindowSamples", "Stride", "ClusterSamples", "RateHz", "UnitPerCount", "Frames")
            and not value > 0
        ):
            return False
        unlimited = "High" in name and value == math.inf
        if (
            signal.is_float
            and not unlimited
            and not magnitude(abs(value) if name in ("ModelDeviation", "RateDps") else value)
        ):
            return False
    return True


def relative(value, low, high):
    return (
        0.5 * (high - low) / value
        if value and not math.isnan(value)
        else (math.inf if value == 0 and high > low else math.nan)
    )


class Codec(unittest.TestCase):
    def assert_float(self, expected, found):
        same = expected != expected and found != found or single(expected) == single(found)
        self.assertTrue(same, f"expected {expected!r}, found {found!r}")

    def assert_scaled(self, expected, found, unit, bits):
        if math.isnan(expected):
            self.assertEqual("absent", found)
        elif expected >= (2**bits - 2.5) * unit:  # rounded, all ones except the last bit
            self.assertEqual("beyond", found)
        else:
            self.assertLessEqual(abs(expected - found), 0.5000001 * unit)

    def assert_arw(self, values, signals, unit, bits):
        found = signals["ArwRelativeUncertainty"]
        self.assert_float(values["C"][1][0], signals["ArwDegPerSqrtH"])
        if math.isnan(values["C"][1][0]):
            self.assertEqual(REASONS[int(values["R"][5])], found)
        elif relative(*values["C"][1]) > (2**bits - 9) * unit:  # the higher raw values are named
            self.assertEqual("beyond", found)
        else:
            self.assert_scaled(relative(*values["C"][1]), found, unit, bits)

    def check_arw(self, values, signals):
        self.assert_arw(values, signals, 1e-4, 16)

    def check_state(self, values, signals):
        epoch, window, unstable = map(int, values["R"][:3])
        self.assertEqual(epoch % 2**32, signals["Epoch"])
        self.assertEqual(min(window, 2**19 - 1), signals["WindowSamples"])
        self.assertEqual(unstable, signals["Unstable"])

    def check_stationarity(self, values, signals):
        self.assert_scaled(float(values["R"][3]), signals["Kurtosis"], 1e-3, 24)
        self.assert_scaled(float(values["R"][4]), signals["Contribution"], 1e-5, 24)

    def check_change(self, values, signals):
        alarm, young, m, age, dispersion, *told = values["G"]
        self.assertEqual(
            (alarm, young, m),
            tuple(signals[name] for name in ("Alarm", "Young", "ChangeClusterSamples")),
        )
        if signals["ChangeItem"] == 0:
            self.assertEqual(min(age, 2**20 - 1), signals["CutAge"])
            self.assert_scaled(dispersion, signals["Dispersion"], 0.01, 12)
        else:
            name = ("ChangeOlderDps", "ChangeNewerDps", "ChangeGain")[signals["ChangeItem"] - 1]
            self.assert_float(told[signals["ChangeItem"] - 1], signals[name])

    def check_adev(self, values, signals):
        tau = values["T"][signals["TauIndex"]]
        self.assert_float(tau[0], signals["AdevDps"])
        self.assert_scaled(relative(*tau), signals["AdevRelativeUncertainty"], 1e-3, 11)

    def check_coefficient(self, values, signals):
        name = str(signals["Kind"])
        kind = signals["Kind"].value
        self.assert_float(values["C"][kind % 5][kind // 5], signals[name])

    def check_health(self, values, signals):
        self.assertEqual(SESSION, signals["Session"])
        self.assertEqual(
            values["H"][signals["HealthIndex"].value], signals[str(signals["HealthIndex"])]
        )

    def check_monitor(self, values, signals):
        health, worst, *deviations = values["M"]
        if signals["MonitorIndex"] == 32:
            self.assert_float(health, signals["ModelHealth"])
            self.assertEqual("absent" if worst == TAUS else worst, signals["WorstTau"])
        else:
            self.assert_float(deviations[signals["MonitorIndex"]], signals["ModelDeviation"])

    def check_end(self, values, signals):
        self.assertEqual(
            (SESSION, *values["E"]), (signals["Session"], signals["Frames"], signals["Digest"])
        )

    def check_setup(self, values, signals):
        self.assertEqual(SESSION, signals["Session"])
        if signals["Item"] == 0:
            self.assertEqual(single(99.3), signals["RateHz"])
        elif signals["Item"] == 1:
            self.assertEqual(4000000000, signals["Stride"])
        else:
            index = signals["Item"] - 32
            self.assertEqual(2**index if index < TAUS - 1 else 2**32 - 1, signals["ClusterSamples"])

    def check_resultfd(self, values, signals):
        self.assertEqual(int(values["R"][0]) % 2**24, signals["Epoch"])
        self.assertEqual(min(int(values["R"][1]), 2**19 - 1), signals["WindowSamples"])
        self.assertEqual(int(values["R"][2]), signals["Unstable"])
        self.assert_scaled(float(values["R"][3]), signals["Kurtosis"], 1e-3, 16)
        self.assert_scaled(float(values["R"][4]), signals["Contribution"], 1e-3, 12)
        self.assert_arw(values, signals, 1e-3, 12)
        for name, coefficient in zip(COEFFICIENTS, values["C"]):
            self.assert_float(coefficient[0], signals[name])
        for index in range(8):
            self.assert_float(values["T"][index][0], signals[f"Adev{index}Dps"])

    def check(self, seed, content, names, channel=0, count=300):
        counters, state = {}, None
        for values, frames in results(seed, count, content, channel):
            seen = []
            own = [
                (one, data) for one, data, _ in frames if (one - BASE) % STEP not in OF_NO_RESULT
            ]
            values["E"] = (
                len(own),
                sum(fnv1a(one.to_bytes(2, "little") + data[1:]) for one, data in own) % 2**32,
            )
            for identifier, data, slcan in frames:
                message = DBC.get_message_by_frame_id(identifier - STEP * channel)
                signals = message.decode(data)
                short = message.name.removeprefix("DAVAR_")
                seen.append(short)
                self.assertEqual(message.length, len(data))
                self.assertEqual(crc8(identifier.to_bytes(2, "little") + data[1:]), signals["Crc"])
                self.assertEqual(counters.get(short, 0), signals["Counter"])
                counters[short] = (signals["Counter"] + 1) % 16
                state = signals["Counter"] if short in ("State", "ResultFd") else state
                self.assertEqual(state, signals.get("Result", state))
                if slcan:
                    self.assertEqual(f"t{identifier:03X}8{data.hex().upper()}", slcan)
                getattr(self, "check_" + short.lower())(values, signals)
            self.assertEqual(names, seen)

    def test_the_check_value_of_the_crc_is_the_published_one(self):
        self.assertEqual(0x4B, crc8(b"123456789"))

    def test_the_check_values_of_the_digest_are_the_published_ones(self):
        self.assertEqual(
            (0x811C9DC5, 0xE40C292C, 0xBF9CF968), tuple(map(fnv1a, (b"", b"a", b"foobar")))
        )

    def test_a_summary_is_six_frames(self):
        self.check(1, 0, ["State", "Stationarity", "Arw", "Health", "Setup", "End"], channel=3)

    def test_everything_in_classical_frames(self):
        self.check(
            2,
            7,
            ["State", "Stationarity", "Arw"]
            + ["Adev"] * TAUS
            + ["Coefficient"] * 15
            + ["Health", "Setup", "End"],
        )

    def test_the_default_content(self):
        self.check(
            3,
            3,
            ["State", "Stationarity", "Arw"]
            + ["Adev"] * TAUS
            + ["Coefficient"] * 5
            + ["Health", "Setup", "End"],
            channel=5,
        )

    def test_policy_glr_reports_its_changes(self):
        self.check(
            9, 0, ["State", "Stationarity", "Arw", "Change", "Health", "Setup", "End"], channel=8
        )
        self.check(
            10,
            3,
            ["State", "Stationarity", "Arw"]
            + ["Change"] * 4
            + ["Adev"] * TAUS
            + ["Coefficient"] * 5
            + ["Health", "Setup", "End"],
            channel=34,
        )
        self.check(
            11,
            8,
            ["ResultFd"] + ["Change"] * 4 + ["Adev"] * (TAUS - 8) + ["Health", "Setup", "End"],
            channel=9,
        )

    def test_the_monitor_adds_a_frame_per_tau_and_one_for_health(self):
        self.check(
            7,
            16,
            ["State", "Stationarity", "Arw"]
            + ["Monitor"] * (TAUS + 1)
            + ["Health", "Setup", "End"],
            channel=1,
        )
        self.check(
            8,
            24,
            ["ResultFd"]
            + ["Adev"] * (TAUS - 8)
            + ["Monitor"] * (TAUS + 1)
            + ["Health", "Setup", "End"],
        )

    def test_a_result_in_one_fd_frame(self):
        self.check(4, 15, ["ResultFd"] + ["Adev"] * (TAUS - 8) + ["Health", "Setup", "End"])

    def test_a_channel_beyond_the_standard_identifiers_is_rejected(self):
        with self.assertRaises(subprocess.CalledProcessError):
            probe("encode", 1, 1, 0, 35)

    def test_cantools_encodes_what_the_device_decodes(self):
        source, lines, expected = random.Random(5), [], []
        for _ in range(6000):
            message = source.choice(DBC.messages)
            raw = bytearray(source.randbytes(message.length))
            if source.random() < 0.5:  # float32 numbers near 1
                for at in range(7, message.length, 4):
                    raw[at], raw[at - 1] = 0x3F, raw[at - 1] & 0x7F | 0x40
            raw[2] = (
                source.choice((0, 1, 2, 32, 40))
                if message.name == "DAVAR_Setup"
                else source.randrange(33)
                if message.name == "DAVAR_Monitor"
                else source.randrange(15)
                if message.name in ("DAVAR_Coefficient", "DAVAR_Health")
                else raw[2]
            )
            raw[1] = (
                raw[1] & 0xCF | source.randrange(3) << 4 if message.name == "DAVAR_Raw" else raw[1]
            )
            channel = source.randrange(35)
            identifier = message.frame_id + STEP * channel
            raw[0] = crc8(identifier.to_bytes(2, "little") + raw[1:])
            lines.append(f"{identifier:03X}#{raw.hex()}")
            expected.append((message, channel, message.decode(bytes(raw), decode_choices=False)))
        decoded = 0
        for (message, channel, signals), answer in zip(
            expected, probe("decode", stdin="\n".join(lines) + "\n")
        ):
            word = answer.split()
            if not possible(message, signals):
                self.assertEqual(["E", "4"], word, signals)
                continue
            decoded += 1
            self.assertEqual(
                ["D", str(message.frame_id - BASE), str(channel), str(signals["Counter"])], word[:4]
            )
            self.check_decoded(message, signals, word)

        self.assertGreater(decoded, 1000)

    def check_decoded(self, message, signals, word):
        scaled = {
            "ArwRelativeUncertainty": 10,
            "AdevRelativeUncertainty": 10,
            "Kurtosis": 11,
            "Contribution": 12,
            "Dispersion": 34,
        }
        whole = {
            "Epoch": 7,
            "Stride": 7,
            "ClusterSamples": 7,
            "WindowSamples": 8,
            "Unstable": 9,
            "TauIndex": 5,
            "Kind": 5,
            "HealthIndex": 5,
            "Item": 5,
            "MonitorIndex": 5,
            "WorstTau": 26,
            "Session": 27,
            "Form": 5,
            "Index": 7,
            "Count": 28,
            "Count0": 28,
            "Count1": 29,
            "ChangeItem": 5,
            "Alarm": 30,
            "Young": 31,
            "ChangeClusterSamples": 32,
            "CutAge": 33,
            "Frames": 5,
            "Digest": 7,
        }
        coefficient = {name: 13 + index for index, name in enumerate(COEFFICIENTS)}
        # word: D message channel counter result index value number window unstable relative
        # kurtosis contribution ...
        for name, value in signals.items():
            signal = message.get_signal_by_name(name)
            if name in scaled:
                found = float(word[scaled[name]])
                top = round(value / float(signal.scale)) == 2**signal.length - 1
                self.assertTrue(
                    math.isnan(found) if top else abs(found - value) <= 1e-6 * abs(value),
                    (name, word),
                )
            elif name in whole:
                self.assertEqual(value, int(word[whole[name]]), name)
            elif message.name == "DAVAR_ResultFd" and name in coefficient:
                self.assert_float(value, float(word[coefficient[name]]))
            elif name.startswith("Adev") and name != "AdevDps":
                self.assert_float(value, float(word[18 + int(name[4])]))
            elif signal.is_float:
                self.assert_float(value, float(word[6]))
            elif message.name == "DAVAR_Health" and name not in ("Crc", "Counter", "Result"):
                self.assertEqual(value, int(word[7]), name)

    def test_a_reason_is_decoded_only_where_arw_is_absent(self):
        for name, others in (("DAVAR_Arw", {}), ("DAVAR_ResultFd", {"WindowSamples": 600})):
            message = DBC.get_message_by_name(name)
            top = 2 ** message.get_signal_by_name("ArwRelativeUncertainty").length - 1
            for arw in (math.nan, 0.3):
                for code in (*range(9), top):
                    signals = {signal.name: 0 for signal in message.signals} | others
                    raw = bytearray(
                        message.encode(
                            signals | {"ArwDegPerSqrtH": arw, "ArwRelativeUncertainty": top - code},
                            scaling=False,
                        )
                    )
                    raw[0] = crc8(message.frame_id.to_bytes(2, "little") + raw[1:])
                    word = probe("decode", stdin=f"{message.frame_id:03X}#{raw.hex()}\n")[0].split()
                    with self.subTest(message=name, arw=arw, code=code):
                        reason = code if code < len(REASONS) and math.isnan(arw) else 0
                        self.assertEqual(("D", reason), (word[0], int(word[35])))
                        self.assertEqual(code == 0 or reason > 0, math.isnan(float(word[10])))

    def test_damaged_and_foreign_frames_are_reported(self):
        identifier, data, _ = next(results(6, 1, 0))[1][0]
        good = f"{identifier:03X}#{data.hex()}"
        damaged = f"{identifier:03X}#{bytes([data[0] ^ 1]).hex()}{data[1:].hex()}"
        lines = [good, damaged, f"5CF#{data.hex()}", f"5DC#{data.hex()}", f"5D1#{data[:7].hex()}"]
        unknown = bytes([0, 99, 0, 0, 0, 0, 0])  # HealthIndex 99, with the right Crc
        lines.append(f"5D5#{crc8(bytes([0xD5, 5]) + unknown):02x}{unknown.hex()}")
        unknown = bytes([0, 33, 0, 0, 0, 0, 0])  # MonitorIndex 33
        lines.append(f"5D7#{crc8(bytes([0xD7, 5]) + unknown):02x}{unknown.hex()}")
        unknown = bytes([0x30, 0, 0, 0, 0, 0, 0])  # Form 3
        lines.append(f"5D9#{crc8(bytes([0xD9, 5]) + unknown):02x}{unknown.hex()}")
        answers = [line.split()[:2] for line in probe("decode", stdin="\n".join(lines) + "\n")]
        self.assertEqual(
            [
                ["D", "1"],
                ["E", "3"],
                ["E", "1"],
                ["E", "1"],
                ["E", "2"],
                ["E", "4"],
                ["E", "4"],
                ["E", "4"],
            ],
            answers,
        )


if __name__ == "__main__":
    unittest.main()
