"""Boxwood answers *what does this ray hit?*, exactly: one answer, bit for bit the same on every machine.

>>> import numpy as np, boxwood
>>> scene = boxwood.Scene()
>>> scene.add_triangles([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
0
>>> scene.cast_rays([[0.2, 0.2, 1, 0, 0, -1]])["t_hit"]
array([1.], dtype=float32)
"""

from ._native import __version__
from .picture import Picture
from .scene import INVALID_ID, Scene
from .studio import SHADINGS

__all__ = ["INVALID_ID", "SHADINGS", "Picture", "Scene", "__version__"]
