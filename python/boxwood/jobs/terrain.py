"""Elevation grids as scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..scene import Scene

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["Terrain"]


class Terrain:
    """A grid of elevations as a surface of triangles.

    Row 0 is the north edge, column 0 the west edge; x points east, y north, z up. The elevation of each cell stands at its
    centre: cell (row, column) at ``(column * width, -row * height, elevation)``. Four neighbours make two triangles, cut from
    north-west to south-east. Cells that are NaN or masked are holes.

    Parameters
    ----------
    elevation : array (rows, columns)
        In the unit of `cell_size`.
    cell_size : float or (float, float)
        Width (east) and height (north) of a cell.

    Attributes
    ----------
    scene : Scene
    points : array (rows, columns, 3) of float64
        The centres of the cells on the surface; their elevations are above the middle of all, :attr:`datum`.
    """

    def __init__(self, elevation: ArrayLike, cell_size: float | tuple[float, float] = 1.0) -> None:
        heights = _heights(elevation)
        width, height = np.broadcast_to(np.asarray(cell_size, np.float64), 2).tolist()
        if not (0 < width < np.inf and 0 < height < np.inf):
            raise ValueError(f"cell_size must be above 0, not {cell_size}")
        self.cell_size = (width, height)
        self.shape: tuple[int, int] = (heights.shape[0], heights.shape[1])
        known = heights[np.isfinite(heights)]
        #: What is subtracted from all elevations, so that single precision keeps the digits of those that matter.
        self.datum = float(known.min() / 2 + known.max() / 2) if known.size else 0.0
        rows, columns = self.shape
        x, y = np.meshgrid(np.arange(columns) * width, -np.arange(rows) * height)
        self.points: NDArray[np.float64] = np.stack([x, y, heights - self.datum], axis=-1)
        self.scene = Scene()
        self.scene.add_triangles(self.points.reshape(-1, 3).astype(np.float32), self.triangles())

    def triangles(self) -> NDArray[np.uint32]:
        """(2 (rows - 1) (columns - 1), 3) numbers of cells, row by row; counter-clockwise seen from above."""
        rows, columns = self.shape
        number = np.arange(rows * columns, dtype=np.uint32).reshape(rows, columns)
        nw, ne, sw, se = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
        both = np.stack([nw, sw, se, nw, se, ne], axis=-1)
        return np.ascontiguousarray(both.reshape(-1, 3))

    def curved(self, row: int, column: int, radius: float, refraction: float) -> Terrain:
        """The terrain as it looks from a cell on a ball of this radius; see :func:`boxwood.jobs.viewshed`."""
        away = self.points[..., :2] - self.points[row, column, :2]
        drop = (1 - refraction) * np.sum(away * away, axis=-1) / (2 * radius)
        return Terrain(self.points[..., 2] - drop, self.cell_size)


def _heights(elevation: Any) -> NDArray[np.float64]:
    if isinstance(elevation, np.ma.MaskedArray):
        elevation = np.ma.filled(elevation.astype(np.float64), np.nan)
    heights = np.asarray(elevation)
    if heights.dtype.kind not in "fiu":
        raise TypeError(f"elevations must be numbers, not {heights.dtype}")
    if heights.ndim != 2:
        raise ValueError(f"elevations must have the shape (rows, columns), not {heights.shape}")
    return heights.astype(np.float64)
