"""Flies Betaflight's SITL on its virtual clock and reads its telemetry with yamspy (MSP) and
pymavlink (MAVLink), which nobody here wrote. Runs in a network of its own, because SITL listens on
every interface: unshare -rn python fly.py ...

    fly.py set PROGRAM FOLDER LINE...           types lines into the CLI and saves
    fly.py read PROGRAM FOLDER COUNTS PERIODS   prints JSON: {"msp": [[8 values], ...],
                                                "mavlink": [[seconds, name, value], ...]}

MSP_DEBUG is read after every PERIODS of the gyro; the clock waits for each request.
"""

import contextlib
import fcntl
import json
import os
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

SIOCGIFFLAGS, SIOCSIFFLAGS, IFF_UP = 0x8913, 0x8914, 1
MSP_PORT, MAVLINK_PORT = 5761, 5762
START_S, ANSWER_S = 60.0, 60.0  # real time after which something is broken
SAMPLE_BYTES = 6


def loopback_up() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        request = struct.pack("16sH14x", b"lo", 0)
        flags = struct.unpack("16sH14x", fcntl.ioctl(any_socket, SIOCGIFFLAGS, request))[1]
        fcntl.ioctl(any_socket, SIOCSIFFLAGS, struct.pack("16sH14x", b"lo", flags | IFF_UP))


@contextlib.contextmanager
def sitl(program: str, folder: str, **variables: str) -> Iterator[subprocess.Popen[bytes]]:
    with Path(folder, "sitl.log").open("wb") as log:
        process = subprocess.Popen(
            [program, "127.0.0.1"],
            cwd=folder,
            stdout=log,
            stderr=log,
            env={**os.environ, **variables},
        )
        try:
            yield process
        finally:
            process.kill()
            process.wait()


def listening(folder: str, port: int) -> None:
    deadline = time.monotonic() + START_S
    while f"bind port {port} " not in Path(folder, "sitl.log").read_text():
        assert time.monotonic() < deadline, f"SITL does not listen on port {port}"
        time.sleep(0.02)


def configure(program: str, folder: str, *lines: str) -> None:
    """Types `lines` into the CLI. `save` ends the program."""
    with sitl(program, folder) as process:
        listening(folder, MSP_PORT)
        cli = socket.create_connection(("127.0.0.1", MSP_PORT), ANSWER_S)
        for line in ["#", *lines]:
            cli.sendall(line.encode() + (b"" if line == "#" else b"\n"))
            answer = b""
            while not answer.endswith(b"\r\n# "):
                answer += cli.recv(4096)
            assert b"###ERROR" not in answer, answer.decode()
        cli.sendall(b"save\n")
        process.wait(ANSWER_S)


def read(program: str, folder: str, counts: str, periods: str) -> None:
    import serial
    from pymavlink import mavutil
    from yamspy import MSPy  # type: ignore[import-untyped]

    results: list[tuple[int, ...]] = []
    with sitl(program, folder, LOCKSTEP_COUNTS=counts, LOCKSTEP_PACE=periods):
        listening(folder, MAVLINK_PORT)
        ground = mavutil.mavlink_connection(f"tcp:127.0.0.1:{MAVLINK_PORT}")
        board = MSPy(device="tcp", loglevel="CRITICAL", logfilename=os.devnull)
        board.conn = serial.serial_for_url(
            f"socket://127.0.0.1:{MSP_PORT}", do_not_open=True, timeout=ANSWER_S
        )
        messages: list[Any] = []
        with contextlib.redirect_stdout(sys.stderr):
            assert board.connect(trials=1) == 0, "no MSP"
            for _ in range(Path(counts).stat().st_size // SAMPLE_BYTES // int(periods)):
                board.send_RAW_msg(MSPy.MSPCodes["MSP_DEBUG"], data=[])
                answer = board.receive_msg()
                assert not answer["crcError"], answer
                results.append(struct.unpack("<8h", bytes(answer["dataView"])))
                while message := ground.recv_match(type="NAMED_VALUE_FLOAT"):
                    messages.append(message)
    named = [(m.time_boot_ms / 1000, m.name, m.value) for m in messages]
    print(json.dumps({"msp": results, "mavlink": named}))


if __name__ == "__main__":
    loopback_up()
    verb = configure if sys.argv[1] == "set" else read
    verb(*sys.argv[2:])
