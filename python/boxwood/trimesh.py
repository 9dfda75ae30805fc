"""A drop-in for trimesh's ray queries: ``mesh.ray = boxwood.trimesh.RayMeshIntersector(mesh)``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._native import NativeScene
from .arrays import filled, leading
from .scene import Scene

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._native import Lines

__all__ = ["RayMeshIntersector"]


class RayMeshIntersector:
    """trimesh's ray interface over Boxwood: all hits in one walk, each triangle once, edges and corners included.

    A ray that runs exactly along the outline of a mesh, as along the edge of a box, passes it on one side by a fixed rule: it enters
    and leaves, or does neither, and never half of both. trimesh's Embree counts all of those as hits.

    Parameters
    ----------
    geometry : trimesh.Trimesh
        Its vertices and faces are read at the first question, and again when they have changed since. A copy of the mesh has
        trimesh's own ray again.
    scale_to_box, **options
        ``scale_to_box`` is for who comes from trimesh's Embree: exact answers need no scale. Others go to
        :class:`boxwood.Scene`.
    """

    def __init__(self, geometry: Any, scale_to_box: bool = True, **options: Any) -> None:
        # By its class, too: a primitive asks for its ray before it has faces.
        if not (hasattr(type(geometry), "faces") or hasattr(geometry, "faces")):
            several = ": scene.to_mesh() makes one of it" if hasattr(geometry, "geometry") else ""
            raise TypeError(f"give a trimesh.Trimesh, not {type(geometry).__name__}{several}")
        self.mesh = geometry
        self._options = options
        self._read: tuple[Any, Scene] | None = None

    def __repr__(self) -> str:
        return f"<boxwood.trimesh.RayMeshIntersector of {self.mesh!r}>"

    def __copy__(self, *_: Any) -> RayMeshIntersector:
        return RayMeshIntersector(self.mesh, **self._options)

    def __deepcopy__(self, *_: Any) -> RayMeshIntersector:
        return self.__copy__()

    @property
    def _scene(self) -> Scene:
        """Of the mesh as it is now."""
        state = hash(self.mesh) if hasattr(self.mesh, "__hash__") and hasattr(self.mesh, "visual") else None
        if self._read is None or self._read[0] != state:
            scene = Scene(**self._options)
            scene.add_triangles(self.mesh.vertices, self.mesh.faces)
            self._read = state, scene
        return self._read[1]

    def intersects_id(
        self,
        ray_origins: ArrayLike,
        ray_directions: ArrayLike,
        return_locations: bool = False,
        multiple_hits: bool = True,
        max_hits: int | None = None,
        **_: Any,
    ) -> Any:
        """Triangle and ray of each hit, ordered by ray and distance: ``index_tri`` (h,), ``index_ray`` (h,), int64, and with
        ``return_locations`` the places (h, 3), float64. With ``max_hits`` the first so many of each ray.
        """
        if not multiple_hits:
            firsts = self._scene._of_lines(NativeScene.first_places, _lines(ray_origins, ray_directions))
            return firsts if return_locations else firsts[:2]
        rays = _rays(ray_origins, ray_directions)
        found = self._scene.list_intersections(rays)
        ray, tri, t = found["ray_ids"], found["primitive_ids"], found["t_hit"]
        if max_hits is not None:
            rank = np.arange(len(ray)) - found["ray_splits"][ray]
            keep = rank < max_hits
            ray, tri, t = ray[keep], tri[keep], t[keep]
        index_tri = tri.astype(np.int64)
        if return_locations:
            hit = rays[ray].astype(np.float64)
            return index_tri, ray, hit[:, :3] + t[:, None] * hit[:, 3:]
        return index_tri, ray

    def intersects_location(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike, multiple_hits: bool = True, **options: Any
    ) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
        """Places (h, 3) float64, rays (h,) and triangles (h,), int64, of all hits, or of the first of each ray."""
        options.pop("return_locations", None)
        tri, ray, places = self.intersects_id(
            ray_origins, ray_directions, return_locations=True, multiple_hits=multiple_hits, **options
        )
        return places, ray, tri

    def intersects_first(self, ray_origins: ArrayLike, ray_directions: ArrayLike, **_: Any) -> NDArray[np.int64]:
        """The first triangle of each ray (n,), int64, -1 where there is none."""
        first: NDArray[np.int64] = self._scene._of_lines(NativeScene.first, _lines(ray_origins, ray_directions))
        return first

    def intersects_any(self, ray_origins: ArrayLike, ray_directions: ArrayLike, **_: Any) -> NDArray[np.bool_]:
        """True for each ray (n,) that meets anything."""
        return self._scene.test_occlusions(_rays(ray_origins, ray_directions))

    def contains_points(self, points: ArrayLike) -> NDArray[np.bool_]:
        """True for each point (n, 3) inside a closed mesh."""
        inside: NDArray[np.bool_] = self._scene.compute_occupancy(points) > 0
        return inside


def _rays(ray_origins: ArrayLike, ray_directions: ArrayLike) -> NDArray[Any]:
    """(n, 6) in the precision that was given."""
    return np.concatenate([each.reshape(-1, 3) for each in _lines(ray_origins, ray_directions)], axis=1)


def _lines(ray_origins: ArrayLike, ray_directions: ArrayLike) -> Lines:
    """Twice (..., 3) as the native part wants them; one origin or one direction may serve for all."""
    origins, directions = np.broadcast_arrays(np.asarray(filled(ray_origins)), np.asarray(filled(ray_directions)))
    return leading(origins, 3, "origins")[0], leading(directions, 3, "directions")[0]
