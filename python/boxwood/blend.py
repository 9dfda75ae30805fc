"""What vertices carry, blended at hits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Sequence

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

from .notes import Faces


def blend(values: Any, faces: Sequence[Faces], hits: dict[str, NDArray[Any]]) -> NDArray[Any]:
    """(n, ...) of `values` (V, ...), or of a list of such arrays, one for each mesh; NaN where nothing is hit."""
    lists = values if isinstance(values, (list, tuple)) else [values]
    if len(lists) != len(faces):
        raise ValueError(f"{len(lists)} arrays for {len(faces)} geometries")
    arrays = [np.asarray(one) for one in lists]
    if not arrays:
        return np.full(len(hits["hit"]), np.nan, np.float32)
    for one, (count, _) in zip(arrays, faces):
        if one.dtype.kind not in "fiu":
            raise TypeError(f"what is to be interpolated must be numbers, not {one.dtype}")
        if one.ndim == 0 or len(one) != count:
            raise ValueError(f"{len(one) if one.ndim else 1} values for {count} vertices")
        if one.shape[1:] != arrays[0].shape[1:]:
            raise ValueError(f"values of shape {one.shape[1:]} and {arrays[0].shape[1:]} do not go together")
    found = np.flatnonzero(hits["hit"])
    result = np.full((len(hits["hit"]), *arrays[0].shape[1:]), np.nan, np.result_type(np.float32, *arrays))
    for number, (one, (_, triangles)) in enumerate(zip(arrays, faces)):
        mine = found if len(arrays) == 1 else found[hits["geometry_ids"][found] == number]
        corners = triangles[hits["primitive_ids"][mine]]
        u, v = (hits["primitive_uvs"][mine, k].reshape(-1, *[1] * (one.ndim - 1)) for k in (0, 1))
        result[mine] = (1 - u - v) * one[corners[:, 0]] + u * one[corners[:, 1]] + v * one[corners[:, 2]]
    return result
