"""Rays of a pinhole camera."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["pinhole"]


def pinhole(
    intrinsic_matrix: ArrayLike | None = None,
    extrinsic_matrix: ArrayLike | None = None,
    width_px: int | None = None,
    height_px: int | None = None,
    *,
    fov_deg: float | None = None,
    center: ArrayLike | None = None,
    eye: ArrayLike | None = None,
    up: ArrayLike | None = None,
    dtype: Any = np.float32,
) -> NDArray[Any]:
    """See :meth:`boxwood.Scene.create_rays_pinhole`."""
    if width_px is None or height_px is None:
        raise ValueError("width_px and height_px say how many rays there are")
    if intrinsic_matrix is None:
        if fov_deg is None or center is None or eye is None or up is None:
            raise ValueError("give both matrices, or fov_deg, center, eye and up")
        intrinsic_matrix, extrinsic_matrix = _matrices(fov_deg, center, eye, up, width_px, height_px)
    elif extrinsic_matrix is None:
        raise ValueError("an intrinsic matrix needs an extrinsic one")
    intrinsic = np.asarray(intrinsic_matrix, np.float64).reshape(3, 3)
    extrinsic = np.asarray(extrinsic_matrix, np.float64).reshape(4, 4)
    x, y = np.meshgrid(np.arange(width_px) + 0.5, np.arange(height_px) + 0.5)
    pixels = np.stack([x, y, np.ones_like(x)], axis=-1)
    turn = extrinsic[:3, :3].T
    try:
        backwards = np.linalg.inv(intrinsic)
    except np.linalg.LinAlgError:
        raise ValueError("the intrinsic matrix cannot be inverted") from None
    directions = pixels @ backwards.T @ turn.T
    origin = np.broadcast_to(-turn @ extrinsic[:3, 3], directions.shape)
    return np.concatenate([origin, directions], axis=-1).astype(dtype)


def _matrices(
    fov_deg: float, center: ArrayLike, eye: ArrayLike, up: ArrayLike, width: int, height: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Intrinsic and extrinsic matrix; x to the right, y down, z ahead."""
    look, stand, sky = (np.asarray(place, np.float64).reshape(3) for place in (center, eye, up))
    ahead = look - stand
    right = np.cross(ahead, sky)
    if not np.linalg.norm(ahead) or not np.linalg.norm(right):
        raise ValueError("center must not be eye, and up not the way that the camera looks")
    if not 0 < fov_deg < 180:
        raise ValueError(f"fov_deg must be above 0 and below 180, not {fov_deg}")
    ahead, right = ahead / np.linalg.norm(ahead), right / np.linalg.norm(right)
    turn = np.stack([right, np.cross(ahead, right), ahead])
    extrinsic = np.eye(4)
    extrinsic[:3, :3], extrinsic[:3, 3] = turn, -turn @ stand
    focal = width / 2 / np.tan(np.radians(fov_deg) / 2)
    return np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]]), extrinsic
