"""A job from its first block to its last, or from where an earlier run of it ended."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, field
from typing import Any, Callable, Iterable

from .. import __version__
from .errors import BlocksFailed, ClusterLost, JobRefused
from .folder import JobFolder, Receipt
from .pool import Pool, was_killed
from .progress import Progress, teller
from .tasks import check_block, run_block
from .work import Work

#: Seconds: what other machines wrote may be seen late on network file systems.
SEEN_WITHIN = 15.0


@dataclass
class Report:
    """What a run did."""

    folder: str
    blocks: int
    done: int = 0
    """Blocks that have results now."""
    kept: int = 0
    """Of these, blocks that had them before."""
    failed: dict[int, str] = field(default_factory=dict)
    """Errors as text, by block."""
    counts: dict[str, int] = field(default_factory=dict)
    """Sums over all blocks that are done."""
    seconds: float = 0.0
    """Of this run."""


def run(
    work: Work,
    out: str | os.PathLike[str],
    pool: Pool,
    *,
    rows: Callable[[int], Any] = lambda index: None,
    retries: int = 3,
    progress: Callable[[Progress], object] | bool | None = None,
) -> Report:
    """Computes all blocks of `work` that the folder `out` does not have yet.

    `rows(index)` gives what a block's task is handed. A block that fails is tried `retries` times more.

    Raises
    ------
    JobRefused
        If the folder has another job.
    BlocksFailed
        If some blocks failed in the end; all others are saved.
    ClusterLost
        If the cluster went away; the same call goes on.
    """
    folder = JobFolder(out)
    with folder.lock():
        folder.begin(work.identity(), work.blocks)
        started = _Run(folder, work, pool, rows, retries, teller(progress))
        try:
            return started.all()
        except ClusterLost as error:
            saved = f"{started.report.done} of {work.blocks} blocks are saved in {folder.path}"
            raise ClusterLost(f"{error}; {saved}: the same call goes on") from None


class _Run:
    def __init__(
        self,
        folder: JobFolder,
        work: Work,
        pool: Pool,
        rows: Callable[[int], Any],
        retries: int,
        tell: Callable[[Progress], object],
    ) -> None:
        self._folder, self._work, self._pool = folder, work, pool
        self._rows, self._retries, self._tell = rows, retries, tell
        self._start = time.monotonic()
        self._units = 0
        self.report = Report(folder.path, work.blocks, counts={work.unit: 0})

    def all(self) -> Report:
        kept = self._kept()
        for stage in self._work.stages:
            killed = self._compute(index for index in stage if index not in kept and self._is_ready(index))
            # One after the other, so that a block which takes its worker down is not mistaken for those beside it.
            for index in killed:
                self._compute([index], last=True)
        self._folder.clean()
        self.report.seconds = time.monotonic() - self._start
        if self.report.failed:
            raise BlocksFailed(self.report)
        return self.report

    def _kept(self) -> set[int]:
        """The blocks that earlier runs finished and that are still there."""
        receipts = {index: one for index, one in self._folder.finished().items() if 0 <= index < self._work.blocks}
        calls = ((index, check_block, (self._folder.path, self._work, receipt)) for index, receipt in receipts.items())
        kept: set[int] = set()
        for index, state in self._pool.each(calls, self._retries):
            if isinstance(state, Exception):
                raise state
            if state == "changed":
                raise JobRefused(self._folder.path, [(f"rays of block {index}", receipts[index]["input"], "others")])
            if state == "kept":
                kept.add(index)
                self._count(receipts[index])
        self.report.kept = len(kept)
        self._units, self._start = 0, time.monotonic()
        return kept

    def _is_ready(self, index: int) -> bool:
        """False, and the block counts as failed, if a block that it needs failed."""
        missing = [one for one in self._work.needs(index) if one in self.report.failed]
        if missing:
            self._fail(index, f"it needs block {missing[0]}")
        return not missing

    def _compute(self, indices: Iterable[int], last: bool = False) -> list[int]:
        """Computes blocks; returns those whose workers died."""
        killed: list[int] = []
        path, work = self._folder.path, self._work
        calls = ((index, run_block, (path, work, __version__, index, self._rows(index))) for index in indices)
        for index, outcome in self._pool.each(calls, self._retries):
            if isinstance(outcome, Exception):
                if was_killed(outcome) and not last:
                    killed.append(index)
                else:
                    self._fail(index, _told(outcome))
            else:
                self._see(outcome)
                self._folder.add(outcome)
                self._count(outcome)
            self._tell(self._progress())
        return killed

    def _count(self, receipt: Receipt) -> None:
        self.report.done += 1
        self._units += receipt["counts"].get(self._work.unit, 0)
        for name, count in receipt["counts"].items():
            self.report.counts[name] = self.report.counts.get(name, 0) + count

    def _fail(self, index: int, told: str) -> None:
        self.report.failed[index] = told
        self._folder.add({"block": index, "failed": told})

    def _see(self, receipt: Receipt) -> None:
        """Waits until this machine sees the block's file, too."""
        path, until = self._folder.file(receipt), time.monotonic() + SEEN_WITHIN
        while not os.path.exists(path) or os.path.getsize(path) != receipt["bytes"]:
            if time.monotonic() > until:
                raise OSError(
                    f"{path}: a worker wrote it, but it is not seen here: the folder must be one that all machines share"
                )
            time.sleep(0.1)

    def _progress(self) -> Progress:
        report, seconds = self.report, time.monotonic() - self._start
        computed = report.done - report.kept
        return Progress(report.blocks, report.done, len(report.failed), self._units, computed, seconds, self._work.unit)


def _told(error: Exception) -> str:
    if was_killed(error):
        return "the workers that computed it died, one after the other"
    return f"{type(error).__name__}: {error}"
