"""Directions that fill the hemisphere evenly."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: The real root of x^3 = x + 1, which is to two dimensions what the golden ratio is to one.
_PLASTIC = 1.32471795724474602596

#: Of the golden ratio: multiples of it are spread evenly over a circle.
GOLDEN = 0.61803398874989484820


def pairs(count: int, seed: int) -> NDArray[np.float64]:
    """(count, 2) numbers in [0, 1), spread evenly: the sequence R2 of Roberts, "The Unreasonable Effectiveness of Quasirandom
    Sequences", 2018, shifted by what `seed` says (Cranley and Patterson, 1976)."""
    steps = np.array([1 / _PLASTIC, 1 / _PLASTIC**2])
    start = np.random.default_rng(seed).random(2)
    return np.asarray((start + np.arange(1, count + 1)[:, None] * steps) % 1.0)


def hemisphere(count: int, seed: int, *, cosine: bool = True) -> NDArray[np.float64]:
    """(count, 3) unit directions with z > 0: as dense as the cosine to the z axis (Malley's method), or even over the solid
    angle."""
    first, second = pairs(count, seed).T
    # Never quite horizontal: a direction within the surface says nothing.
    z = np.maximum(np.sqrt(1 - first) if cosine else 1 - first, 1e-6)
    radius, angle = np.sqrt(1 - z * z), 2 * np.pi * second
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)
