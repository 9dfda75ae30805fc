"""A Dask cluster of real processes on 127.0.0.1, whose parts can be killed."""

import os
import re
import signal
import subprocess
import sys
import threading
import time


class Loopback:
    """A scheduler and `workers` worker processes with one thread each; all of them end with the ``with`` block."""

    def __init__(self, workers=3):
        self._first = workers
        self.scheduler = None
        self.workers = []
        self.address = None

    def __enter__(self):
        try:
            self.start_scheduler()
            for _ in range(self._first):
                self.add_worker()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        for process in (*self.workers, self.scheduler):
            if process is not None:
                kill(process)

    def start_scheduler(self):
        """A scheduler at a free port; its address is known when this returns."""
        self.scheduler = dask("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-show")
        told = {}
        ready = threading.Event()
        # Read to the end, or the pipe would fill and the scheduler wait.
        threading.Thread(target=_listen, args=(self.scheduler.stderr, told, ready), daemon=True).start()
        assert ready.wait(60), "the scheduler told no address"
        self.address = told["address"]

    def add_worker(self):
        """One more process, without a nanny that would bring it back."""
        worker = dask(
            "worker",
            self.address,
            "--host",
            "127.0.0.1",
            "--nthreads",
            "1",
            "--no-nanny",
            "--no-dashboard",
            "--death-timeout",
            "10",
            err=subprocess.DEVNULL,
        )
        self.workers.append(worker)
        return worker

    def client(self):
        """A client that waits for the first workers."""
        from distributed import Client

        client = Client(self.address, timeout=30, set_as_default=False)
        client.wait_for_workers(1, timeout=60)
        return client


def dask(*arguments, err=subprocess.PIPE):
    """A process of Dask's own command line, apart from this one's terminal."""
    environment = {**os.environ, "PYTHONSAFEPATH": "1", "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "10s"}
    return subprocess.Popen(
        [sys.executable, "-m", "dask", *arguments], stdout=subprocess.DEVNULL, stderr=err, env=environment, start_new_session=True
    )


def kill(process):
    """kill -9, and waits until it is gone."""
    if process.poll() is None:
        os.kill(process.pid, signal.SIGKILL)
    process.wait(timeout=30)


def until(holds, seconds=60):
    """Waits until `holds()` is true; AssertionError if it does not come to be."""
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


def _listen(pipe, told, ready):
    for line in pipe:
        found = re.search(rb"Scheduler at:\s+(tcp://\S+)", line)
        if found:
            told["address"] = found[1].decode()
            ready.set()
    ready.set()
