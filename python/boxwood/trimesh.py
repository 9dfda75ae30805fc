"""A drop-in for trimesh's ray queries: ``mesh.ray = boxwood.trimesh.RayMeshIntersector(mesh)``."""

import numpy as np

from .arrays import INVALID_ID
from .scene import Scene

__all__ = ["RayMeshIntersector"]


class RayMeshIntersector:
    """trimesh's ray interface over Boxwood: all hits in one walk, each triangle once, edges and corners included.

    Parameters
    ----------
    geometry : trimesh.Trimesh
        Its vertices and faces are read now; after a change make a new one.
    """

    def __init__(self, geometry, **options):
        self.mesh = geometry
        self._scene = Scene(**options)
        self._scene.add_triangles(geometry.vertices, geometry.faces)

    def __repr__(self):
        return f"<boxwood.trimesh.RayMeshIntersector of {self._scene!r}>"

    def intersects_id(self, ray_origins, ray_directions, return_locations=False, multiple_hits=True, max_hits=None, **_):
        """Triangle and ray of each hit, ordered by ray and distance: ``index_tri`` (h,), ``index_ray`` (h,), and with
        ``return_locations`` the places (h, 3). With ``max_hits`` the first so many of each ray.
        """
        rays = _rays(ray_origins, ray_directions)
        if multiple_hits:
            found = self._scene.list_intersections(rays)
            ray, tri, t = found["ray_ids"], found["primitive_ids"], found["t_hit"]
            if max_hits is not None:
                rank = np.arange(len(ray)) - found["ray_splits"][ray]
                keep = rank < max_hits
                ray, tri, t = ray[keep], tri[keep], t[keep]
        else:
            found = self._scene.cast_rays(rays)
            ray = np.flatnonzero(found["hit"])
            tri, t = found["primitive_ids"][ray], found["t_hit"][ray]
        tri = tri.astype(np.int64)
        if return_locations:
            return tri, ray, rays[ray, :3] + t[:, None].astype(np.float64) * rays[ray, 3:]
        return tri, ray

    def intersects_location(self, ray_origins, ray_directions, multiple_hits=True, **_):
        """Places (h, 3), rays (h,) and triangles (h,) of all hits, or of the first of each ray."""
        tri, ray, places = self.intersects_id(ray_origins, ray_directions, return_locations=True, multiple_hits=multiple_hits)
        return places, ray, tri

    def intersects_first(self, ray_origins, ray_directions, **_):
        """The first triangle of each ray (n,), -1 where there is none."""
        ids = self._scene.cast_rays(_rays(ray_origins, ray_directions))["primitive_ids"]
        return np.where(ids == INVALID_ID, -1, ids.astype(np.int64))

    def intersects_any(self, ray_origins, ray_directions, **_):
        """True for each ray (n,) that meets anything."""
        return self._scene.test_occlusions(_rays(ray_origins, ray_directions))

    def contains_points(self, points):
        """True for each point (n, 3) inside a closed mesh."""
        return self._scene.compute_occupancy(np.asarray(points)) > 0


def _rays(origins, directions):
    """(n, 6) in double precision; one origin or one direction may serve for all."""
    origins, directions = np.broadcast_arrays(np.asarray(origins, np.float64), np.asarray(directions, np.float64))
    return np.concatenate([origins.reshape(-1, 3), directions.reshape(-1, 3)], axis=1)
