"""Frames from a CAN interface or a serial line, or pieces of a MAVLink stream from either or from
UDP, whatever becomes of interface or peer: a loss is counted and waited out."""

import contextlib
import errno
import fcntl
import os
import re
import socket
import struct
import termios
import time
from collections.abc import Callable, Iterator
from typing import Protocol

import can
import serial
from can.interfaces.socketcan import SocketcanBus

from ..errors import BadInput
from .frames import Faults

POLL_S = 0.05
BAUD = 115200
DATAGRAM_BYTES = 1 << 16
LINE_BYTES_MAX = 64  # of SLCAN text; what is longer is noise
RECEIVE_BYTES = 1 << 22  # room in the kernel for a burst
SIOCGIFFLAGS, IFF_UP = 0x8913, 1
SO_RCVBUFFORCE = 33  # beyond the usual limit; needs CAP_NET_ADMIN
FAILURES = (OSError, can.CanError, termios.error)
PLAIN = {
    errno.ENOTTY: "not a serial line",
    errno.ENODEV: "no such interface",
    errno.EAFNOSUPPORT: "this system has no CAN",
}
FRAME = re.compile(rb"t([0-7][0-9A-Fa-f]{2})([0-8])([0-9A-Fa-f]*)")

Frame = tuple[int, bytes]  # identifier, data; MAVLink: 0, a piece of the stream
Say = Callable[[str], None]  # receives a line for people


def reason(why: BaseException) -> str:
    """An exception in a few words: the system's, where there is one (pyserial hides it in its
    text)."""
    number = getattr(why, "errno", None) or getattr(why, "error_code", None)
    hidden = re.search(r"(?:Errno |\()(\d+)[],]", str(why))
    number = number or (int(hidden[1]) if hidden else None)
    if not number and isinstance(why, serial.SerialException):
        return "the device is gone"
    if number in PLAIN:
        return PLAIN[number]
    return os.strerror(number) if number else str(why) or type(why).__name__


class CanPort:
    """A SocketCAN interface, by python-can."""

    extended = False  # identifiers of 29 bits

    def __init__(self, name: str, faults: Faults) -> None:
        with socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as probe:
            answer = fcntl.ioctl(probe, SIOCGIFFLAGS, struct.pack("16sH14x", name.encode()[:15], 0))
        if not struct.unpack("16sH14x", answer)[1] & IFF_UP:
            raise OSError(100, "Network is down")
        self.bus, self.faults = can.Bus(interface="socketcan", channel=name, fd=True), faults
        assert isinstance(self.bus, SocketcanBus)
        with contextlib.suppress(OSError):
            self.bus.socket.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, RECEIVE_BYTES)

    def read(self) -> list[Frame]:
        """Frames (identifier, data) that came within POLL_S: none or one."""
        message = self.bus.recv(POLL_S)
        if (
            message is None
            or message.is_error_frame
            or message.is_remote_frame
            or message.is_extended_id != self.extended
        ):
            return []
        return [(message.arbitration_id, bytes(message.data))]

    def close(self) -> None:
        self.bus.shutdown()


class ExtendedPort(CanPort):
    """The same for DroneCAN."""

    extended = True


class CyphalPort(ExtendedPort):
    """IFACE or IFACE@SUBJECT; the receiver knows the subject."""

    def __init__(self, name: str, faults: Faults) -> None:
        super().__init__(name.partition("@")[0], faults)


class Line(serial.Serial):  # type: ignore[misc]  # pyserial ships no types
    """pyserial throws away, at the end of open(), what has come since its beginning; a sender on a
    pty has begun by then."""

    def _reset_input_buffer(self) -> None:
        pass


def opened_line(name: str) -> Line:
    """The tty of PATH or PATH@BAUD."""
    path, at, digits = name.rpartition("@")
    path, baud = (path, int(digits)) if at and digits.isdigit() else (name, BAUD)
    return Line(path, baud, timeout=POLL_S, write_timeout=1)


class MavlinkLine:
    """A tty with MAVLink, by pyserial."""

    def __init__(self, name: str, faults: Faults) -> None:
        self.port = opened_line(name)

    def read(self) -> list[Frame]:
        data = self.port.read(max(1, self.port.in_waiting))
        return [(0, data)] if data else []

    def close(self) -> None:
        self.port.close()


