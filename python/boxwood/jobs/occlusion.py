"""How open a surface is to what is around it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..scene import Scene
from .arguments import count_of, scene_of, together
from .sampling import GOLDEN, hemisphere

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["ambient_occlusion", "vertex_normals"]

#: Rays in one go, so that memory stays small.
_MOST = 1 << 20


def ambient_occlusion(
    scene: Scene,
    points: ArrayLike,
    normals: ArrayLike,
    *,
    rays: int = 64,
    distance: float = np.inf,
    offset: float | None = None,
    seed: int = 0,
    threads: int | None = None,
) -> NDArray[np.float32]:
    """How much of the hemisphere above each point is open, weighted by the cosine: 1 on a free plane, 1/2 at the foot of a wall,
    1/4 in the corner of a room.

    It is ``1/pi * integral of V(w) cos(theta) dw`` over the hemisphere about the normal, where V is 1 if nothing is met within
    `distance` in direction w (Zhukov, Iones and Kronin, "An ambient light illumination model", EGWR 1998; Landis, "Production-ready
    global illumination", SIGGRAPH 2002 course 16). Many say "ambient occlusion" to one minus that.

    Parameters
    ----------
    points, normals : arrays (..., 3)
        Usually the vertices of a mesh and their normals (:func:`vertex_normals`); normals of any length but zero.
    rays : int
        For each point. They follow a low-discrepancy sequence, which is turned by another angle for each point.
    distance : float
        What is farther away hides nothing.
    offset : float
        How far along the normal the rays start, so as not to meet the surface they start on; usually 1e-4 of the scene's diagonal.

    Returns
    -------
    array (...) of float32
        NaN where a point or its normal is not finite, or the normal is zero, as at a vertex that no triangle uses.
    """
    scene_of(scene)
    places, up = together("points", points, "normals", normals)
    low, high = scene.bounds
    lift = 1e-4 * float(np.linalg.norm(high - low)) if offset is None else offset
    ways = hemisphere(count_of(rays, "rays"), seed)
    flat, tops = places.reshape(-1, 3), up.reshape(-1, 3)
    open_share = np.empty(len(flat), np.float32)
    step = max(1, _MOST // len(ways))
    for start in range(0, len(flat), step):
        piece = slice(start, start + step)
        numbers = np.arange(start, start + len(flat[piece]))
        open_share[piece] = _open(scene, flat[piece], tops[piece], numbers, ways, lift, distance, threads)
    return open_share.reshape(places.shape[:-1])


def vertex_normals(vertices: ArrayLike, triangles: ArrayLike) -> NDArray[np.float64]:
    """Unit normals (V, 3) of vertices: the normals of the triangles around, weighted by their angles there (Thuermer and
    Wuethrich, "Computing vertex normals from polygonal facets", 1998); zero where there are none."""
    positions, corners = np.asarray(vertices, np.float64), np.asarray(triangles)
    places = positions[corners]
    face = np.cross(places[:, 1] - places[:, 0], places[:, 2] - places[:, 0])
    face = _unit(face)
    normals = np.zeros_like(positions)
    for corner in range(3):
        one = _unit(places[:, (corner + 1) % 3] - places[:, corner])
        other = _unit(places[:, (corner + 2) % 3] - places[:, corner])
        angle = np.arccos(np.clip(np.sum(one * other, axis=1), -1, 1))
        np.add.at(normals, corners[:, corner], face * angle[:, None])
    return _unit(normals)


def _open(
    scene: Scene,
    places: NDArray[np.float64],
    up: NDArray[np.float64],
    numbers: NDArray[np.int64],
    ways: NDArray[np.float64],
    lift: float,
    distance: float,
    threads: int | None,
) -> NDArray[np.float32]:
    z = _unit(up)
    known = np.isfinite(places).all(axis=1) & (np.abs(np.linalg.norm(z, axis=1) - 1) < 0.5)
    # Two more axes at right angles, from any that is far from the normal.
    helper = np.where(np.abs(z[:, :1]) < 0.7, [[1.0, 0, 0]], [[0, 1.0, 0]])
    x = _unit(np.cross(helper, z))
    y = np.cross(z, x)
    angle = 2 * np.pi * (numbers * GOLDEN % 1.0)
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    x, y = cos * x + sin * y, cos * y - sin * x
    directions = np.einsum("rk,kpi->pri", ways, np.stack([x, y, z]))
    origins = np.broadcast_to((places + lift * z)[:, None, :], directions.shape)
    hidden = scene.test_occlusions(np.concatenate([origins, directions], axis=-1), tfar=distance, threads=threads)
    share = 1 - hidden.mean(axis=1)
    return np.where(known, share, np.nan).astype(np.float32)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of length 1; zero and what is not finite stay."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(length > 0, vectors / np.where(length > 0, length, 1), vectors))
