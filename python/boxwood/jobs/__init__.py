"""Ready-made jobs: what people do with rays, each in one call, documented with its formula and source.

Every job is deterministic: directions come from a low-discrepancy sequence with a seed, and answers do not depend on the number of
threads.
"""

from .depth import depth_image
from .lidar import Spinning, lidar_scan
from .occlusion import ambient_occlusion, vertex_normals
from .sight import line_of_sight
from .sky import sky_view_factor
from .terrain import Terrain
from .view import viewshed

__all__ = [
    "Spinning",
    "Terrain",
    "ambient_occlusion",
    "depth_image",
    "lidar_scan",
    "line_of_sight",
    "sky_view_factor",
    "vertex_normals",
    "viewshed",
]
