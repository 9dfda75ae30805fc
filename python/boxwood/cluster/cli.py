"""``python -m boxwood.cluster``: jobs from a shell."""

# Dask is typed in part.
# mypy: disable-error-code="no-untyped-call"

from __future__ import annotations

import argparse
import contextlib
import json
import logging
import os
import signal
import sys
import warnings
from typing import Any, Iterator

from ..scene import Scene
from .arguments import parser
from .errors import BlocksFailed, ClusterLost, JobRefused, SceneMismatch
from .folder import JobFolder, holds
from .interrupts import Interrupts
from .jobs import ask_file, render
from .pool import Cluster, InProcess, Pool, await_scheduler
from .progress import teller
from .rays import table_file
from .reference import SceneRef, is_url
from .render import CAMERA, LOOKS
from .run import Report

#: How the process ends, as ``boxwood`` does.
OK, FAILED, USAGE, INPUT, INTERRUPTED = range(5)


class Trouble(Exception):
    """An error of the command line, and the code to exit with."""

    def __init__(self, code: int, text: object) -> None:
        super().__init__(str(text))
        self.code = code


def main(arguments: list[str] | None = None) -> int:
    """Runs a command; returns the exit code."""
    options = parser().parse_args(arguments)
    interrupts = Interrupts()
    options.progress = interrupts.heeded(teller(None))
    with _manners():
        try:
            with interrupts.listen():
                return {"rays": run_rays, "render": run_render, "status": run_status}[options.command](options)
        except Trouble as trouble:
            return _error(trouble.code, trouble)
        except KeyboardInterrupt:
            begun = JobFolder(options.out).exists()
            return _error(INTERRUPTED, "interrupted" + "; what is done is saved, the same command goes on" * begun)
        except BlocksFailed as error:
            for index, told in sorted(error.report.failed.items()):
                print(f"block {index} failed: {told}", file=sys.stderr)
            return _error(FAILED, error)
        except ClusterLost as error:
            return _error(INTERRUPTED, error)
        except (JobRefused, SceneMismatch) as error:
            return _error(INPUT, error)
        except (ValueError, TypeError, OSError, RuntimeError, MemoryError) as error:
            return _error(USAGE, str(error) or type(error).__name__)


def run_rays(options: argparse.Namespace) -> int:
    """The command ``rays``."""
    try:
        table_file(options.rays, options.question)
    except (OSError, ValueError, TypeError) as error:
        raise Trouble(INPUT, error if options.rays in str(error) else f"{options.rays}: {error}") from None
    fields = options.fields.split(",") if options.fields else None
    asked = {"question": options.question, "fields": fields, "block": options.block}
    with _scene_and_pool(options) as (ref, pool):
        return _told(options, ask_file(ref, options.rays, options.out, pool, **asked, **_common(options)))


def run_render(options: argparse.Namespace) -> int:
    """The command ``render``."""
    cameras: Any = {name: getattr(options, name) for name in CAMERA if getattr(options, name) is not None}
    if options.cameras:
        if cameras:
            raise Trouble(USAGE, "--cameras tells all about the cameras: leave out --eye, --target, --up and --fov")
        cameras = _cameras(options.cameras)
    looks = {name: getattr(options, name) for name in LOOKS if getattr(options, name, None) is not None}
    asked = {"size": options.size, "cameras": cameras, "frames": options.frames, "tile": options.tile, "looks": looks}
    with _scene_and_pool(options) as (ref, pool):
        return _told(options, render(ref, options.out, pool, **asked, **_common(options)))


def run_status(options: argparse.Namespace) -> int:
    """The command ``status``."""
    folder = JobFolder(options.out)
    try:
        job = folder.job()
    except ValueError as error:
        raise Trouble(INPUT, error) from None
    receipts = folder.receipts()
    done = folder.finished()
    damaged = [index for index, receipt in sorted(done.items()) if options.check and not holds(folder.path, receipt)]
    failed = {index: receipt["failed"] for index, receipt in sorted(receipts.items()) if "failed" in receipt}
    counts: dict[str, int] = {}
    for receipt in done.values():
        for name, count in receipt["counts"].items():
            counts[name] = counts.get(name, 0) + count
    whole, seconds = len(done) - len(damaged), sum(receipt["seconds"] for receipt in done.values())
    if options.json:
        told = {"kind": job["kind"], "blocks": job["blocks"], "done": whole, "failed": failed, "damaged": damaged}
        _json(options, {**told, "counts": counts, "seconds": seconds})
    else:
        print(f"{job['kind']}: {whole} of {_counted(job['blocks'], 'blocks')}, {_listed(counts)}{seconds:.1f} s of work")
        for index, why in failed.items():
            print(f"block {index} failed: {why}")
        for index in damaged:
            print(f"block {index} is not as it was written: the same command computes it again")
    return FAILED if failed else OK if whole == job["blocks"] else INTERRUPTED


