"""Ctrl-C, and SIGTERM, by which schedulers of machines end jobs."""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
from typing import Any, Callable, Iterator

from .progress import Progress


class Interrupts:
    """Raises KeyboardInterrupt where the signal comes, and again after the next block that is computed if the interpreter dropped it: what is
    raised within a finalizer or a weak reference's callback, of which a cluster has many, goes no further.
    """

    def __init__(self) -> None:
        self._heard = False

    @contextlib.contextmanager
    def listen(self) -> Iterator[None]:
        """Meanwhile; only the main thread can, in others nothing changes. A Ctrl-C that was ignored, as for jobs in the background, stays so."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        hook, before = sys.unraisablehook, {one: signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM)}
        try:
            sys.unraisablehook = lambda lost: None if lost.exc_type is KeyboardInterrupt else hook(lost)
            for one, handler in before.items():
                if handler is not signal.SIG_IGN:
                    signal.signal(one, self._hear)
            yield
        finally:
            sys.unraisablehook = hook
            for one, handler in before.items():
                # None: of a host that is not Python; it cannot be put back.
                if handler is not None:
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
