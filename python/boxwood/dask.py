"""Boxwood's questions for Dask arrays, and jobs that survive the loss of workers. Needs ``pip install 'boxwood[dask]'``.

>>> import boxwood, boxwood.dask, dask.array as da
>>> ref = boxwood.dask.SceneRef.save(scene, "/shared/scene.bwx")
>>> boxwood.dask.cast_rays(ref, rays)["t_hit"].min().compute()       # lazy, block by block, never gathered
>>> boxwood.dask.run_rays(ref, rays, out="/shared/hits")             # a billion: written by the workers, taken up again after a crash
>>> boxwood.dask.read("/shared/hits")["t_hit"]                       # a dask array again
"""

# Dask is typed in part.
# mypy: disable-error-code="no-untyped-call,no-any-return,arg-type,name-defined,attr-defined"

from __future__ import annotations

import math
import os
import threading
from typing import TYPE_CHECKING, Any, Callable, Iterable, Protocol, Sequence

import dask.array as da
import numpy as np
from dask.base import tokenize
from numpy.typing import NDArray

from .cluster import jobs, reference
from .cluster.errors import BlocksFailed, ClusterLost, JobRefused, SceneMismatch
from .cluster.folder import JobFolder
from .cluster.jobs import Cameras, Path, ask_file, fields_of, reference_of
from .cluster.pool import Cluster, InProcess, Pool
from .cluster.progress import Progress
from .cluster.questions import QUESTIONS, ask, check_rows, numbers_of, question_of
from .cluster.rays import RaysWork, starts_of
from .cluster.reference import SceneRef
from .cluster.run import Report, run

if TYPE_CHECKING:
    from distributed import Client

__all__ = ["BlocksFailed", "ClusterLost", "JobRefused", "Report", "SceneMismatch", "SceneRef", "read", "render", "run_rays"]
__all__ += QUESTIONS


def __dir__() -> list[str]:
    return sorted(__all__)


class Lazy(Protocol):
    """A question for dask arrays."""

    __name__: str

    def __call__(self, ref: SceneRef | Path, rows: da.Array, *, threads: int = 1, **arguments: float) -> Any: ...


def _lazy(name: str) -> Lazy:
    question = question_of(name)
    what = "rays" if question.columns == 6 else "query_points"

    def lazy(ref: SceneRef | Path, rows: da.Array, *, threads: int = 1, **arguments: float) -> Any:
        ref, rows = reference_of(ref), _whole_rows(name, rows)
        arguments = numbers_of(name, arguments)
        axis = rows.ndim - 1
        key = f"boxwood-{name}-{tokenize(rows.name, ref, arguments)}"
        nothing = np.empty((0,) * axis, object)
        # A block of these is a dict of arrays, which users never see: only its fields, by `_field`.
        answers = rows.map_blocks(_ask, name, ref, threads, arguments, drop_axis=axis, dtype=object, meta=nothing, name=key)
        fields = {field: _field(answers, field, kind, behind) for field, (kind, behind) in question.fields.items()}
        return next(iter(fields.values())) if question.single else fields

    lazy.__name__ = lazy.__qualname__ = name
    lazy.__doc__ = f"""{name} of :class:`boxwood.Scene` for a dask array (..., {question.columns}), lazily, block by block.

    Parameters
    ----------
    ref : SceneRef, or path
    {what} : dask array (..., {question.columns})
        Blocks of 1 to 4 million rows are a good size.
    threads : int
        Of each task; 1 is right for workers with a thread for each core.
    {"".join(f"{one} : float" + chr(10) + "    " for one in question.arguments)}
    Returns
    -------
    {"dask array (...)" if question.single else "dict of dask arrays: " + ", ".join(question.fields)}
        The same bits as on one machine. {"" if question.single else "Compute fields together (``dask.compute(answer)``): what is asked for alone is cast again."}
    """
    return lazy


cast_rays = _lazy("cast_rays")
test_occlusions = _lazy("test_occlusions")
count_intersections = _lazy("count_intersections")
compute_closest_points = _lazy("compute_closest_points")
compute_distance = _lazy("compute_distance")
compute_signed_distance = _lazy("compute_signed_distance")
compute_occupancy = _lazy("compute_occupancy")


