"""What :meth:`boxwood.Scene.render` was asked for, checked and put into the words of the native part."""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING, Any, Sequence

import numpy as np

from ._native import SHADINGS as _SHADINGS
from ._native import NativeStudio
from .picture import Picture, camera_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._native import NativeLooks, NativeScene, Place

__all__ = ["SHADINGS", "Studio"]

#: What a picture can show: names and meanings.
SHADINGS: dict[str, str] = dict(_SHADINGS)


class Studio:
    """The meshes of a scene as the renderer wants them: one mesh, with looks."""

    def __init__(
        self,
        native: NativeScene,
        meshes: Sequence[tuple[NDArray[Any], NDArray[np.uint32]]],
        looks: dict[int, NativeLooks],
        origin: NDArray[np.float64],
        threads: int,
    ) -> None:
        self.native_scene = native
        self._origin = origin
        counts = [len(triangles) for _, triangles in meshes]
        self._empty = not sum(counts)
        self._starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        parts = [(vertices, triangles, looks.get(number)) for number, (vertices, triangles) in enumerate(meshes)]
        self._native = NativeStudio(native, parts, (origin[0], origin[1], origin[2]), threads)

    def camera(self, size: Any, place: tuple[Any, Any, Any, Any], threads: int) -> dict[str, Any]:
        """What :attr:`Picture.camera` of :meth:`render` would say."""
        width, height = _whole(size, 2, "size")
        return camera_of(self._native.camera([width, height], self._where(place), threads), self._origin)

    def render(self, size: Any, place: tuple[Any, Any, Any, Any], wish: dict[str, Any], threads: int) -> Picture:
        if self._empty:
            raise ValueError("the scene has no triangles to show")
        where = self._where(place)
        wish["crop"] = None if wish["crop"] is None else _whole(wish["crop"], 4, "crop")
        wish["samples"] = None if wish["samples"] is None else operator.index(wish["samples"])
        wish["seed"], wish["max_depth"] = operator.index(wish["seed"]), operator.index(wish["max_depth"])
        wish["lights"] = [self._lamp(lamp) for lamp in wish["lights"]]
        width, height = _whole(size, 2, "size")
        return Picture(self._native.render([width, height], where, wish, threads), self._starts, self._origin)

    def _where(self, place: tuple[Any, Any, Any, Any]) -> Place:
        eye, target, up, fov = place
        return self._moved(eye, "eye"), self._moved(target, "target"), _triple(up, "up"), None if fov is None else float(fov)

    def _lamp(self, lamp: ArrayLike) -> tuple[list[float], float]:
        numbers = np.asarray(lamp, np.float64)
        if numbers.shape not in ((3,), (4,)) or not np.isfinite(numbers).all():
            raise ValueError("a light is x, y, z and, if not 1, its power")
        power = float(numbers[3]) if len(numbers) == 4 else 1.0
        if power < 0:
            raise ValueError("the power of a light is 0 or more")
        return (numbers[:3] - self._origin).tolist(), power

    def _moved(self, place: ArrayLike | None, what: str) -> list[float] | None:
        triple = _triple(place, what)
        return None if triple is None else (np.array(triple) - self._origin).tolist()


def _triple(place: ArrayLike | None, what: str) -> list[float] | None:
    if place is None:
        return None
    array = np.asarray(place, np.float64)
    if array.shape != (3,):
        raise ValueError(f"{what} must be three numbers, not an array of shape {array.shape}")
    numbers: list[float] = array.tolist()
    return numbers


def _whole(numbers: Any, count: int, what: str) -> list[int]:
    """So many whole numbers from 0 to 2^32 - 1."""
    whole = [operator.index(number) for number in numbers]
    if len(whole) != count or not all(0 <= number < 2**32 for number in whole):
        raise ValueError(f"{what} must be {count} whole numbers, 0 or more, not {numbers}")
    return whole
