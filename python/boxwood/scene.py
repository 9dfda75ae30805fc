"""A scene of triangle meshes and the questions about it, by the names of Open3D's ``RaycastingScene``."""

import threading

import numpy as np

from ._native import NativeScene, load
from .arrays import INVALID_ID, is_single, leading, single, triangles_of, vertices_of

__all__ = ["INVALID_ID", "Scene"]


class Scene:
    """Triangle meshes, ready to be asked.

    A scene is built when the first question comes, and again after meshes were added. All questions may be asked from several
    threads at once; they let the interpreter go while they work.

    Arrays of any type and stride are taken. Single precision is used as it is. Vertices in double precision that single precision
    would round, such as map coordinates, are moved to the middle of the scene first, and rays and points with them
    (:attr:`origin`).

    Parameters
    ----------
    quality : {"fast", "default", "high"}
        How much work a build is worth.
    threads : int
        For builds, and for questions that do not say; 0: as many as the machine has.
    """

    INVALID_ID = INVALID_ID

    def __init__(self, *, quality="default", threads=0):
        self._quality = quality
        self._threads = _threads(threads)
        self._meshes = []
        self._looks = {}
        self._native = None
        self._studio = None
        self._origin = np.zeros(3)
        self._lock = threading.Lock()

    @classmethod
    def load(cls, path, **options):
        """A scene of the file at `path`: OBJ, PLY, STL, glTF, GLB, or ``builtin:bush``. :meth:`render` shows its materials.

        Warnings of the reader are given as :class:`UserWarning`.
        """
        import os
        import warnings

        positions, indices, looks, told = load(os.fspath(path))
        for text in told:
            warnings.warn(text, stacklevel=2)
        scene = cls(**options)
        scene._looks[scene.add_triangles(positions, indices)] = looks
        return scene

    def add_triangles(self, vertex_positions, triangle_indices=None):
        """Adds a mesh and returns its geometry id.

        Parameters
        ----------
        vertex_positions : array (V, 3), or (F, 3, 3) without indices
        triangle_indices : array (F, 3) of whole numbers
        """
        if triangle_indices is None:
            soup = np.asarray(vertex_positions)
            if soup.ndim != 3 or soup.shape[1:] != (3, 3):
                raise ValueError(f"triangles without indices must have the shape (F, 3, 3), not {soup.shape}")
            vertex_positions = soup.reshape(-1, 3)
            triangle_indices = np.arange(len(vertex_positions), dtype=np.uint32).reshape(-1, 3)
        vertices = vertices_of(vertex_positions)
        triangles = triangles_of(triangle_indices, len(vertices))
        with self._lock:
            self._meshes.append((vertices, triangles))
            self._native = None
            return len(self._meshes) - 1

    @property
    def origin(self):
        """What is subtracted from all coordinates before they become single precision: float64 (3,)."""
        self._built()
        return self._origin.copy()

    def cast_rays(self, rays, nthreads=None, *, interpolate=None):
        """The closest hit of each ray.

        Parameters
        ----------
        rays : array (..., 6)
            Origin and direction; a direction of any length but zero.
        interpolate : dict of name to array (V, ...), or list of such arrays, one for each geometry
            What vertices carry, to be blended at the hits; NaN where nothing is hit.

        Returns
        -------
        dict
            ``t_hit`` (...) in units of the direction, inf where nothing is hit; ``geometry_ids`` and ``primitive_ids`` (...),
            uint32, :data:`INVALID_ID` where nothing is hit; ``primitive_uvs`` (..., 2); ``primitive_normals`` (..., 3), unit;
            ``hit`` (...), bool; and what was to be interpolated.
        """
        native = self._built()
        flat, shape = self._rays(rays)
        t, geom, prim, uvs, normals = native.cast(flat, 0.0, np.inf, self._count(nthreads))
        hit = geom != INVALID_ID
        answer = {
            "t_hit": t.reshape(shape),
            "geometry_ids": geom.reshape(shape),
            "primitive_ids": prim.reshape(shape),
            "primitive_uvs": uvs.reshape(*shape, 2),
            "primitive_normals": normals.reshape(*shape, 3),
            "hit": hit.reshape(shape),
        }
        for name, values in (interpolate or {}).items():
            if name in answer:
                raise ValueError(f"{name!r} is an answer already: call it otherwise")
            blended = self._blend(values, geom, prim, uvs, hit)
            answer[name] = blended.reshape(*shape, *blended.shape[1:])
        return answer

    def test_occlusions(self, rays, tnear=0.0, tfar=np.inf, nthreads=None):
        """True for each ray (..., 6) that meets anything from ``tnear`` to ``tfar``."""
        native = self._built()
        flat, shape = self._rays(rays)
        return native.occluded(flat, float(tnear), float(tfar), self._count(nthreads)).reshape(shape)

    def count_intersections(self, rays, nthreads=None):
        """How many triangles each ray (..., 6) meets, int64; an edge that triangles share counts once."""
        native = self._built()
        flat, shape = self._rays(rays)
        return native.count(flat, 0.0, np.inf, self._count(nthreads)).reshape(shape)

    def list_intersections(self, rays, nthreads=None):
        """All hits of all rays (..., 6), those of one ray beside each other, nearest first.

        Returns
        -------
        dict
            ``ray_splits`` (n + 1,): the hits of ray ``i`` are ``ray_splits[i]:ray_splits[i + 1]``; and for each hit ``ray_ids``,
            ``t_hit``, ``geometry_ids``, ``primitive_ids``, ``primitive_uvs``.
        """
        native = self._built()
        flat, _ = self._rays(rays)
        names = ("ray_splits", "ray_ids", "t_hit", "geometry_ids", "primitive_ids", "primitive_uvs")
        return dict(zip(names, native.list(flat, 0.0, np.inf, self._count(nthreads))))

    def compute_closest_points(self, query_points, nthreads=None):
        """The place of the surface that is nearest to each point (..., 3).

        Returns
        -------
        dict
            ``points`` (..., 3), ``geometry_ids``, ``primitive_ids`` (...), ``primitive_uvs`` (..., 2), ``primitive_normals``
            (..., 3), ``distances`` (...).
        """
        native = self._built()
        flat, shape = self._points(query_points)
        points, distances, geom, prim, uvs, normals = native.nearest(flat, self._count(nthreads))
        if np.any(self._origin):
            points = points + self._origin
        return {
            "points": points.reshape(*shape, 3),
            "distances": distances.reshape(shape),
            "geometry_ids": geom.reshape(shape),
            "primitive_ids": prim.reshape(shape),
            "primitive_uvs": uvs.reshape(*shape, 2),
            "primitive_normals": normals.reshape(*shape, 3),
        }

    def compute_distance(self, query_points, nthreads=None):
        """The distance of each point (..., 3) to the surface."""
        return self.compute_closest_points(query_points, nthreads)["distances"]

    def compute_signed_distance(self, query_points, nthreads=None, nsamples=1):
        """The same, negative inside. Exact on closed meshes, so one sample is enough; ``nsamples`` is for who comes from Open3D."""
        native = self._built()
        flat, shape = self._points(query_points)
        return native.signed(flat, self._count(nthreads)).reshape(shape)

    def compute_occupancy(self, query_points, nthreads=None, nsamples=1):
        """1 for each point (..., 3) that is inside, else 0, float32. As exact as the sign of the distance."""
        native = self._built()
        flat, shape = self._points(query_points)
        return native.inside(flat, self._count(nthreads)).astype(np.float32).reshape(shape)

    @staticmethod
    def create_rays_pinhole(intrinsic_matrix=None, extrinsic_matrix=None, width_px=None, height_px=None, *, fov_deg=None, center=None, eye=None, up=None):
        """Rays (height, width, 6) of a pinhole camera, float32: by matrices (3, 3) and (4, 4), or by ``fov_deg`` (horizontal),
        ``center``, ``eye`` and ``up``. The rays of the centres of pixels; directions have depth 1.
        """
        if width_px is None or height_px is None:
            raise ValueError("width_px and height_px say how many rays there are")
        if intrinsic_matrix is None:
            if fov_deg is None or center is None or eye is None or up is None:
                raise ValueError("give both matrices, or fov_deg, center, eye and up")
            intrinsic_matrix, extrinsic_matrix = _matrices(fov_deg, center, eye, up, width_px, height_px)
        elif extrinsic_matrix is None:
            raise ValueError("an intrinsic matrix needs an extrinsic one")
        intrinsic = np.asarray(intrinsic_matrix, np.float64).reshape(3, 3)
        extrinsic = np.asarray(extrinsic_matrix, np.float64).reshape(4, 4)
        x, y = np.meshgrid(np.arange(width_px) + 0.5, np.arange(height_px) + 0.5)
        pixels = np.stack([x, y, np.ones_like(x)], axis=-1)
        turn = extrinsic[:3, :3].T
        directions = pixels @ np.linalg.inv(intrinsic).T @ turn.T
        origin = np.broadcast_to(-turn @ extrinsic[:3, 3], directions.shape)
        return np.concatenate([origin, directions], axis=-1).astype(np.float32)

    def render(
        self,
        size=(960, 540),
        *,
        eye=None,
        target=None,
        up=None,
        fov_deg=None,
        shading="whitted",
        samples=None,
        seed=0,
        crop=None,
        max_depth=8,
        lights=(),
        sky=None,
        floor=True,
        exposure=None,
        top=None,
        log=False,
        threads=None,
    ):
        """A picture of the scene.

        A scene that was loaded from a file shows its materials, textures and lights; meshes that were added are plain grey.
        Pictures are the same, bit for bit, for any number of threads and on every machine. Ctrl-C ends the work within a moment.

        Parameters
        ----------
        size : (int, int)
            Width and height in pixels, each up to 65,535.
        eye, target, up : array (3,)
            Where the camera stands, where it looks, and what is up in the picture. What is not said comes from the first camera
            of the file, or else is chosen such that the scene is seen well; :attr:`Picture.camera` tells.
        fov_deg : float
            Vertical field of view in degrees, above 0 and below 180.
        shading : str
            A name of :data:`boxwood.SHADINGS`: ``whitted`` (daylight, mirrors, shadows), ``path``, ``ao``, ``eyelight``,
            ``normal``, ``depth``, ``heat-tests`` and others.
        samples : int
            Per pixel; usually as many as the shading needs.
        seed : int
            Another seed gives another noise.
        crop : (int, int, int, int)
            Only this part: left, top, width and height in pixels. They are the same, bit for bit, as in the whole picture; for
            ``depth`` and ``heat-*`` the colour scale is that of the part (give ``top``, which ends the scale of ``heat-*``).
        max_depth : int
            Most bounces of light.
        lights : sequence of (x, y, z) or (x, y, z, power)
            Lamps; power 1 lights the middle of the scene as the sun does.
        sky : float
            Strength of sun and sky, 0 is night. Usually 1, but 0 in rooms with lights of their own.
        floor : bool
            Whether an object that is seen from outside by daylight stands on a floor.
        exposure : float
            In stops, 0 is neutral. Usually neutral by daylight, measured in rooms.
        top : float
            The number at the bright end of ``heat-*`` and ``depth``; usually from the picture.
        log : bool
            Whether those are coloured by the logarithm.

        Raises
        ------
        ValueError
            If there is nothing to show, or a number makes no sense.
        """
        wish = {
            "shading": shading,
            "samples": samples,
            "seed": seed,
            "crop": crop,
            "max_depth": max_depth,
            "lights": lights,
            "sky": sky,
            "floor": floor,
            "exposure": exposure,
            "top": top,
            "log": log,
        }
        return self._staged().render(size, (eye, target, up, fov_deg), wish, self._count(threads))

    def _repr_png_(self):
        """What a notebook shows: a small picture; nothing where there is nothing to show."""
        return self.render((640, 360)).png() if any(len(triangles) for _, triangles in self._meshes) else None

    def explain(self, ray):
        """How one ray (6,) finds its answer: every box and triangle looked at, as text."""
        native = self._built()
        flat, _ = self._rays(np.asarray(ray).reshape(1, -1))
        return native.explain(flat[0].tolist())

    @property
    def stats(self):
        """Triangles, those that can never be hit, nodes, leaves, depth, bytes and surface area cost of the tree, as a dict."""
        names = ("triangles", "skipped", "nodes", "leaves", "max_depth", "bytes", "sah_cost")
        return dict(zip(names, self._built().stats()))

    @property
    def bounds(self):
        """Smallest and largest corner, float64 (2, 3)."""
        return np.array(self._built().bounds(), np.float64) + self._origin

    def __getstate__(self):
        return {"quality": self._quality, "threads": self._threads, "meshes": self._meshes, "looks": self._looks}

    def __setstate__(self, state):
        self.__init__(quality=state["quality"], threads=state["threads"])
        self._meshes = state["meshes"]
        self._looks = state["looks"]

    def __repr__(self):
        triangles = sum(len(triangles) for _, triangles in self._meshes)
        return f"<boxwood.Scene: {len(self._meshes)} meshes, {triangles:,} triangles>"

    def _built(self):
        native = self._native
        if native is not None:
            return native
        with self._lock:
            if self._native is None:
                self._origin = _origin_of([vertices for vertices, _ in self._meshes])
                meshes = [(single(vertices, self._origin), triangles) for vertices, triangles in self._meshes]
                self._native = NativeScene(meshes, self._quality, self._threads)
            return self._native

    def _staged(self):
        """What pictures are made of, kept for the next one."""
        from .studio import Studio

        while True:
            native = self._built()
            with self._lock:
                # Another thread may have added a mesh in between.
                if self._native is not native:
                    continue
                if self._studio is None or self._studio.native_scene is not native:
                    self._studio = Studio(native, self._meshes, self._looks, self._origin, self._threads)
                return self._studio

    def _rays(self, rays):
        flat, shape = leading(rays, 6, "rays")
        return single(flat, self._origin), shape

    def _points(self, points):
        flat, shape = leading(points, 3, "points")
        return single(flat, self._origin), shape

    def _count(self, threads):
        return self._threads if threads is None else _threads(threads)

    def _blend(self, values, geom, prim, uvs, hit):
        lists = values if isinstance(values, (list, tuple)) else [values]
        if len(lists) != len(self._meshes):
            raise ValueError(f"{len(lists)} arrays for {len(self._meshes)} geometries")
        lists = [np.asarray(one) for one in lists]
        for one, (vertices, _) in zip(lists, self._meshes):
            if len(one) != len(vertices):
                raise ValueError(f"{len(one)} values for {len(vertices)} vertices")
        result = np.full((len(hit), *lists[0].shape[1:]), np.nan, np.result_type(np.float32, *lists))
        for number, (one, (_, triangles)) in enumerate(zip(lists, self._meshes)):
            mine = hit & (geom == number)
            corners = one[triangles[prim[mine]]]
            u, v = (uvs[mine, k].reshape(-1, *[1] * (one.ndim - 1)) for k in (0, 1))
            result[mine] = (1 - u - v) * corners[:, 0] + u * corners[:, 1] + v * corners[:, 2]
        return result


