"""The token of each port, in a folder that only its user can read: a server that is started again
on a port takes it up, so that the tab of the one before it may come back."""

import contextlib
import hmac
import os
import re
import secrets
import stat
from pathlib import Path

from ... import files
from ...errors import BadInput

FORM = re.compile(rb"[A-Za-z0-9_-]{22}")
KEPT = 16  # files


def folder() -> Path:
    """Where they are kept. Raises OSError and RuntimeError where it cannot be made, or somebody
    else may read it."""
    state = os.environ.get("XDG_STATE_HOME", "")
    base = Path(state) if os.path.isabs(state) else Path.home() / ".local/state"
    made = base / "davarlab"
    made.mkdir(mode=0o700, parents=True, exist_ok=True)
    found = os.lstat(made)
    mine = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid()
    if not mine or stat.S_IMODE(found.st_mode) & 0o077:
        raise PermissionError(str(made))
    return made


def of_port(port: int) -> str:
    """The token of this port, a new one where none was kept. Where none can be kept, a tab cannot
    come back."""
    token = secrets.token_urlsafe(16)
    with contextlib.suppress(OSError, RuntimeError, BadInput):
        path = folder() / f"{port}.token"
        kept = files.read_whole(path) if path.is_file() else b""
        if FORM.fullmatch(kept):
            os.utime(path)  # the oldest are deleted
            return kept.decode()
        files.write_whole(path, token.encode(), follow=False)
        for old in sorted(path.parent.glob("*.token"), key=os.path.getmtime)[:-KEPT]:
            old.unlink(missing_ok=True)
    return token


def proof(token: str, nonce: str) -> str:
    """Shows a tab that this server has its token, before the tab sends it: another program may
    have taken the port."""
    return hmac.new(token.encode(), nonce.encode(), "sha256").hexdigest()
