"""Bad options: exit status 2, one line with the name of the option, nothing on standard output."""

import pytest
from sim_case import assert_refused, recording, results, sim, write

MANY = ",".join(str(m) for m in range(1, 34))
# Values, separated by spaces; '' is the empty one. Their option is named.
REFUSED = {
    "--window-max": "0 2 601 -4 abc '' 600.0 6e2 99999999999 4294967296 4294967294",
    "--window-min": "0 602 401 x 18446744073709551617",
    "--segment": "0 400 500 -1 1.5",
    "--stride": "0 16777217 -1 x 4294967296",
    "--engine": "'' grids 0",
    "--grow": "1 3 600 x",
    "--shrink": "1 3 600 x",
    "--kurtosis": "3.3:2.5 2.5 2.5: :3.3 -1:3 nan:3 2:inf a:b 2.5:3.3:4 2.5,3.3",
    "--unstable-rate": "0 -0.01 0.00009 0.11 1 1% x '' nan",
    "--contribution": "1:0 -1:0 0 0:x 0:1e999",
    "--taus": "0 0,1 1,301 301 2,1 1,1 1,,2 1,2, ,1 a 1,b -1 1,99999999999 fourier geometric: "
    f"geometric:0 geometric:33 geometric:x geometrical octaves {MANY}",
    "--longest-tau": "'' x 0 -5 nan inf 1h",
    "--rate": "0 -100 nan inf x '' 1e999 100Hz 1e51",
    "--lsb": "0 -0.05 nan x 1e-999 1e999 1e51 1e-51",
    "--gap": "0 1 0.5 -2 x",
    "--bits": "0 8 17 33 x",
    "--law": "none OR '' kurtosi",
    "--mode": "center '' Trailing",
    "--arith": "double '' q15",
    "--bandwidth": "'' x -1 0 10:3 10:2:x 10:2:-1 10:2:50.1 10:2: average:0 cic9:4",
    "--out": "xml '' CSV can: can:vcan0 slcan:/dev/ttyACM0",
    "--can-base": "'' 0x x 7F1 5D0h -1",
    "--can-content": "'' all",
    "--baud": "fast -1 4294967296",
    "--pace": "0 -1 x '' nan inf fast",
    "--block": "x -1",
    "--shock-blocks": "x -1",
    "--false-alarms-per-hour": "0 x",
    "--cut-interval": "x",
    "--progress": "yes ''",
    "--column": "'' , gyro_x_dps, gyro_x_dps,gyro_x_dps gyro_z_dps",
    "--model-table": "'' /nonexistent.csv",
    "--device": "''",
}
FLOAT = "--arith float"
OF_GLR = (
    *("block 4", "block 65", "shock-blocks 3", "window-max 7690", "block 5 --window-max 30"),
    *("cut-interval 1e10", "cut-interval 1e-10"),
    *("false-alarms-per-hour 1e10", "false-alarms-per-hour 1e-10"),
)
# Words after the recording REC, and what the line contains.
TOGETHER = [
    *((f"{FLOAT} --full-scale {value}", "--full-scale") for value in ("0", "-1", "x", "1e30")),
    ("--window-max 600 --window-min +400", "--window-min"),
    ("--window-max 100 --window-min 200", "--window-min"),
    ("--window-max 100 --segment 80", "--segment"),
    ("--window-max 100 --taus 1,51", "--taus"),
    ("--window-max 300 --stride 301", "--stride never"),
    ("--unstable-rate 0.01 --kurtosis 2:4", "--unstable-rate either it or"),
    ("--unstable-rate 0.01 --contribution 0:1", "--unstable-rate either it or"),
    ("--unstable-rate 0.01 --law glr", "--unstable-rate --false-alarms-per-hour"),
    ("--lsb 0.01 --longest-tau 1.27", "--longest-tau 1.28 100 Hz|64 samples|found 1.27"),
    ("--lsb 0.01 --longest-tau 21475000", "--longest-tau 21474836.5"),  # 2^31 samples
    ("--lsb 0.01 --longest-tau 1e300", "--longest-tau 21474836.5"),
    ("--lsb 1e-6 --bits 32 --longest-tau 1e7", "--longest-tau 2684354.56"),
    ("--arith float --longest-tau 1e7", "--longest-tau 5368709.12"),
    (f"--longest-tau 10 --taus {MANY[:-3]}", "--longest-tau 31 32"),
    (f"--longest-tau 2.5 --taus {MANY[:-6]}", "--longest-tau 2.48"),
    *((f"--law glr --{more}", "--law glr|block, shock, window, stride or rate") for more in OF_GLR),
    ("--law glr --mode centred", "--mode centred: not for --law glr"),
    ("--bandwidth 0.01", "--bandwidth 0.01"),
    ("--pace 100 --device true", "--pace --device"),
    ("--raw --device true", "--raw --device"),
    *(
        (f"{option} {out}", f"{option.split()[0]} --out can:IFACE")
        for option in ("--can-base 5D0", "--can-content fd", "--raw")
        for out in ("", "--out jsonl", "--out mavlink:udp:127.0.0.1:9")
    ),
    ("--can-base 7F0 --out slcan:pty --column gyro_x_dps temp_degC", "--can-base 7F0"),
    *(
        (f"{words} --skip-torn-reads", "--skip-torn-reads --lsb")
        for words in ("", FLOAT, FLOAT + " --lsb 0.01")
    ),
    ("--skip-torn-reads=1", "--skip-torn-reads value"),
    ("--details=yes", "--details value"),
    ("--rate", "--rate value"),
    ("--long-cluster 80", "--long-cluster removed --longest-tau"),
    ("--windowmax 600", "--windowmax"),
    ("--window 600", "--window"),
    ("-q", "-q"),
    ("REC", "unexpected argument"),
    ("--column gyro_x_dps --rate 100 gyro_y_dps", "unexpected argument|'gyro_y_dps'"),
]


