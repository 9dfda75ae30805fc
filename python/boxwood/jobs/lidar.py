"""What a spinning lidar measures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..scene import Scene
from .arguments import count_of, scene_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["Spinning", "lidar_scan"]


@dataclass(frozen=True)
class Spinning:
    """Beams above each other on a head that spins about the sensor's z axis; x is ahead, y to the left.

    The defaults are those of a sensor of 16 beams from -15 to 15 degrees, such as the Velodyne VLP-16.

    Parameters
    ----------
    beams : int
        How many, evenly spaced in elevation.
    lowest_deg, highest_deg : float
        Elevation of the outermost beams.
    azimuths : int
        Firings in a turn.
    from_deg, to_deg : float
        The part of the turn, counter-clockwise seen from above; `to_deg` is not included.
    """

    beams: int = 16
    lowest_deg: float = -15.0
    highest_deg: float = 15.0
    azimuths: int = 1024
    from_deg: float = 0.0
    to_deg: float = 360.0

    def __post_init__(self) -> None:
        count_of(self.beams, "beams")
        count_of(self.azimuths, "azimuths")

    def directions(self) -> NDArray[np.float64]:
        """Unit directions in the sensor's frame, (azimuths, beams, 3)."""
        turn = np.radians(np.linspace(self.from_deg, self.to_deg, self.azimuths, endpoint=False))[:, None]
        rise = np.radians(np.linspace(self.lowest_deg, self.highest_deg, self.beams))[None, :]
        parts = [np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise) + 0 * turn]
        return np.stack(parts, axis=-1)


def lidar_scan(
    scene: Scene,
    poses: ArrayLike,
    pattern: Spinning | ArrayLike = Spinning(),
    *,
    min_range: float = 0.0,
    max_range: float = np.inf,
    range_noise: float = 0.0,
    reflectivity: float = 1.0,
    seed: int = 0,
    threads: int | None = None,
) -> dict[str, NDArray[Any]]:
    """What a lidar measures from each pose.

    Parameters
    ----------
    poses : array (4, 4) or (..., 4, 4)
        Where the sensor stands and how it is turned: rigid matrices world_from_sensor, in the unit of the scene. The head spins
        about the sensor's z axis: ``np.eye(4)`` is upright where z is up; where y is up, as in most models,
        ``[[1, 0, 0, x], [0, 0, 1, y], [0, -1, 0, z], [0, 0, 0, 1]]`` stands upright at (x, y, z).
    pattern : Spinning, or array (..., 3)
        Directions of the beams in the sensor's frame.
    min_range, max_range : float
        Hits outside are not measured.
    range_noise : float
        Standard deviation of a normal error added to each range; none is measured below zero.
    reflectivity : float
        Of all surfaces, 0 to 1.
    seed : int
        Of the noise.

    Returns
    -------
    dict
        ``ranges`` (poses..., pattern...) float64, in the unit of the scene, inf where nothing is measured; ``intensities`` of the
        same shape, float64: reflectivity times the cosine of the angle of incidence, which is Lambert's law with the fall by the
        square of the range already taken out, as sensors report it (Kashani et al., "A review of LIDAR radiometric processing",
        Sensors 15, 2015); ``geometry_ids`` and ``primitive_ids`` of the same shape, uint32; and for each of h measured hits, in that
        order, ``points`` (h, 3) float64 in the world and ``ray_ids`` (h,) int64 into the flattened ranges.
    """
    scene_of(scene)
    if not 0 <= min_range <= max_range:
        raise ValueError(f"ranges must be 0 <= min_range <= max_range, not {min_range} and {max_range}")
    if not 0 <= range_noise < np.inf:
        raise ValueError(f"range_noise is a standard deviation, 0 or more, not {range_noise}")
    if not 0 <= reflectivity <= 1:
        raise ValueError(f"reflectivity must be from 0 to 1, not {reflectivity}")
    matrices = np.asarray(poses, np.float64)
    if matrices.ndim < 2 or matrices.shape[-2:] != (4, 4):
        raise ValueError(f"poses must have the shape (..., 4, 4), not {matrices.shape}")
    turn, place = matrices[..., :3, :3], matrices[..., :3, 3]
    if not np.allclose(turn @ np.swapaxes(turn, -1, -2), np.eye(3), atol=1e-5):
        raise ValueError("poses must be rigid: a rotation and a translation")
    beams = pattern.directions() if isinstance(pattern, Spinning) else np.asarray(pattern, np.float64)
    if beams.ndim < 1 or beams.shape[-1] != 3:
        raise ValueError(f"a pattern must have the shape (..., 3), not {beams.shape}")
    flat = beams.reshape(-1, 3) / np.linalg.norm(beams, axis=-1).reshape(-1, 1)
    directions = np.einsum("...ij,bj->...bi", turn, flat)
    origins = np.broadcast_to(place[..., None, :], directions.shape)
    hits = scene.cast_rays(np.concatenate([origins, directions], axis=-1), tnear=min_range, tfar=max_range, threads=threads)
    ranges = hits["t_hit"].astype(np.float64)
    if range_noise:
        ranges = np.maximum(ranges + range_noise * np.random.default_rng(seed).normal(size=ranges.shape), 0)
    incidence = np.abs(np.einsum("...i,...i->...", hits["primitive_normals"], directions))
    seen = hits["hit"]
    shape = (*matrices.shape[:-2], *beams.shape[:-1])
    return {
        "ranges": ranges.reshape(shape),
        "intensities": np.where(seen, reflectivity * incidence, 0.0).reshape(shape),
        "geometry_ids": hits["geometry_ids"].reshape(shape),
        "primitive_ids": hits["primitive_ids"].reshape(shape),
        "points": origins[seen] + ranges[seen][:, None] * directions[seen],
        "ray_ids": np.flatnonzero(seen),
    }
