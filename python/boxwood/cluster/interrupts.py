"""Ctrl-C, and SIGTERM, by which schedulers of machines end jobs: neither is lost."""

from __future__ import annotations

import contextlib
import signal
import sys
from typing import Any, Callable, Iterator

from .progress import Progress


class Interrupts:
    """Raises KeyboardInterrupt where the signal comes, and again at the next block if the interpreter dropped it: what is raised within
    a finalizer or a weak reference's callback, of which a cluster has many, goes no further.
    """

    def __init__(self) -> None:
        self._heard = False

    @contextlib.contextmanager
    def listen(self) -> Iterator[None]:
        """Meanwhile, in the main thread; in others nothing changes."""
        before: dict[signal.Signals, Any] = {}
        hook = sys.unraisablehook
        try:
            for one in (signal.SIGINT, signal.SIGTERM):
                before[one] = signal.signal(one, self._hear)
            sys.unraisablehook = lambda lost: None if lost.exc_type is KeyboardInterrupt else hook(lost)
        except ValueError:  # Not the main thread.
            pass
        try:
            yield
        finally:
            sys.unraisablehook = hook
            for one, handler in before.items():
                signal.signal(one, handler)

    def heeded(self, tell: Callable[[Progress], object]) -> Callable[[Progress], object]:
        """`tell`, which comes after each block, but not after an interrupt."""

        def told(progress: Progress) -> object:
            if self._heard:
                raise KeyboardInterrupt
            return tell(progress)

        return told

    def _hear(self, *_: object) -> None:
        self._heard = True
        raise KeyboardInterrupt
