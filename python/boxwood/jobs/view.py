"""What can be seen from a place in the terrain."""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING

import numpy as np

from .sight import line_of_sight
from .terrain import Terrain

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["viewshed"]


def viewshed(
    elevation: Terrain | ArrayLike,
    observer: tuple[int, int],
    *,
    cell_size: float | tuple[float, float] = 1.0,
    observer_height: float = 1.7,
    target_height: float = 0.0,
    max_distance: float = np.inf,
    earth_radius: float = np.inf,
    refraction: float = 0.0,
    threads: int | None = None,
) -> NDArray[np.bool_]:
    """True for each cell that an observer sees.

    The line of sight runs over the triangles between the centres of cells (see :class:`Terrain`), not over steps of cells, so
    nothing is approximated but the terrain itself.

    Parameters
    ----------
    elevation : array (rows, columns), or Terrain
        In the unit of `cell_size`; NaN and masked cells are holes, which hide nothing and are not seen. Row 0 is the north.
    observer : (int, int)
        Row and column of a cell.
    cell_size : float or (float, float)
        Width and height of a cell; not looked at with a Terrain, which has its own.
    observer_height, target_height : float
        Above the ground.
    max_distance : float
        What is farther away in the plane is not seen.
    earth_radius : float
        6,371,000 m takes the curvature of the Earth into account: a cell at distance d in the plane sinks by
        ``(1 - refraction) d^2 / (2 radius)``, as in common GIS (e.g. Yoeli, "The making of intervisibility maps with computer and
        plotter", Cartographica 22, 1985). Usually inf: flat.
    refraction : float
        How much of the curvature the bending of light in the air takes back; 0.13 for visible light.

    Returns
    -------
    array (rows, columns) of bool
        The observer's own cell is seen.
    """
    terrain = elevation if isinstance(elevation, Terrain) else Terrain(elevation, cell_size)
    rows, columns = terrain.shape
    try:
        row, column = (operator.index(number) for number in observer)
    except (TypeError, ValueError):
        raise TypeError(f"the observer is the row and the column of a cell, two whole numbers, not {observer!r}") from None
    if not (0 <= row < rows and 0 <= column < columns):
        raise ValueError(f"the observer ({row}, {column}) is not within {rows} x {columns} cells")
    if not earth_radius > 0:
        raise ValueError(f"earth_radius must be above 0, not {earth_radius}")
    if np.isfinite(earth_radius):
        terrain = terrain.curved(row, column, earth_radius, refraction)
    targets = terrain.points + [0, 0, target_height]
    eye = terrain.points[row, column] + [0, 0, observer_height]
    if not np.isfinite(eye).all():
        raise ValueError(f"the observer ({row}, {column}) stands in a hole")
    seen = line_of_sight(terrain.scene, eye, targets, threads=threads)
    away = np.linalg.norm(targets[..., :2] - eye[:2], axis=-1)
    seen &= away <= max_distance
    seen[row, column] = True
    return seen
