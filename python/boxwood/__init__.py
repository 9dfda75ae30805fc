"""Boxwood answers *what does this ray hit?*, exactly: one answer, bit for bit the same on every machine.

>>> import numpy as np, boxwood
>>> scene = boxwood.Scene()
>>> scene.add_triangles([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
0
>>> scene.cast_rays([[0.2, 0.2, 1, 0, 0, -1]])["t_hit"]
array([1.], dtype=float32)
"""

import importlib
from typing import Any

from ._native import __version__
from .picture import Picture
from .scene import INVALID_ID, Scene
from .studio import SHADINGS

__all__ = ["INVALID_ID", "SHADINGS", "Picture", "Scene", "__version__"]

#: Loaded when they are first named: not everybody needs them, and some need other packages.
_PARTS = ("cluster", "dask", "jobs", "trimesh")


def __getattr__(name: str) -> Any:
    if name in _PARTS:
        return importlib.import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*__all__, *_PARTS])
