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
    """The meshes of a scene, moved by `-origin` unless they are already, as the renderer wants them: one mesh, with looks."""

    def __init__(
        self,
        native: NativeScene,
        meshes: Sequence[tuple[NDArray[Any], NDArray[np.uint32]]],
        looks: dict[int, NativeLooks],
        is_moved: bool,
        origin: NDArray[np.float64],
        threads: int,
    ) -> None:
        self.native_scene = native
        self._origin = origin
        counts = [len(triangles) for _, triangles in meshes]
        self._empty = not sum(counts)
        self._starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        parts = [(vertices, triangles, looks.get(number)) for number, (vertices, triangles) in enumerate(meshes)]
        self._native = NativeStudio(native, parts, (origin[0], origin[1], origin[2]), is_moved, threads)

    def camera(self, size: Any, place: tuple[Any, Any, Any, Any], threads: int) -> dict[str, Any]:
        """What :attr:`Picture.camera` of :meth:`render` would say."""
        width, height = _whole(size, 2, "size")
        return camera_of(self._native.camera([width, height], self._where(place), threads), self._origin)

    def render(self, size: Any, place: tuple[Any, Any, Any, Any], wish: dict[str, Any], threads: int) -> Picture:
        if self._empty:
            raise ValueError("the scene has no triangles to show")
        where = self._where(place)
        asked = {
            "shading": str(wish["shading"]),
            "samples": _count(wish["samples"], "samples", 2**32),
            "seed": _count(wish["seed"], "seed", 2**64),
            "crop": None if wish["crop"] is None else _whole(wish["crop"], 4, "crop"),
            "max_depth": _count(wish["max_depth"], "max_depth", 2**32),
            "lights": [self._lamp(lamp) for lamp in wish["lights"]],
            "sky": _real(wish["sky"], "sky", least=0.0),
            "floor": bool(wish["floor"]),
            "exposure": _real(wish["exposure"], "exposure"),
            "top": _real(wish["top"], "top", least=0.0),
            "log": bool(wish["log"]),
        }
        width, height = _whole(size, 2, "size")
        return Picture(self._native.render([width, height], where, asked, threads), self._starts, self._origin)

    def _where(self, place: tuple[Any, Any, Any, Any]) -> Place:
        eye, target, up, fov = place
        return self._moved(eye, "eye"), self._moved(target, "target"), _triple(up, "up"), _fov(fov)

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


def _fov(degrees: Any) -> float | None:
    """What is no angle of view is told by the renderer."""
    try:
        return None if degrees is None else float(degrees)
    except (TypeError, ValueError):
        raise TypeError(f"fov_deg must be a number, not {degrees!r}") from None


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
    try:
        whole = [operator.index(number) for number in numbers]
    except TypeError:
        raise TypeError(f"{what} must be {count} whole numbers, not {numbers!r}") from None
    if len(whole) != count or not all(0 <= number < 2**32 for number in whole):
        raise ValueError(f"{what} must be {count} whole numbers, 0 or more, not {numbers!r}")
    return whole


def _count(number: Any, what: str, limit: int) -> int | None:
    """A whole number from 0 to below a limit, if there is one."""
    if number is None:
        return None
    whole = operator.index(number)
    if not 0 <= whole < limit:
        raise ValueError(f"{what} must be from 0 to {limit - 1}, not {number}")
    return whole


def _real(number: Any, what: str, least: float = -np.inf) -> float | None:
    """A finite number, if there is one."""
    if number is None:
        return None
    real = float(number)
    if not (np.isfinite(real) and real >= least):
        raise ValueError(f"{what} must be a finite number{', 0 or more' if least == 0 else ''}, not {number}")
    return real
