"""Where blocks are computed: in this process, or on a Dask cluster. Both take calls and give outcomes as they come.

A call is ``(index, function, arguments)``; an outcome is ``(index, value)``, with the error as value where it failed in the end.
"""

# Dask is typed in part.
# mypy: disable-error-code="no-untyped-call,type-arg,attr-defined,union-attr"

from __future__ import annotations

import itertools
import queue
import threading
import time
import uuid
from typing import TYPE_CHECKING, Any, Callable, Iterable, Iterator, Protocol

from .errors import ClusterLost

if TYPE_CHECKING:
    from distributed import Client, Future

Call = tuple[int, Callable[..., Any], tuple[Any, ...]]

#: Calls that a cluster is given at a time: enough for hundreds of workers, few enough for its scheduler to be quick.
WINDOW = 1000


class Pool(Protocol):
    """Where calls are answered."""

    @property
    def threads(self) -> int:
        """Of a task, if nobody says; 0: all of the machine."""

    def each(self, calls: Iterable[Call], retries: int) -> Iterator[tuple[int, Any]]:
        """The outcomes. A call that raises is tried again so many times."""


class InProcess:
    """One block after the other, each on all threads."""

    threads = 0

    def each(self, calls: Iterable[Call], retries: int) -> Iterator[tuple[int, Any]]:
        """The outcomes, in the order of the calls."""
        for index, function, arguments in calls:
            yield index, self._outcome(function, arguments, retries)

    def _outcome(self, function: Callable[..., Any], arguments: tuple[Any, ...], retries: int) -> Any:
        for attempt in range(retries + 1):
            try:
                return function(*[_value(one) for one in arguments])
            except Exception as error:  # A block's error is its outcome.
                if attempt == retries:
                    return error


class Cluster:
    """A Dask cluster, by its client.

    Parameters
    ----------
    client : distributed.Client
    patience : float
        Seconds that a run waits while there is no worker, or no scheduler that answers.
    """

    # A worker has as many tasks at a time as it has threads, and casting lets the interpreter go.
    threads = 1

    def __init__(self, client: Client, patience: float = 300.0) -> None:
        self._client = client
        self._patience = patience

    def each(self, calls: Iterable[Call], retries: int) -> Iterator[tuple[int, Any]]:
        """The outcomes as they come."""
        calls = iter(calls)
        pending: dict[Any, tuple[int, Future]] = {}
        done: queue.SimpleQueue[Future] = queue.SimpleQueue()
        well = time.monotonic()
        try:
            while True:
                if len(pending) <= WINDOW // 2:
                    for index, future in self._submit(list(itertools.islice(calls, WINDOW - len(pending))), retries):
                        pending[future.key] = (index, future)
                        future.add_done_callback(done.put)
                if not pending:
                    return
                try:
                    future = done.get(timeout=1)
                except queue.Empty:
                    well = time.monotonic() if self._is_well() else well
                    if time.monotonic() - well > self._patience:
                        raise ClusterLost(f"no worker and no answer for {self._patience:g} s") from None
                    continue
                well = time.monotonic()
                if future.status == "lost":
                    # Its worker died with the receipt, so the scheduler has the block computed again.
                    future.add_done_callback(done.put)
                    continue
                index, _ = pending.pop(future.key)
                yield index, self._outcome(future)
        finally:
            self._cancel([future for _, future in pending.values()])

    def _submit(self, calls: list[Call], retries: int) -> Iterable[tuple[int, Future]]:
        import dask

        if not calls:
            return []
        # Keys of their own, so that what an earlier run left on the cluster is not taken for this one's.
        run = uuid.uuid4().hex
        tasks = [
            dask.delayed(function, pure=False)(*arguments, dask_key_name=f"boxwood-{function.__name__}-{run}-{index}")
            for index, function, arguments in calls
        ]
        return zip([index for index, _, _ in calls], self._client.compute(tasks, retries=retries))

    def _outcome(self, future: Future) -> Any:
        from distributed import CancelledError

        try:
            return future.exception() if future.status == "error" else future.result()
        except (CancelledError, OSError, TimeoutError):
            raise ClusterLost("the scheduler is gone") from None

    def _is_well(self) -> bool:
        """True if a scheduler answers and has workers."""
        try:
            cores = self._client.scheduler.ncores
            return self._client.status == "running" and bool(self._client.sync(cores, callback_timeout=min(10, self._patience)))
        except (OSError, TimeoutError):
            return False

    def _cancel(self, futures: list[Future]) -> None:
        if futures and self._client.status == "running":
            self._client.cancel(futures)


def await_scheduler(address: str, patience: float, tell: Callable[[str], object]) -> None:
    """Returns when a scheduler answers at `address`; after a second `tell` hears that it is waited for.

    A client that finds none takes as long again to end, and an interrupt meanwhile leaves it half made; so it is made afterwards.

    Raises
    ------
    OSError
        If none answers for `patience` seconds.
    """
    import asyncio

    from distributed.comm import connect
    from distributed.security import Security

    async def knock(seconds: float) -> None:
        knocking = connect(address, timeout=seconds, **Security().get_connection_args("client"))
        try:
            # Its own limit does not hold for what takes the connection and is silent.
            comm = await asyncio.wait_for(knocking, seconds + 0.1)
        except asyncio.TimeoutError:
            raise TimeoutError(f"no word for {seconds:g} s") from None
        except MemoryError:
            # It takes another protocol's first letters for a length.
            raise OSError("what answers there is no Dask scheduler") from None
        await comm.close()

    def attempt(seconds: float) -> None:
        outcome: queue.SimpleQueue[Exception | None] = queue.SimpleQueue()

        def work() -> None:
            try:
                asyncio.run(knock(seconds))
                outcome.put(None)
            except Exception as error:  # Of the other thread.
                outcome.put(error)

        # In a thread of its own: an interrupt within a coroutine would leave the loop in pieces.
        threading.Thread(target=work, daemon=True).start()
        if error := outcome.get():
            raise error

    at_once = min(1.0, patience)
    try:
        attempt(at_once)
    except OSError:
        if patience <= at_once:
            raise
        tell(f"waiting for a scheduler at {address}, {patience:g} s at most")
        attempt(patience - at_once)


def was_killed(outcome: Any) -> bool:
    """True if a block failed because its workers died: perhaps by another block's fault."""
    return type(outcome).__name__ == "KilledWorker"


def _value(argument: Any) -> Any:
    """What a lazy argument stands for."""
    if hasattr(argument, "__dask_graph__"):
        return argument.compute(scheduler="threads")
    return argument
