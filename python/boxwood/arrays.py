"""Whatever users have, as contiguous arrays that nobody else can change."""

import numpy as np

INVALID_ID = np.uint32(0xFFFFFFFF)


def vertices_of(data):
    """(V, 3) positions as float32 or float64, copied."""
    array = np.array(data, copy=True, order="C")
    if array.dtype.kind not in "fiu":
        raise TypeError(f"vertices must be numbers, not {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"vertices must have the shape (V, 3), not {array.shape}")
    return array if array.dtype == np.float32 else array.astype(np.float64)


def triangles_of(data, count):
    """(F, 3) indices as uint32; `count` vertices are there."""
    array = np.asarray(data)
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
    return np.array(array, dtype=np.uint32, order="C", copy=True)


def leading(data, columns, what):
    """`data` as (n, columns) of float32 or float64, and the shape before the last axis."""
    array = np.asarray(data)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{what} must be numbers, not {array.dtype}")
    if array.ndim == 0 or array.shape[-1] != columns:
        raise ValueError(f"{what} must have the shape (..., {columns}), not {array.shape}")
    if array.dtype != np.float32:
        array = array.astype(np.float64)
    shape = array.shape[:-1]
    return array.reshape(int(np.prod(shape)), columns), shape


def is_single(array):
    """True if float32 holds every number of a float64 array as it is."""
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.all((array.astype(np.float32) == array) | np.isnan(array)))


def single(array, origin=None):
    """A contiguous float32 array; what float64 has is first moved by `-origin` in the first three columns."""
    if origin is not None and np.any(origin):
        array = array.astype(np.float64)
        array[:, :3] -= origin
    with np.errstate(over="ignore", invalid="ignore"):
        return np.ascontiguousarray(array, dtype=np.float32)
