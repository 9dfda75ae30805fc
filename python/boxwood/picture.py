"""Pictures: what :meth:`boxwood.Scene.render` gives."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ._native import Camera, NativePicture

__all__ = ["Picture"]


class Picture:
    """A finished picture of a scene, with what is known about each pixel. In a notebook it shows itself.

    The arrays are made when asked for; each has the rows of the picture from the top down.
    """

    def __init__(self, native: NativePicture, starts: NDArray[np.int64], origin: NDArray[np.float64]) -> None:
        self._native = native
        self._starts = starts
        self._origin = origin

    @property
    def pixels(self) -> NDArray[np.uint8]:
        """(h, w, 3) uint8, sRGB: exposed and tone-mapped as in the PNG, but without the legend that :meth:`save` draws into
        pictures with a colour scale."""
        return self._native.pixels()

    @property
    def linear(self) -> NDArray[np.float32]:
        """(h, w, 3) float32: linear light, Rec. 709 primaries, before exposure."""
        return self._native.linear()

    @property
    def depth(self) -> NDArray[np.float32]:
        """(h, w) float32: the distance from the eye along the ray through the pixel's centre, inf where nothing is hit. The depth
        along the camera's axis, as depth cameras have it, is :func:`boxwood.jobs.depth_image`."""
        return self._native.depth().reshape(self.shape)

    @property
    def normals(self) -> NDArray[np.float32]:
        """(h, w, 3) float32: unit normals on the side of the eye, interpolated where a file has normals; zero where nothing is
        hit."""
        return self._native.normals()

    @property
    def primitive_ids(self) -> NDArray[np.uint32]:
        """(h, w) uint32: the triangle within its mesh, :data:`boxwood.INVALID_ID` where nothing is hit."""
        return self._ids()[1]

    @property
    def geometry_ids(self) -> NDArray[np.uint32]:
        """(h, w) uint32: the mesh, :data:`boxwood.INVALID_ID` where nothing is hit."""
        return self._ids()[0]

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width in pixels."""
        (_, _, width, height), _ = self._native.window()
        return height, width

    @property
    def crop(self) -> tuple[int, int, int, int]:
        """Left, top, width and height of this picture within the full one, in pixels."""
        left, top, width, height = self._native.window()[0]
        return left, top, width, height

    @property
    def full_size(self) -> tuple[int, int]:
        """Width and height in pixels of the picture that this is a crop of, or the same."""
        width, height = self._native.window()[1]
        return width, height

    @property
    def camera(self) -> dict[str, Any]:
        """``eye``, ``target``, ``up``: float64 (3,); ``fov_deg``: the vertical field of view. As :meth:`boxwood.Scene.render`
        takes them."""
        return camera_of(self._native.camera(), self._origin)

    def png(self) -> bytes:
        """The bytes of a PNG file."""
        return self._native.png()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes ``.png``, or ``.exr`` with all layers in linear light. Whoever reads `path` sees the old file or the whole new
        one.

        Raises
        ------
        ValueError
            If the name ends in something else.
        OSError
            If the file cannot be written; what was there before still is.
        """
        name = os.fspath(path)
        ending = os.path.splitext(name)[1].lower()
        if ending not in (".png", ".exr"):
            raise ValueError(f"{name}: a picture is saved as .png or .exr")
        self._native.save(name, ending == ".exr")

    def __reduce__(self) -> str | tuple[Any, ...]:
        raise TypeError("a picture does not go through pickle: send its pixels, or save it as .exr")

    def _repr_png_(self) -> bytes:
        return self.png()

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """:attr:`pixels`, so that ``matplotlib.pyplot.imshow(picture)`` works."""
        return np.asarray(self.pixels, dtype)

    def __repr__(self) -> str:
        height, width = self.shape
        return f"<boxwood.Picture: {width} x {height} pixels>"

    def _ids(self) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
        """Geometries and primitives, from numbers that count through all meshes."""
        number = self._native.prims()
        nothing = np.uint32(0xFFFFFFFF)
        hit = number != nothing
        geometry = np.searchsorted(self._starts, number, side="right") - 1
        primitive = number - self._starts[geometry]
        both = (np.where(hit, ids, nothing).astype(np.uint32).reshape(self.shape) for ids in (geometry, primitive))
        geometry_ids, primitive_ids = both
        return geometry_ids, primitive_ids


def camera_of(camera: Camera, origin: NDArray[np.float64]) -> dict[str, Any]:
    """In the coordinates of the user, as keywords."""
    eye, target, up, fov = camera
    return {
        "eye": np.array(eye, np.float64) + origin,
        "target": np.array(target, np.float64) + origin,
        "up": np.array(up, np.float64),
        "fov_deg": fov,
    }
