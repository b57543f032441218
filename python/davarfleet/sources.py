"""Where recordings are: paths, globs and addresses, through fsspec."""

import contextlib
import os
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path, PurePosixPath
from typing import Any

from davarlab.errors import BadInput, of_extra

Identity = list[list[int]] | dict[str, Any]  # plain values
GLOB = set("*?[")
TELLS = (
    "ETag",
    "etag",
    "Content-MD5",
    "Digest",
    "LastModified",
    "last_modified",
    "mtime",
    "created",
)  # what a store says of a file's content


def remote(address: str) -> bool:
    return "://" in address


def store_of(address: str) -> tuple[Any, str]:
    """(fsspec file system, path in it). Raises BadInput for a protocol that nobody serves."""
    with of_extra("fleet"):
        import fsspec  # a tenth of a second

    try:
        found: tuple[Any, str] = fsspec.core.url_to_fs(address)
        return found
    except (ValueError, ImportError) as why:
        raise BadInput(f"{address}: {why}") from None


def matches(pattern: str) -> list[str]:
    """The files that a glob names, sorted. Raises BadInput when it names none or fails."""
    store, path = store_of(pattern)
    try:
        found = sorted(store.glob(path))
    except Exception as why:  # of any store's library
        raise BadInput(f"{pattern}: {said(why)}") from None
    if not found:
        raise BadInput(f"{pattern}: no such file")
    return [
        store.unstrip_protocol(one)
        if remote(pattern)
        else os.path.relpath(one)
        if not os.path.isabs(pattern)
        else one
        for one in found
    ]


def expanded(patterns: Iterable[str]) -> list[str]:
    """Addresses of recordings, each once, in the order given. A file that is there is no glob,
    whatever its name.
    """
    found: list[str] = []
    for pattern in patterns:
        plain = not GLOB & set(pattern) or not remote(pattern) and os.path.lexists(pattern)
        found += [pattern] if plain else matches(pattern)
    return list(dict.fromkeys(found))


def shared_folder(addresses: Sequence[str]) -> str:
    """What the addresses have in common, up to the last folder."""
    common = os.path.commonprefix(addresses)
    return common[: common.rfind("/") + 1]


def said(why: BaseException) -> str:
    text = " ".join(str(getattr(why, "strerror", None) or why).split())[:200]
    return text or type(why).__name__


def identity(address: str) -> Identity | None:
    """What changes when the file does: size and time of change, of a store also its ETag; None
    where it cannot be told, or nothing is there.
    """
    try:
        if not remote(address):
            place = Path(address)
            parts = sorted(place.rglob("*")) if place.is_dir() else [place]
            return [[one.stat().st_size, one.stat().st_mtime_ns] for one in parts]
        store, path = store_of(address)
        info = store.info(path)
    except Exception:  # of any store's library; the work itself will say why
        return None
    tells = {name: str(info[name]) for name in TELLS if info.get(name) is not None}
    return {"size": info.get("size"), **tells} if tells else None


@contextlib.contextmanager
def fetched(address: str) -> Iterator[str]:
    """The path of a file on this machine while the block lasts; a remote one is fetched whole.
    Raises OSError with what the store said.
    """
    if not remote(address):
        yield address
        return
    with tempfile.TemporaryDirectory(prefix="davarlab-") as folder:
        store, path = store_of(address)
        local = os.path.join(folder, PurePosixPath(path).name or "recording")
        try:
            store.get_file(path, local)
        except Exception as why:  # of any store's library
            raise OSError(said(why)) from None
        yield local