class UdpPort:
    """Datagrams that arrive at HOST:PORT of this computer."""

    def __init__(self, name: str, faults: Faults) -> None:
        host, _, port = name.rpartition(":")
        if not host or not port.isdecimal():
            raise ValueError("HOST:PORT expected")
        self.socket = socket.socket(
            socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_DGRAM
        )
        try:
            self.socket.settimeout(POLL_S)
            self.socket.bind((host.strip("[]"), int(port)))
        except BaseException:
            self.socket.close()
            raise

    def read(self) -> list[Frame]:
        try:
            return [(0, self.socket.recv(DATAGRAM_BYTES))]
        except TimeoutError:
            return []

    def close(self) -> None:
        self.socket.close()


class SerialPort:
    """A tty with SLCAN text, by pyserial. We are the host: O opens the adapter's channel."""

    def __init__(self, name: str, faults: Faults) -> None:
        self.port, self.faults, self.text = opened_line(name), faults, b""
        self.too_long = False  # is what comes the rest of a line that was given up
        self.port.write(b"\rO\r")

    def read(self) -> list[Frame]:
        """Frames (identifier, data) that came within POLL_S. Lines that are no frames are counted,
        but for the answers to O."""
        return self.taken(self.port.read(max(1, self.port.in_waiting)))

    def taken(self, text: bytes) -> list[Frame]:
        """The frames whose lines end in a further piece of text."""
        *lines, self.text = re.split(rb"[\r\a]", self.text + text)
        if lines and self.too_long:
            del lines[0]
            self.too_long = False
        if len(self.text) > LINE_BYTES_MAX:  # no end of line will make a frame of this
            self.faults.noise += not self.too_long
            self.too_long, self.text = True, b""
        return [frame for frame in map(self._frame, lines) if frame]

    def _frame(self, line: bytes) -> Frame | None:
        found = FRAME.fullmatch(line)
        length = int(found[2]) * 2 if found else 0
        if found and len(found[3]) in (length, length + 4):  # 4 more: a time stamp
            return int(found[1], 16), bytes.fromhex(found[3][:length].decode())
        self.faults.noise += bool(line)
        return None

    def close(self) -> None:
        self.port.close()


class Port(Protocol):
    """An open source."""

    def read(self) -> list[Frame]: ...
    def close(self) -> None: ...


PORTS: dict[str, Callable[[str, Faults], Port]] = {
    "can:": CanPort,
    "slcan:": SerialPort,
    "mavlink:udp:": UdpPort,
    "mavlink:serial:": MavlinkLine,
    "dronecan:": ExtendedPort,
    "cyphal:": CyphalPort,
}
FORMS = (
    "can:IFACE, slcan:PATH[@BAUD], mavlink:udp:HOST:PORT, mavlink:serial:PATH[@BAUD], "
    "dronecan:IFACE or cyphal:IFACE[@SUBJECT]"
)


class Source:
    """An open source. faults (wire.Faults) counts its noise, link_lost and link_restored; say:
    reports them in a line."""

    def __init__(self, name: str, faults: Faults, say: Say) -> None:
        self.kind = next((one for one in PORTS if name.startswith(one)), "")
        self.where = name.removeprefix(self.kind)
        if not self.kind or not self.where:
            raise BadInput(f"{FORMS} expected, found '{name}'")
        self.name, self.faults, self.say = name, faults, say
        self.port: Port | None = None
        try:
            self.port = self._open()
        except (*FAILURES, ValueError, OverflowError) as why:
            raise BadInput(f"{name}: {reason(why)}") from None

    def _open(self) -> Port:
        return PORTS[self.kind](self.where, self.faults)

    @property
    def may_come(self) -> bool:
        """May anything come any more: not of a pty that has been closed, whose name may be
        another's next time."""
        return self.port is not None or not self.where.startswith("/dev/pts/")

    def frames(
        self, idle_s: float | None = None, stopped: Callable[[], bool] = lambda: False
    ) -> Iterator[Frame]:
        """Yields (identifier, data) until nothing has come for idle_s seconds (None: for ever),
        nothing may come, or stopped() is true: that is asked every POLL_S."""
        heard = time.monotonic()
        while self.may_come and not stopped():
            for frame in self._read():
                heard = time.monotonic()
                yield frame
            if idle_s is not None and time.monotonic() - heard >= idle_s:
                return

    def _read(self) -> list[Frame]:
        try:
            if self.port:
                return self.port.read()
        except FAILURES as why:
            self.close()
            self.faults.link_lost += 1
            self.say(f"{self.name}: lost ({reason(why)})")
            return []
        time.sleep(POLL_S)
        with contextlib.suppress(*FAILURES):
            self.port = self._open()
            self.faults.link_restored += 1
            self.say(f"{self.name}: reconnected")
        return []

    def close(self) -> None:
        """A port that is gone may fail to close."""
        with contextlib.suppress(*FAILURES):
            if self.port:
                self.port.close()
        self.port = None