@contextlib.contextmanager
def _scene_and_pool(options: argparse.Namespace) -> Iterator[tuple[SceneRef, Pool]]:
    """The reference of the scene, and where to work."""
    if options.resume and not JobFolder(options.out).exists():
        raise Trouble(USAGE, f"{options.out}: there is no job to go on with; leave out --resume to begin one")
    if options.scheduler and options.workers is not None:
        raise Trouble(USAGE, "--workers is for work without --scheduler: give one of them")
    try:
        path = options.scene
        if is_url(path):
            raise ValueError(f"{path}: give a file; scenes by URL are for boxwood.dask, which knows their hash")
        known = path.endswith(".bwx")
        found: Any = SceneRef.of(path) if known else Scene.load(path)
    except (OSError, ValueError) as error:
        raise Trouble(INPUT, error) from None
    if not known:
        os.makedirs(options.out, exist_ok=True)
        found = SceneRef.save(found, os.path.join(options.out, "scene.bwx"))
    with _pool(options) as pool:
        yield found, pool


@contextlib.contextmanager
def _pool(options: argparse.Namespace) -> Iterator[Pool]:
    if options.workers == 0:
        yield InProcess()
        return
    try:
        from distributed import Client
    except ImportError:
        raise Trouble(USAGE, "a cluster needs Dask: pip install 'boxwood[dask]'; or --workers 0 for this process") from None
    # What becomes of the cluster is told by the outcome.
    for name in [name for name in logging.root.manager.loggerDict if name.split(".")[0] == "distributed"]:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    with contextlib.ExitStack() as stack:
        address = options.scheduler or stack.enter_context(_own_cluster(options.workers or 1))
        try:
            if options.scheduler:
                await_scheduler(address, options.patience, lambda told: print(told, file=sys.stderr))
            client = stack.enter_context(Client(address, timeout=30, set_as_default=False))
            if not client.ncores():
                print(f"{address} has no workers yet: waiting for one, {options.patience:g} s at most", file=sys.stderr)
        except (OSError, TimeoutError, ValueError) as error:
            raise Trouble(USAGE, f"no scheduler answers at {address}: {error}") from None
        yield Cluster(client, options.patience)


def _own_cluster(workers: int) -> Any:
    """Processes of this machine, which do not hear Ctrl-C: this one tells them when to end."""
    from dask.system import CPU_COUNT
    from distributed import LocalCluster

    threads = max(1, CPU_COUNT // workers)
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        # The dashboard at any port; only errors are logged.
        return LocalCluster(workers, threads, host="127.0.0.1", dashboard_address="127.0.0.1:0", silence_logs=logging.CRITICAL)
    finally:
        signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def _manners() -> Iterator[None]:
    """Meanwhile warnings are one line."""
    with warnings.catch_warnings():
        warnings.showwarning = lambda message, *_, **__: print(f"warning: {message}", file=sys.stderr)
        yield


def _common(options: argparse.Namespace) -> dict[str, Any]:
    return {"threads": options.threads, "retries": options.retries, "progress": options.progress}


def _told(options: argparse.Namespace, report: Report) -> int:
    if options.json:
        _json(options, vars(report))
    else:
        kept = f" ({report.kept} {'was' if report.kept == 1 else 'were'} there)" if report.kept else ""
        print(f"{report.folder}: {_counted(report.done, 'blocks')}{kept}, {_listed(report.counts)}{report.seconds:.1f} s")
    return OK


def _json(options: argparse.Namespace, body: dict[str, Any]) -> None:
    print(json.dumps({"boxwood": 1, "command": f"cluster {options.command}", **body}))


def _listed(counts: dict[str, int]) -> str:
    return "".join(f"{_counted(count, name)}, " for name, count in counts.items())


def _counted(count: int, name: str) -> str:
    return f"{count:,} {name.removesuffix('s') if count == 1 else name}"


def _cameras(path: str) -> list[dict[str, Any]]:
    try:
        with open(path, "rb") as file:
            cameras = json.load(file)
    except (OSError, ValueError) as error:
        raise Trouble(INPUT, f"{path}: {error}") from None
    if not isinstance(cameras, list) or not all(isinstance(camera, dict) for camera in cameras) or not cameras:
        example = '[{"eye": [0, 1, 5], "target": [0, 0, 0]}]'
        raise Trouble(INPUT, f"{path}: not a list of cameras; it looks as in {example}")
    return cameras


def _error(code: int, text: object) -> int:
    print(f"error: {text}", file=sys.stderr)
    return code
