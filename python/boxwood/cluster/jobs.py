"""Jobs by what users have: paths, numbers, dicts."""

from __future__ import annotations

import operator
import os
from typing import Any, Iterable, Mapping, Sequence

import numpy as np

from ..scene import Scene
from .pool import Pool
from .questions import numbers_of, question_of
from .rays import RaysWork, even_starts, table_file
from .reference import SceneRef
from .render import RenderWork
from .run import Report, run

Path = str | os.PathLike[str]
Cameras = Mapping[str, Any] | Sequence[Mapping[str, Any]]


def ask_file(
    ref: SceneRef,
    path: Path,
    out: Path,
    pool: Pool,
    *,
    question: str = "cast_rays",
    fields: Iterable[str] | None = None,
    block: int = 1_000_000,
    threads: int | None = None,
    arguments: Mapping[str, float] | None = None,
    **running: Any,
) -> Report:
    """Asks a question for every row of an ``.npy`` file that all workers see; `running` is for :func:`run`."""
    path = os.path.abspath(os.fspath(path))
    array = table_file(path, question)
    work = RaysWork(
        ref,
        question,
        even_starts(len(array), block),
        str(array.dtype),
        fields_of(question, fields),
        numbers_of(question, arguments or {}),
        path=path,
        threads=pool.threads if threads is None else threads,
    )
    return run(work, out, pool, **running)


def render(
    ref: SceneRef,
    out: Path,
    pool: Pool,
    *,
    size: Sequence[int] = (960, 540),
    cameras: Cameras | None = None,
    frames: Iterable[int] | None = None,
    tile: int | Sequence[int] | None = None,
    threads: int | None = None,
    looks: Mapping[str, Any] | None = None,
    **running: Any,
) -> Report:
    """Makes pictures. `cameras` is a dict, or a list of them of which `frames` are wanted; `running` is for :func:`run`."""
    known = [cameras or {}] if cameras is None or isinstance(cameras, Mapping) else list(cameras)
    wanted = list(range(len(known))) if frames is None else [operator.index(frame) for frame in frames]
    for frame in wanted:
        if not 0 <= frame < len(known):
            raise ValueError(f"there is no camera for frame {frame}: {len(known)} cameras make the frames 0 to {len(known) - 1}")
    if not wanted:
        raise ValueError("no frames are wanted")
    if len(set(wanted)) < len(wanted):
        raise ValueError("a frame is wanted twice")
    work = RenderWork(
        ref,
        _pair("size", size),
        tuple(wanted),
        tuple(plain(dict(known[frame])) for frame in wanted),
        None if tile is None else _pair("tile", (tile, tile) if isinstance(tile, int) else tile),
        {name: plain(value) for name, value in (looks or {}).items()},
        pool.threads if threads is None else threads,
    )
    return run(work, out, pool, **running)


def reference_of(ref: SceneRef | Path) -> SceneRef:
    """`ref`, or a reference to the file at a path."""
    if isinstance(ref, Scene):
        raise TypeError("give a reference that workers can open: SceneRef.save(scene, path), with a path that all of them see")
    return ref if isinstance(ref, SceneRef) else SceneRef.of(ref)


def fields_of(question: str, fields: Iterable[str] | None) -> tuple[str, ...]:
    """The fields to keep: all if not said."""
    return tuple(question_of(question).fields if fields is None else fields)


def plain(value: Any) -> Any:
    """Arrays and tuples as lists, as JSON has them."""
    if isinstance(value, dict):
        return {name: plain(one) for name, one in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    return [plain(one) for one in value] if isinstance(value, (list, tuple)) else value


def _pair(what: str, numbers: Sequence[int]) -> tuple[int, int]:
    whole = [operator.index(number) for number in numbers]
    if len(whole) != 2:
        raise ValueError(f"{what} must be two whole numbers, not {numbers}")
    return whole[0], whole[1]