def run_rays(
    ref: SceneRef | Path,
    rays: da.Array | Path,
    out: Path,
    *,
    question: str = "cast_rays",
    fields: Iterable[str] | None = None,
    client: Client | None = None,
    threads: int | None = None,
    retries: int = 3,
    progress: Callable[[Progress], object] | bool | None = None,
    patience: float = 300.0,
    block: int = 1_000_000,
    **arguments: float,
) -> Report:
    """Asks a question for every row of `rays` and has the workers write the answers into the folder `out`.

    The same call again goes on where this one ended, whatever ended it: blocks whose files are still as they were written are
    skipped. The results are the same bytes on any number of machines.

    Parameters
    ----------
    ref : SceneRef, or path
    rays : dask array (N, 6), or the path of an ``.npy`` file that all workers see
        (N, 3) for questions about points. To go on, a dask array must have the same name as before: make it of a seed, not of
        ``random()``.
    out : path
        A folder that this process and all workers share.
    question : str
        ``cast_rays`` or another one of this module.
    fields : list of str
        Which fields to keep; all if not said. All of ``cast_rays`` are 33 bytes a ray.
    client : distributed.Client
        If not said, the current one; without any, the work is done in this process.
    threads : int
        Of each task: 1 on a cluster, all in this process.
    retries : int
        How often a block that fails is tried again.
    progress : callable or bool
        Called with a :class:`boxwood.cluster.Progress` after each block; if not said, a line on stderr if that is a terminal.
    patience : float
        Seconds to wait while there is no worker.
    block : int
        Rows of a block of a file; a dask array has its own blocks.

    Returns
    -------
    Report

    Raises
    ------
    JobRefused
        If `out` has a job that asked for something else; the error names what differs.
    BlocksFailed
        If some blocks failed in the end, with their numbers; all others are saved.
    ClusterLost
        If the scheduler or all workers went away. The same call goes on.
    """
    pool, ref = _pool(client, patience), reference_of(ref)
    running: dict[str, Any] = {"retries": retries, "progress": progress}
    if isinstance(rays, (str, os.PathLike)):
        asked: dict[str, Any] = {"question": question, "fields": fields, "block": block, "arguments": arguments}
        return ask_file(ref, rays, out, pool, threads=threads, **asked, **running)
    rays = _whole_rows(question, rays)
    if rays.ndim != 2 or any(math.isnan(size) for size in rays.shape):
        raise ValueError(f"a job needs an array of two axes and known length, not {rays.shape}")
    work = RaysWork(
        ref,
        question,
        (0, *np.cumsum(rays.chunks[0]).tolist()),
        str(rays.dtype),
        fields_of(question, fields),
        numbers_of(question, arguments),
        name=rays.name,
        threads=pool.threads if threads is None else threads,
    )
    handed = rays.to_delayed().ravel()
    return run(work, out, pool, rows=lambda index: handed[index], **running)


def render(
    ref: SceneRef | Path,
    out: Path,
    size: Sequence[int] = (960, 540),
    *,
    cameras: Cameras | None = None,
    frames: Iterable[int] | None = None,
    tile: int | Sequence[int] | None = None,
    client: Client | None = None,
    threads: int | None = None,
    retries: int = 3,
    progress: Callable[[Progress], object] | bool | None = None,
    patience: float = 300.0,
    **looks: Any,
) -> Report:
    """Makes a picture, or many, as :meth:`boxwood.Scene.render` does, in the folder `out`: ``frames/0000.png`` and so on.

    The files are the bytes of ``scene.render(...).png()`` in one process, on any number of machines and however cut into tiles.
    The same call again goes on where this one ended.

    Parameters
    ----------
    ref : SceneRef, or path
    out : path
        A folder that this process and all workers share.
    size : (int, int)
        Width and height in pixels.
    cameras : dict or list of dict
        ``eye``, ``target``, ``up``, ``fov_deg``; a list has one for each frame. What is not said is looked for anew in each
        task: say all of it where tiles are small.
    frames : iterable of int
        Which of the cameras; all if not said.
    tile : int or (int, int)
        Cuts pictures into tiles of this size, a task for each; else a task is a picture. Not for ``depth`` and ``heat-*``, whose
        scale is that of the whole picture.
    client, threads, retries, progress, patience
        As for :func:`run_rays`.
    looks
        ``shading``, ``samples``, ``seed``, ``max_depth``, ``lights``, ``sky``, ``floor``, ``exposure``, ``top``, ``log``.

    Returns
    -------
    Report

    Raises
    ------
    JobRefused, BlocksFailed, ClusterLost
        As :func:`run_rays`.
    """
    asked: dict[str, Any] = {"size": size, "cameras": cameras, "frames": frames, "tile": tile, "looks": looks}
    running: dict[str, Any] = {"threads": threads, "retries": retries, "progress": progress}
    return jobs.render(reference_of(ref), out, _pool(client, patience), **asked, **running)