def words_of(text):
    return ["" if word == "''" else word for word in text.split()]


@pytest.fixture
def path(tmp_path):
    rows = "".join(f"{i / 100},{i * 7 % 11 / 8},20\n" for i in range(300))
    return write(tmp_path / "rec.csv", "time_s,gyro_x_dps,temp_degC\n" + rows)


@pytest.mark.parametrize("option", REFUSED)
def test_a_bad_value_is_rejected_and_its_option_named(path, option):
    for value in words_of(REFUSED[option]):
        named = value if value.endswith(".csv") else option
        assert_refused(sim(path, option, value, "--progress", "never"), named)


@pytest.mark.parametrize(("words", "wanted"), TOGETHER)
def test_what_does_not_fit_together_is_rejected(path, words, wanted):
    given = [path if word == "REC" else word for word in words_of(words)]
    assert_refused(sim(path, *given), *wanted.replace("|", " ").split(" "))


def test_options_are_checked_before_the_recording(tmp_path):
    assert_refused(sim(tmp_path / "nothing.csv", "--window-max", "0"), "--window-max")
    assert_refused(sim("--frobnicate"), "--frobnicate")
    for words in ((), ("--rate", "5")):
        assert_refused(sim(*words), "no recording")
    assert_refused(sim("no\nsuch\rfile"), "no?such?file")


def test_values_at_the_limit_are_accepted(tmp_path):
    path = recording(tmp_path, count=700)
    trailing = "--mode trailing --window-max 601 --window-min 401 --stride 100"
    assert len(results(path, *trailing.split())) == 3
    rows = results(path, "--window-max", "300", "--stride", "300")
    assert [row["epoch"] for row in rows] == ["299", "599"]
    most = ",".join(str(m) for m in range(1, 32))
    rows = results(path, "--longest-tau", 2, "--taus", most, "--stride", 600)
    assert list(rows[0])[-1] == "adev_124"


def test_the_version_needs_no_recording():
    version = sim("--version")
    assert (version.returncode, version.stderr) == (0, "")
    assert version.stdout.startswith("davar-sim ")
