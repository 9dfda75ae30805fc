"""What runs on a worker: a block is computed and written there, and only a few bytes about it come back."""

from __future__ import annotations

import time
from typing import Any

from numpy.typing import NDArray

from .. import __version__
from .files import digest, save_atomically
from .folder import Receipt, holds, path_in
from .work import Work


def run_block(folder: str, work: Work, version: str, index: int, rows: NDArray[Any] | None = None) -> Receipt:
    """Computes a block and writes its file; returns the receipt. Twice the same block gives the same bytes, so it does no harm."""
    if version != __version__:
        raise RuntimeError(f"this worker has boxwood {__version__}, the job is of {version}: install the same on all")
    start = time.perf_counter()
    data, counts = work.compute(folder, index, rows)
    file = work.file_of(index)
    receipt: Receipt = {"block": index, "file": file, "sha256": digest(data), "bytes": len(data), "counts": counts}
    if given := work.input_digest(index):
        receipt["input"] = given
    save_atomically(path_in(folder, file), data)
    return {**receipt, "seconds": round(time.perf_counter() - start, 6)}


def check_block(folder: str, work: Work, receipt: Receipt) -> str:
    """What became of a finished block: ``"kept"``, ``"lost"`` (its file is gone or damaged), or ``"changed"`` (its rays)."""
    if receipt.get("file") != work.file_of(receipt["block"]) or not holds(folder, receipt):
        return "lost"
    return "kept" if work.input_digest(receipt["block"]) == receipt.get("input") else "changed"
