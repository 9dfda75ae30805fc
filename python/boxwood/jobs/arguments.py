"""What jobs are given, looked at before they begin."""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING, Any

import numpy as np

from ..scene import Scene

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


def scene_of(scene: Any) -> None:
    """Raises unless it is a scene."""
    if not isinstance(scene, Scene):
        raise TypeError(f"a job asks a boxwood.Scene, as of boxwood.Scene.load(path), not {type(scene).__name__}")


def count_of(number: int, what: str) -> int:
    """A number of rays or pixels: at least one."""
    count = operator.index(number)
    if count < 1:
        raise ValueError(f"{what} must be 1 or more, not {number}")
    return count


def together(
    first_name: str, first: ArrayLike, second_name: str, second: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Two arrays (..., 3), broadcast against each other."""
    one, other = np.asarray(first, np.float64), np.asarray(second, np.float64)
    for name, array in ((first_name, one), (second_name, other)):
        if array.ndim == 0 or array.shape[-1] != 3:
            raise ValueError(f"{name} must have the shape (..., 3), not {array.shape}")
    try:
        both = np.broadcast_arrays(one, other)
    except ValueError:
        raise ValueError(f"{first_name} {one.shape} and {second_name} {other.shape} do not go together") from None
    return both[0], both[1]