def read(folder: Path) -> dict[str, da.Array]:
    """The results of a job as dask arrays, a file for each block.

    Raises
    ------
    ValueError
        If there is no job, or not all of its blocks are finished.
    """
    place = JobFolder(folder)
    job, receipts = place.job(), place.finished()
    if job["kind"] != "rays":
        raise ValueError(f"{place.path}: its results are the pictures in {os.path.join(place.path, 'frames')}")
    missing = sorted(set(range(job["blocks"])) - set(receipts))
    if missing:
        missed = f"{len(missing)} of {job['blocks']} blocks are missing, the first is {missing[0]}"
        raise ValueError(f"{place.path}: {missed}: run the job again to have them")
    starts = starts_of(job["rays"])
    lengths = tuple(b - a for a, b in zip(starts, starts[1:]))
    files = [place.file(receipts[index]) for index in range(job["blocks"])]
    # By their hashes, so that another job in the same folder is another array.
    key = tokenize(files, [receipts[index]["sha256"] for index in range(job["blocks"])])
    known = question_of(job["question"]).fields
    return {field: _stored(files, field, *known[field], lengths, f"boxwood-{field}-{key}") for field in job["fields"]}


def _stored(files: list[str], field: str, kind: Any, behind: tuple[int, ...], lengths: tuple[int, ...], key: str) -> da.Array:
    """A field of all blocks' files."""
    meta = np.empty((0,) * (1 + len(behind)), kind)
    chunks = (lengths, *((n,) for n in behind))
    return da.map_blocks(_load, files, field, chunks=chunks, dtype=kind, meta=meta, name=key)


#: numpy reads a header by Python's own parser, which in 3.11 counts the depths of several threads as one and then fails, now and then
#: ("AST constructor recursion depth mismatch"): blocks are read one at a time.
_ONE_READER = threading.Lock()


def _load(files: list[str], field: str, block_info: Any = None) -> NDArray[Any]:
    with _ONE_READER, np.load(files[block_info[None]["chunk-location"][0]]) as file:
        stored: NDArray[Any] = file[field]
        return stored


def _ask(rows: NDArray[Any], name: str, ref: SceneRef, threads: int, arguments: dict[str, float]) -> dict[str, NDArray[Any]]:
    return ask(reference.open(ref), name, rows, threads, arguments)


def _field(answers: da.Array, field: str, kind: Any, behind: tuple[int, ...]) -> da.Array:
    """A field of answers that are dicts."""
    axes = list(range(answers.ndim, answers.ndim + len(behind)))
    chunks = answers.chunks + tuple((n,) for n in behind)
    meta = np.empty((0,) * len(chunks), kind)
    key = f"{answers.name}-{field}"
    return answers.map_blocks(_of, field, new_axis=axes or None, chunks=chunks, dtype=kind, meta=meta, name=key)


def _of(answer: dict[str, NDArray[Any]], field: str) -> NDArray[Any]:
    return answer[field]


def _whole_rows(name: str, rows: Any) -> da.Array:
    """`rows` with the last axis in one block."""
    if not isinstance(rows, da.Array):
        example = "da.from_array(array, chunks=(1_000_000, 6))"
        raise TypeError(f"give a dask array, as by {example}, not {type(rows).__name__}; arrays in memory are for boxwood.Scene")
    check_rows(name, rows.shape, rows.dtype)
    return rows.rechunk({rows.ndim - 1: -1})


def _pool(client: Client | None, patience: float) -> Pool:
    if client is None:
        import distributed

        try:
            client = distributed.get_client()
        except ValueError:
            return InProcess()
    return Cluster(client, patience)
