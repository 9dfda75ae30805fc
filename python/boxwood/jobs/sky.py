"""How much of the sky the ground sees."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from .arguments import count_of
from .sampling import hemisphere
from .terrain import Terrain

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["sky_view_factor"]

#: Rays in one go, so that memory stays small.
_MOST = 1 << 19


def sky_view_factor(
    elevation: Terrain | ArrayLike,
    *,
    cell_size: float | tuple[float, float] = 1.0,
    directions: int = 256,
    weight: Literal["cosine", "solid_angle"] = "cosine",
    height: float = 0.0,
    max_distance: float = np.inf,
    seed: int = 0,
    threads: int | None = None,
) -> NDArray[np.float32]:
    """The sky view factor of each cell: 1 on a plain, 0.5 at the foot of a long wall, towards 0 in a pit.

    With `weight` "cosine" it is ``1/pi * integral of V(w) cos(theta) dw`` over the upper hemisphere, where V is 1 if the sky is seen
    in direction w and theta the angle to the zenith: the view factor of a horizontal patch, for radiation (Oke, "Canyon geometry
    and the nocturnal urban heat island", 1981; Johnson and Watson, 1984). With "solid_angle" it is ``1/(2 pi) * integral of V(w) dw``,
    the share of the hemisphere, for relief maps (Zaksek, Ostir and Kokalj, "Sky-view factor as a relief visualization technique",
    Remote Sensing 3, 2011).

    Each cell asks along the same directions of a low-discrepancy sequence; the error falls about as 1 / `directions`.

    Parameters
    ----------
    elevation : array (rows, columns), or Terrain
        In the unit of `cell_size`; NaN and masked cells are holes. Row 0 is the north.
    cell_size : float or (float, float)
        Width and height of a cell; not looked at with a Terrain, which has its own.
    directions : int
        How many rays for each cell.
    height : float
        Above the ground.
    max_distance : float
        What is farther away hides nothing.

    Returns
    -------
    array (rows, columns) of float32
        NaN in holes. Beyond the edge of the grid there is nothing but sky: leave out a margin as wide as the terrain is high.
    """
    if weight not in ("cosine", "solid_angle"):
        raise ValueError(f"weight must be 'cosine' or 'solid_angle', not {weight!r}")
    terrain = elevation if isinstance(elevation, Terrain) else Terrain(elevation, cell_size)
    ways = hemisphere(count_of(directions, "directions"), seed, cosine=weight == "cosine")
    # The rays start a little above the ground, such that those into a slope meet it; by more than single precision rounds off.
    rounding = 4 * np.spacing(np.float32(np.nanmax(np.abs(terrain.points), initial=0)))
    lift = height + max(1e-3 * min(terrain.cell_size), float(rounding))
    starts = (terrain.points + [0, 0, lift]).astype(np.float32)
    seen = np.zeros(terrain.shape, np.int64)
    # One direction for all cells beside each other: such rays go through the same boxes.
    step = max(1, _MOST // max(1, seen.size))
    for first in range(0, len(ways), step):
        some = ways[first : first + step, None, None].astype(np.float32)
        rays = np.concatenate(np.broadcast_arrays(starts, some), axis=-1)
        seen += np.sum(~terrain.scene.test_occlusions(rays, tfar=max_distance, threads=threads), axis=0)
    share = (seen / len(ways)).astype(np.float32)
    share[~np.isfinite(terrain.points[..., 2])] = np.nan
    return share
