"""Work whose blocks are rows of a large array: a question asked for each ray or point."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .files import Bytes, digest, packed
from .questions import ask, check_rows, numbers_of, question_of
from .reference import SceneRef, open


@dataclass(frozen=True)
class RaysWork:
    """A question for all rows, block by block.

    Rows come from an ``.npy`` file that every worker sees (`path`), or are handed to each task.
    """

    scene: SceneRef
    question: str
    starts: tuple[int, ...]
    """First row of each block, and the number of rows: one more than there are blocks."""
    dtype: str
    fields: tuple[str, ...]
    arguments: dict[str, float] = field(default_factory=dict)
    name: str = ""
    """Of rows that are handed over: two arrays of one name are the same."""
    path: str = ""
    threads: int = 1

    kind = unit = "rays"

    def __post_init__(self) -> None:
        known = question_of(self.question).fields
        check_rows(self.question, (self.starts[-1], question_of(self.question).columns), self.dtype)
        numbers_of(self.question, self.arguments)
        for one in self.fields:
            if one not in known:
                raise ValueError(f"{self.question} answers with {', '.join(known)}, not with {one!r}")

    @property
    def blocks(self) -> int:
        """How many there are."""
        return len(self.starts) - 1

    @property
    def stages(self) -> list[range]:
        """All blocks at once."""
        return [range(self.blocks)]

    def needs(self, index: int) -> range:
        """No block needs another one."""
        return range(0)

    def file_of(self, index: int) -> str:
        """Where a block's results go, within the job's folder."""
        return f"blocks/{index:06}.npz"

    def identity(self) -> dict[str, Any]:
        """What must be the same when a job is taken up again."""
        count = self.starts[-1]
        rows: dict[str, Any] = {"count": count, "dtype": self.dtype}
        block = self.starts[1] if self.blocks else 1
        if self.starts == even_starts(count, block):
            rows["block"] = block
        else:
            rows["starts"] = list(self.starts)
        if self.name:
            rows["name"] = self.name
        return {
            "kind": self.kind,
            "scene": self.scene.content_hash,
            "question": self.question,
            "arguments": self.arguments,
            "fields": list(self.fields),
            "rays": rows,
        }

    def compute(self, folder: str, index: int, rows: NDArray[Any] | None) -> tuple[Bytes, dict[str, int]]:
        """The bytes of a block's file, and what to count of it."""
        rows = self._rows(index) if rows is None else np.asarray(rows)
        if len(rows) != self.starts[index + 1] - self.starts[index]:
            raise ValueError(f"block {index} has {len(rows)} rows, not {self.starts[index + 1] - self.starts[index]}")
        answer = ask(open(self.scene), self.question, rows, self.threads, self.arguments)
        counts = {"rays": len(rows)}
        if "hit" in answer:
            counts["hits"] = int(answer["hit"].sum())
        return packed({name: answer[name] for name in self.fields}), counts

    def input_digest(self, index: int) -> str | None:
        """Of a block's rows, where they are a file's and could have been changed since; None elsewhere."""
        return digest(np.ascontiguousarray(self._rows(index))) if self.path else None

    def _rows(self, index: int) -> NDArray[Any]:
        return rows_file(self.path)[self.starts[index] : self.starts[index + 1]]


def rows_file(path: str | os.PathLike[str]) -> NDArray[Any]:
    """The array of an ``.npy`` file, mapped."""
    try:
        array = np.load(path, mmap_mode="r", allow_pickle=False)
    except (ValueError, EOFError) as error:
        # Numpy takes what it does not know for a pickle, and advises to trust it.
        why = "" if "pickle" in str(error) else f": {error}"
        raise ValueError(f"{path}: not an .npy file of numbers{why}") from None
    if not isinstance(array, np.ndarray):
        raise ValueError(f"{path}: an archive of arrays; give the .npy file of one")
    return array


def table_file(path: str | os.PathLike[str], question: str) -> NDArray[Any]:
    """The array of an ``.npy`` file, if it has the two axes and the columns of what a question is about."""
    array = rows_file(path)
    try:
        check_rows(question, array.shape, array.dtype)
        if array.ndim != 2:
            columns = array.shape[-1]
            raise ValueError(f"rows must be an array (N, {columns}), not {array.shape}: save array.reshape(-1, {columns})")
    except (ValueError, TypeError) as error:
        raise type(error)(f"{path}: {error}") from None
    return array


def starts_of(rows: dict[str, Any]) -> tuple[int, ...]:
    """The blocks' first rows, from what an identity tells of the rays."""
    return tuple(rows["starts"]) if "starts" in rows else even_starts(rows["count"], rows["block"])


def even_starts(count: int, block: int) -> tuple[int, ...]:
    """First rows of blocks of `block` rows, and `count`."""
    if int(block) < 1:
        raise ValueError(f"a block has at least 1 row, not {block}")
    return (*range(0, count, int(block)), count)
