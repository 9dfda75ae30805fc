"""What a depth camera sees."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from ..camera import pinhole
from ..scene import Scene
from .arguments import count_of, scene_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["depth_image"]


def depth_image(
    scene: Scene,
    size: tuple[int, int] = (640, 480),
    *,
    eye: ArrayLike | None = None,
    target: ArrayLike | None = None,
    up: ArrayLike | None = None,
    fov_deg: float | None = None,
    kind: Literal["depth", "distance"] = "depth",
    threads: int | None = None,
) -> NDArray[np.float32]:
    """The depth of each pixel of a pinhole camera.

    Parameters
    ----------
    size : (int, int)
        Width and height in pixels.
    eye, target, up, fov_deg
        As for :meth:`boxwood.Scene.render`, with the vertical field of view; what is not said is found as there.
    kind : {"depth", "distance"}
        ``depth``: along the axis of the camera, as depth cameras and z-buffers have it. ``distance``: along the pixel's own ray,
        as in :attr:`boxwood.Picture.depth`.

    Returns
    -------
    array (height, width) of float32
        In the unit of the scene, inf where nothing is hit; row 0 on top.
    """
    scene_of(scene)
    if kind not in ("depth", "distance"):
        raise ValueError(f"kind must be 'depth' or 'distance', not {kind!r}")
    width, height = (count_of(number, "size") for number in size)
    camera = scene.camera((width, height), eye=eye, target=target, up=up, fov_deg=fov_deg)
    wide = 2 * np.arctan(np.tan(np.radians(camera["fov_deg"]) / 2) * width / height)
    rays = pinhole(
        fov_deg=float(np.degrees(wide)),
        center=camera["target"],
        eye=camera["eye"],
        up=camera["up"],
        width_px=width,
        height_px=height,
        dtype=np.float64,
    )
    # Directions have depth 1, so t is the depth.
    depth: NDArray[np.float32] = scene.cast_rays(rays, threads=threads)["t_hit"]
    if kind == "distance":
        depth = (depth * np.linalg.norm(rays[..., 3:], axis=-1)).astype(np.float32)
    return depth
