"""Whatever users have, as contiguous arrays; and answers into arrays that users bring."""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING, Any, Mapping

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._native import Rays

#: The number of what does not exist, as in Open3D.
INVALID_ID = np.uint32(0xFFFFFFFF)


def vertices_of(data: ArrayLike) -> NDArray[Any]:
    """(V, 3) positions as float32 or float64, copied."""
    array = np.array(filled(data), copy=True, order="C")
    if array.dtype.kind not in "fiu":
        raise TypeError(f"vertices must be numbers, not {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"vertices must have the shape (V, 3), not {array.shape}")
    return array if array.dtype == np.float32 else array.astype(np.float64)


def triangles_of(data: ArrayLike, count: int) -> NDArray[np.uint32]:
    """(F, 3) indices as uint32; `count` vertices are there."""
    # Copied first, and then looked at: another thread may write into what was given.
    array = np.array(data, order="C", copy=True)
    if array.size == 0:
        return np.zeros((0, 3), np.uint32)
    if array.dtype.kind not in "iu":
        raise TypeError(f"triangles must be whole numbers, not {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"triangles must have the shape (F, 3), not {array.shape}")
    # Before the type is changed: there -1 would be a large number.
    least, most = int(array.min()), int(array.max())
    if least < 0 or most >= count:
        raise ValueError(f"a triangle refers to vertex {least if least < 0 else most} of {count}")
    return array.astype(np.uint32, copy=False)


def leading(data: ArrayLike, columns: int, what: str) -> tuple[NDArray[Any], tuple[int, ...]]:
    """`data` (..., columns) as a contiguous array of float32 or float64, and the shape before the last axis.

    An array that is so already is passed on as it is, not as a view: the native part looks up its memory and copies it in one
    step, in which no other thread can resize it.
    """
    array = np.asarray(filled(data))
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{what} must be numbers, not {array.dtype}")
    if array.ndim == 0 or array.shape[-1] != columns:
        raise ValueError(f"{what} must have the shape (..., {columns}), not {array.shape}")
    single_precision = array.dtype.kind == "f" and array.dtype.itemsize == 4
    return _plain(array, np.float32 if single_precision else np.float64), array.shape[:-1]


def rays_of(rays: ArrayLike, tnear: ArrayLike, tfar: ArrayLike) -> tuple[Rays, tuple[int, ...]]:
    """Rays with their limits as the native part wants them, and the shape of one number for each."""
    flat, shape = leading(rays, 6, "rays")
    return (flat, _limit(tnear, shape, "tnear"), _limit(tfar, shape, "tfar")), shape


def _limit(value: ArrayLike, shape: tuple[int, ...], what: str) -> float | NDArray[np.float32]:
    """One number, or as many as there are rays."""
    array = np.asarray(filled(value))
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{what} must be a number or an array of numbers, not {array.dtype}")
    if array.ndim == 0:
        return float(array)
    if not array.size and not np.prod(shape):
        return np.zeros(0, np.float32)
    try:
        each = np.broadcast_to(array, shape)
    except ValueError:
        raise ValueError(f"{what} of shape {array.shape} does not go with rays of shape {shape}") from None
    with np.errstate(over="ignore"):
        return _plain(each, np.float32).reshape(-1)


def _plain(array: NDArray[Any], dtype: Any) -> NDArray[Any]:
    """Contiguous, aligned, of the machine's byte order; the array itself if it is so already."""
    plain = np.ascontiguousarray(array, dtype)
    return plain if plain.flags.aligned else plain.copy()


def threads_of(threads: Any) -> int:
    """A number of threads; 0: as many as the machine has."""
    count = operator.index(threads)
    if not 0 <= count <= 1024:
        raise ValueError(f"threads must be from 0 to 1024, not {threads}")
    return count


def is_single(array: NDArray[np.float64]) -> bool:
    """True if float32 holds every number of a float64 array as it is."""
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.all((array.astype(np.float32) == array) | np.isnan(array)))


class Out:
    """Arrays that a caller wants to be filled: looked at before the work, written after it has succeeded.

    Raises
    ------
    TypeError
        If an array has another type than the answer.
    ValueError
        If an array has another shape, is read-only or not contiguous, is named twice, or overlaps what is asked about; or if
        there is no answer of that name.
    """

    def __init__(self, arrays: Mapping[str, Any] | None, answers: Mapping[str, tuple[Any, tuple[int, ...]]], inputs: list[Any]) -> None:
        self._arrays = dict(arrays or {})
        for name, array in self._arrays.items():
            if name not in answers:
                raise ValueError(f"there is no answer {name!r} to write: {', '.join(answers)}")
            _check(array, name, *answers[name])
        given = [array for array in inputs if isinstance(array, np.ndarray)]
        for name, array in self._arrays.items():
            others = [other for key, other in self._arrays.items() if key != name]
            if any(np.may_share_memory(array, other) for other in given + others):
                raise ValueError(f"out[{name!r}] shares memory with another array")

    def fill(self, answer: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        """The answer, in the caller's arrays where there are any."""
        for name, array in self._arrays.items():
            np.copyto(array, answer[name], casting="no")
            answer[name] = array
        return answer


def _check(array: Any, name: str, dtype: Any, shape: tuple[int, ...]) -> None:
    what = f"out[{name!r}]"
    if not isinstance(array, np.ndarray) or isinstance(array, np.ma.MaskedArray):
        raise TypeError(f"{what} must be a numpy array, not {type(array).__name__}")
    if array.dtype != np.dtype(dtype):
        raise TypeError(f"{what} must be of type {np.dtype(dtype)}, not {array.dtype}")
    if array.shape != shape:
        raise ValueError(f"{what} must have the shape {shape}, not {array.shape}")
    if not array.flags.writeable or not array.flags.c_contiguous:
        raise ValueError(f"{what} must be writable and C-contiguous")


def filled(data: Any) -> Any:
    """Masked numbers are not known: NaN, which nothing meets."""
    if isinstance(data, np.ma.MaskedArray) and data.dtype.kind in "fiu":
        wide = data if data.dtype == np.float32 else data.astype(np.float64)
        return np.ma.filled(wide, np.nan)
    return data


def out_of(array: Any, dtype: Any, shape: tuple[int, ...], inputs: list[Any]) -> Out:
    """For calls with one answer."""
    return Out(None if array is None else {"out": array}, {"out": (dtype, shape)}, inputs)
