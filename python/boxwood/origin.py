"""What is subtracted from large coordinates before they become single precision."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .arrays import is_single

if TYPE_CHECKING:
    from numpy.typing import NDArray


def origin_of(parts: list[NDArray[Any]]) -> NDArray[np.float64]:
    """The middle of all vertices, if single precision would round any of them; else nothing is moved."""
    double = [part for part in parts if part.dtype == np.float64 and not is_single(part)]
    if not double:
        return np.zeros(3)
    least, most = np.full(3, np.inf), np.full(3, -np.inf)
    for part in parts:
        finite = part[np.isfinite(part).all(axis=1)]
        if len(finite):
            least, most = np.minimum(least, finite.min(axis=0)), np.maximum(most, finite.max(axis=0))
    # Halves first: the sum may be beyond the largest number.
    middle = np.round(least / 2 + most / 2)
    return middle if np.isfinite(middle).all() else np.zeros(3)
