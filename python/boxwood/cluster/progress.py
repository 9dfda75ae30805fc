"""How far a job is: for a callback, or as one line of a terminal."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from typing import Callable


@dataclass
class Progress:
    """Of a run. Only what this run computed counts for the rate."""

    total: int
    """Blocks of the job."""
    done: int
    """Blocks that are finished, by this run or before."""
    failed: int
    units: int
    """Rays or pixels that this run computed."""
    computed: int
    """Blocks that this run computed."""
    seconds: float
    """Since this run began."""
    what: str = "rays"

    @property
    def rate(self) -> float:
        """Units a second; 0 at first."""
        return self.units / self.seconds if self.seconds > 0 else 0.0

    @property
    def eta(self) -> float | None:
        """Seconds left, None while nobody knows."""
        left = self.total - self.done - self.failed
        return left * self.seconds / self.computed if self.computed else (None if left else 0.0)

    def __str__(self) -> str:
        failed = f", {self.failed} failed" if self.failed else ""
        left = "" if self.eta is None else f", {_clock(self.eta)} left"
        return f"{self.done}/{self.total} blocks{failed}, {self.rate / 1e6:.2f} M{self.what}/s{left}"


def teller(progress: Callable[[Progress], object] | bool | None) -> Callable[[Progress], object]:
    """The function to call with each :class:`Progress`: what the user gave, or a line on stderr if that is a terminal."""
    if callable(progress):
        return progress
    if progress is False or (progress is None and not sys.stderr.isatty()):
        return lambda _: None
    return Line()


class Line:
    """A line on stderr that is written over, ten times a second at most."""

    def __init__(self) -> None:
        self._last = 0.0

    def __call__(self, progress: Progress) -> None:
        ended = progress.done + progress.failed >= progress.total
        if ended or time.monotonic() - self._last > 0.1:
            self._last = time.monotonic()
            print(f"\r\x1b[K{progress}", end="\n" if ended else "", file=sys.stderr, flush=True)


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"
