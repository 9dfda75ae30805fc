"""What can go wrong with a job, each with its place, its cause and a way out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .run import Report


class SceneMismatch(ValueError):
    """The scene found under a reference's path is another one."""


class JobRefused(ValueError):
    """The folder holds another job; :attr:`fields` names what differs."""

    def __init__(self, folder: str, differences: list[tuple[str, Any, Any]]) -> None:
        self.fields = [field for field, _, _ in differences]
        told = "; ".join(f"{field} was {_short(then)}, is {_short(now)} now" for field, then, now in differences)
        super().__init__(f"{folder} holds another job: {told}. Ask as before to go on with it, or give another folder")


class BlocksFailed(RuntimeError):
    """Some blocks failed in the end; all others are saved. :attr:`report` has everything, ``report.failed`` errors by block."""

    def __init__(self, report: Report) -> None:
        self.report = report
        index, error = next(iter(report.failed.items()))
        more = f" (and {len(report.failed) - 1} more)" if len(report.failed) > 1 else ""
        super().__init__(
            f"{report.folder}: block {index} failed: {error}{more}; {report.done} of {report.blocks} blocks are saved. "
            "The same call tries those that failed again"
        )


class ClusterLost(ConnectionError):
    """The scheduler or all workers are gone. What was finished is saved; the same call goes on from there."""


def _short(value: Any, limit: int = 80) -> str:
    text = repr(value)
    return text if len(text) <= limit else text[: limit - 3] + "..."
