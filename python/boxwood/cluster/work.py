"""What a job is made of: blocks that are computed apart."""

from __future__ import annotations

from typing import Any, Protocol

from numpy.typing import NDArray

from .files import Bytes


class Work(Protocol):
    """Goes to workers by pickle, so it is small: scenes and rows are told by reference."""

    @property
    def unit(self) -> str:
        """What is counted for rates: ``rays`` or ``pixels``."""

    @property
    def blocks(self) -> int:
        """How many there are."""

    @property
    def stages(self) -> list[range]:
        """Blocks that may be computed beside each other; each stage after the one before."""

    def needs(self, index: int) -> range:
        """Blocks of earlier stages whose files a block reads."""

    def file_of(self, index: int) -> str:
        """Where a block's results go, within the job's folder."""

    def identity(self) -> dict[str, Any]:
        """What must be the same when a job is taken up again, as JSON."""

    def input_digest(self, index: int) -> str | None:
        """Of what goes into a block and could have been changed since, beside what the identity tells."""

    def compute(self, folder: str, index: int, rows: NDArray[Any] | None) -> tuple[Bytes, dict[str, int]]:
        """The bytes of a block's file, the same on every machine; and what to count of it."""
