"""What the first page offers: the last sessions, and the sensors that can be listened to."""

from collections.abc import Iterable
from pathlib import Path

from serial.tools import list_ports

from ... import files
from ...errors import BadInput
from ...report.values import Json
from .. import schema
from ..steps import ENDING

RECENT = 4  # sessions
LARGEST = 16 << 20  # bytes of a session file that is read for the list
NETWORK, CAN = Path("/sys/class/net"), b"280"  # the type of a CAN interface, ARPHRD_CAN


def recent(folders: Iterable[Path]) -> list[Json]:
    """The last sessions in these folders, the newest first: path of the recording, sensor or None,
    name, and error and floor of the current step, None where the recording permits no model."""
    paths = [path for folder in folders for path in folder.glob(f"*{ENDING}")]
    paths.sort(key=lambda path: path.stat().st_mtime, reverse=True)
    found = (session(path) for path in paths if path.stat().st_size < LARGEST)
    return [one for one, _ in zip(filter(None, found), range(RECENT))]


def session(path: Path) -> Json | None:
    """One of them; None for a file that is not a session, or has nothing to show."""
    try:
        data = schema.session(files.read_whole(path))
    except (BadInput, ValueError):
        return None
    tree, sensor = data.trees.get(data.selection), data.log.sensor if data.log else None
    step = tree.steps[tree.current] if tree and tree.current < len(tree.steps) else None
    recording = Path(str(path).removesuffix(ENDING))
    if sensor:  # its name stands between
        recording = recording.parent / recording.name.rsplit(".", 1)[0]
    if step is None or step.error is None or step.floor is None or not recording.is_file():
        return None
    name = recording.name + (f" {sensor}" if sensor else "")
    return {
        "path": str(recording),
        "sensor": sensor,
        "name": name,
        "error": None if step.rejected else step.error,
        "floor": None if step.rejected else step.floor,
    }


def sources() -> list[str]:
    """CAN interfaces and serial ports of this machine, as `listen` takes them."""
    interfaces = sorted(NETWORK.glob("*/type")) if NETWORK.is_dir() else []
    kinds = ((path.parent.name, files.read_whole(path).strip()) for path in interfaces)
    can = [f"can:{name}" for name, kind in kinds if kind == CAN]
    ports = [port.device for port in list_ports.comports() if port.vid is not None]
    return can + [f"slcan:{device}" for device in sorted(ports)]
