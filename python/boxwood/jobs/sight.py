"""Whether places see each other."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..scene import Scene
from .arguments import scene_of, together

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["line_of_sight"]


def line_of_sight(
    scene: Scene, a: ArrayLike, b: ArrayLike, *, margin: float = 1e-4, threads: int | None = None
) -> NDArray[np.bool_]:
    """True where nothing stands between `a` and `b`.

    Parameters
    ----------
    a, b : arrays (..., 3)
        Places; they are broadcast against each other, so ``a[:, None]`` and ``b[None]`` ask for all pairs.
    margin : float
        What is nearer to either end than this share of the way does not count, so that places may lie on surfaces. 0: the ends
        themselves count.

    Returns
    -------
    array (...) of bool
        A place sees itself. False where a place is not finite.
    """
    if not 0 <= margin < 0.5:
        raise ValueError(f"margin must be from 0 to below 0.5, not {margin}")
    scene_of(scene)
    first, second = together("a", a, "b", b)
    known = np.isfinite(first).all(axis=-1) & np.isfinite(second).all(axis=-1)
    with np.errstate(invalid="ignore"):
        rays = np.concatenate([first, second - first], axis=-1)
    hidden = scene.test_occlusions(rays, tnear=margin, tfar=1 - margin, threads=threads)
    return np.asarray(known & ~hidden)
