"""A job's folder: what was asked, what is finished, and the results.

::

    job.json          what was asked, and what a rerun must ask again
    receipts.jsonl    one line for each block that was finished or failed; the last line of a block counts
    blocks/000000.npz results of a block: the fields of its rays, or the pixels of its tile
    frames/0000.png   pictures
"""

from __future__ import annotations

import contextlib
import json
import os
from typing import Any, Iterator

from .. import __version__
from .errors import JobRefused
from .files import file_digest, json_bytes, remove_leftovers, save_atomically
from .reference import only_one

#: Of ``job.json`` and the receipts.
SCHEMA = 1

#: What is told of a block: its number, file, hash, bytes, counts and seconds; or its number and how it failed.
Receipt = dict[str, Any]


class JobFolder:
    """The folder at `path`. Only :meth:`begin` and :meth:`add` write, and only the one process that holds :meth:`lock`."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = os.path.abspath(os.fspath(path))
        self._folders = [os.path.join(self.path, name) for name in ("blocks", "frames")]
        self._job = os.path.join(self.path, "job.json")
        self._receipts = os.path.join(self.path, "receipts.jsonl")

    def exists(self) -> bool:
        """True if there is a job."""
        return os.path.exists(self._job)

    def job(self) -> dict[str, Any]:
        """What was asked, as a dict; ValueError if this is no job."""
        try:
            with open(self._job, "rb") as file:
                job = json.loads(file.read(64 << 20))
        except FileNotFoundError:
            raise ValueError(f"{self.path} is no job's folder: there is no job.json") from None
        except (json.JSONDecodeError, UnicodeDecodeError) as error:
            raise ValueError(f"{self._job}: {error}") from None
        if not isinstance(job, dict) or job.get("schema") != SCHEMA or not isinstance(job.get("blocks"), int):
            raise ValueError(f"{self._job}: not a job of schema {SCHEMA}; another version of boxwood wrote it")
        return job

    @contextlib.contextmanager
    def lock(self) -> Iterator[None]:
        """Holds the folder for one run; RuntimeError if another one has it."""
        for folder in self._folders:
            os.makedirs(folder, exist_ok=True)
        held = only_one(os.path.join(self.path, ".lock"), wait=False)
        try:
            held.__enter__()
        except BlockingIOError:
            raise RuntimeError(f"{self.path}: another run is at work in this folder") from None
        with contextlib.ExitStack() as stack:
            stack.push(held)
            yield

    def begin(self, identity: dict[str, Any], blocks: int) -> None:
        """Writes down what is asked, or checks that it is what was asked before.

        Raises
        ------
        JobRefused
            With the fields that differ.
        """
        asked = {"schema": SCHEMA, "boxwood": __version__, "blocks": blocks, **identity}
        asked = json.loads(json_bytes(asked))
        if self.exists():
            before = self.job()
            if before != asked:
                raise JobRefused(self.path, differences(before, asked))
            self.clean()
            self._drop_torn_line()
        elif os.path.exists(self._receipts):
            raise ValueError(f"{self._receipts} is there without a job.json; give another folder")
        else:
            save_atomically(self._job, json_bytes(asked))

    def add(self, receipt: Receipt) -> None:
        """Appends a line."""
        with open(self._receipts, "ab") as file:
            file.write(json.dumps(receipt, sort_keys=True).encode() + b"\n")

    def receipts(self) -> dict[int, Receipt]:
        """The last receipt of each block, by its number. What is no whole line was being written when the machine stopped."""
        found: dict[int, Receipt] = {}
        try:
            with open(self._receipts, "rb") as file:
                lines = file.read().split(b"\n")
        except FileNotFoundError:
            return found
        for line in lines:
            with contextlib.suppress(ValueError):
                receipt = json.loads(line)
                if isinstance(receipt, dict) and isinstance(receipt.get("block"), int):
                    found[receipt["block"]] = receipt
        return found

    def finished(self) -> dict[int, Receipt]:
        """The receipts of the blocks that have results."""
        return {index: receipt for index, receipt in self.receipts().items() if "sha256" in receipt}

    def file(self, receipt: Receipt) -> str:
        """The file that a receipt tells of."""
        return path_in(self.path, receipt["file"])

    def clean(self) -> None:
        """Removes what killed workers left half written."""
        for folder in self._folders:
            remove_leftovers(folder)

    def _drop_torn_line(self) -> None:
        if not os.path.exists(self._receipts):
            return
        with open(self._receipts, "r+b") as file:
            whole = file.read()
            file.truncate(whole.rfind(b"\n") + 1)


def path_in(folder: str, file: str) -> str:
    """The path of a file that is named within a job's folder."""
    return os.path.join(folder, *file.split("/"))


def holds(folder: str, receipt: Receipt) -> bool:
    """True if a block's file is there with the bytes that its receipt tells of."""
    path = path_in(folder, receipt["file"])
    try:
        return bool(os.path.getsize(path) == receipt["bytes"] and file_digest(path) == receipt["sha256"])
    except FileNotFoundError:
        return False


def differences(then: dict[str, Any], now: dict[str, Any], under: str = "") -> list[tuple[str, Any, Any]]:
    """(dotted field, then, now) of what differs in two trees of dicts."""
    found: list[tuple[str, Any, Any]] = []
    for key in sorted({*then, *now}):
        a, b, name = then.get(key), now.get(key), f"{under}{key}"
        if isinstance(a, dict) and isinstance(b, dict):
            found += differences(a, b, name + ".")
        elif a != b:
            found.append((name, a, b))
    return found