def _threads(threads):
    if not 0 <= int(threads) <= 1024:
        raise ValueError(f"threads must be from 0 to 1024, not {threads}")
    return int(threads)


def _origin_of(parts):
    """The middle of all vertices, if single precision would round any of them; else nothing is moved."""
    double = [part for part in parts if part.dtype == np.float64 and not is_single(part)]
    if not double:
        return np.zeros(3)
    everything = np.concatenate([part.astype(np.float64) for part in parts])
    finite = everything[np.isfinite(everything).all(axis=1)]
    if not len(finite):
        return np.zeros(3)
    return np.round((finite.min(axis=0) + finite.max(axis=0)) / 2)


def _matrices(fov_deg, center, eye, up, width, height):
    """Intrinsic and extrinsic matrix; x to the right, y down, z ahead."""
    center, eye, up = (np.asarray(place, np.float64) for place in (center, eye, up))
    ahead = center - eye
    right = np.cross(ahead, up)
    if not np.linalg.norm(ahead) or not np.linalg.norm(right):
        raise ValueError("center must not be eye, and up not the way that the camera looks")
    ahead, right = ahead / np.linalg.norm(ahead), right / np.linalg.norm(right)
    turn = np.stack([right, np.cross(ahead, right), ahead])
    extrinsic = np.eye(4)
    extrinsic[:3, :3], extrinsic[:3, 3] = turn, -turn @ eye
    focal = width / 2 / np.tan(np.radians(fov_deg) / 2)
    return np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]]), extrinsic
