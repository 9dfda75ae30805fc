"""Files that are there as a whole or not at all."""

from __future__ import annotations

import hashlib
import io
import json
import os
import uuid
from typing import Any, Mapping

import numpy as np
from numpy.typing import NDArray

#: Behind the name of what is being written.
TEMPORARY = ".part"

Bytes = bytes | bytearray | memoryview


def save_atomically(path: str | os.PathLike[str], data: Bytes) -> None:
    """Writes `data` beside `path`, has it on disk, and renames it: whoever reads sees the old file or the new one."""
    folder, name = os.path.split(os.path.abspath(path))
    beside = os.path.join(folder, f".{name}.{uuid.uuid4().hex}{TEMPORARY}")
    try:
        with open(beside, "xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(beside, path)
    except BaseException:
        if os.path.exists(beside):
            os.unlink(beside)
        raise
    sync_folder(folder)


def sync_folder(folder: str) -> None:
    """Has the folder's entries on disk, where the system can."""
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError:  # Windows opens no folders.
        return
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def remove_leftovers(folder: str) -> None:
    """Removes what killed workers left half written."""
    for entry in os.scandir(folder):
        if entry.name.startswith(".") and entry.name.endswith(TEMPORARY):
            os.unlink(entry.path)


def packed(arrays: Mapping[str, NDArray[Any]]) -> memoryview:
    """A dict of arrays as the bytes of an ``.npz``: the same arrays give the same bytes."""
    # np.savez dates all members 1980, so nothing of the clock gets in.
    file = io.BytesIO()
    np.savez(file, **dict(arrays))  # type: ignore[arg-type]
    return file.getbuffer()


def digest(data: Any) -> str:
    """SHA-256 of bytes, or of a contiguous array's bytes, in hex."""
    return hashlib.sha256(data).hexdigest()


def file_digest(path: str) -> str:
    """SHA-256 of a file, in hex."""
    with open(path, "rb") as file:
        sha, piece = hashlib.sha256(), file.read(1 << 20)
        while piece:
            sha.update(piece)
            piece = file.read(1 << 20)
        return sha.hexdigest()


def json_bytes(value: Any) -> bytes:
    """As JSON for people and diffs."""
    return (json.dumps(value, indent=1, sort_keys=True) + "\n").encode()
