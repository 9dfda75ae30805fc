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
        self._native = None
        self._is_opened = False
        self._origin = np.zeros(3)
        self._lock = threading.Lock()

    @classmethod
    def load(cls, path, **options):
        """A scene of the file at `path`: OBJ, PLY, STL, glTF, GLB, or ``builtin:bush``.

        Warnings of the reader are given as :class:`UserWarning`.
        """
        import os
        import warnings

        positions, indices, told = load(os.fspath(path))
        for text in told:
            warnings.warn(text, stacklevel=2)
        scene = cls(**options)
        scene.add_triangles(positions, indices)
        return scene

    @classmethod
    def open(cls, path, *, map=True, threads=0):
        """A scene that :meth:`save` wrote, without a build.

        It answers bit for bit like the one that was saved, and has its :attr:`origin`. All of the file is checked first; one that is damaged,
        or no scene, is a :class:`ValueError`.

        Parameters
        ----------
        path : str or path
        map : bool
            True: the file becomes memory, which all processes of this machine that open it share. It must not be written to or cut short while
            the scene is there: that would end the process. Replacing it, as :meth:`save` does, is no harm. False: it is copied, for files
            that others may write to.
        threads : int
            For opening, and for questions that do not say; 0: as many as the machine has.
        """
        import os

        return cls._of(NativeScene.open(os.fsdecode(path), bool(map), _threads(threads)), threads)

    @classmethod
    def from_buffer(cls, buffer, *, threads=0):
        """The scene in the bytes of a file, as :meth:`open`.

        ``bytes`` that begin at a multiple of 64 are read in place; anything else (an array, a memory map, shared memory), which
        somebody might change, is copied.
        """
        count = _threads(threads)
        if type(buffer) is bytes:
            return cls._of(NativeScene.of_bytes(buffer, count), threads)
        array = np.frombuffer(buffer, np.uint8)
        return cls._of(NativeScene.of_array(array, count), threads)

    @classmethod
    def _of(cls, native, threads):
        """A scene that is opened already."""
        quality = (native.note("quality") or b"default").decode("ascii", "replace")
        scene = cls(quality=quality, threads=threads)
        origin = np.frombuffer(native.note("origin") or bytes(24), np.uint8)
        if origin.size != 24 or not np.isfinite(origin.view("<f8")).all():
            raise ValueError("the file's note 'origin' is not three numbers: save the scene again")
        scene._native, scene._is_opened = native, True
        scene._origin = origin.view("<f8").astype(np.float64)
        return scene

    def save(self, path):
        """Writes the scene to the file `path`, which :meth:`open` opens without a build, and returns its :attr:`content_hash`.

        The file has some 100 bytes for each triangle. It is written beside `path` and renamed there, so that no reader ever sees a half.
        """
        import os

        return self._built().save(os.fsdecode(path), self._threads)

    @property
    def content_hash(self):
        """What :meth:`save` returns: 64 hexadecimal digits, the same for the same scene on every machine."""
        return self._built().content_hash(self._threads)

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
            if self._is_opened:
                raise ValueError("a scene from a file is complete: make a new Scene of all meshes")
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
        state = {"quality": self._quality, "threads": self._threads}
        if self._is_opened:
            return {**state, "file": self._native.to_bytes(self._threads)}
        # Smaller than the file, and soon built.
        return {**state, "meshes": self._meshes}

    def __setstate__(self, state):
        self.__init__(quality=state["quality"], threads=state["threads"])
        if "file" in state:
            self.__dict__.update(self.from_buffer(state["file"], threads=state["threads"]).__dict__)
        else:
            self._meshes = state["meshes"]

    def __repr__(self):
        lengths = self._native.mesh_lengths() if self._is_opened else [len(triangles) for _, triangles in self._meshes]
        return f"<boxwood.Scene: {len(lengths)} meshes, {sum(lengths):,} triangles>"

    def _built(self):
        native = self._native
        if native is not None:
            return native
        with self._lock:
            if self._native is None:
                self._origin = _origin_of([vertices for vertices, _ in self._meshes])
                meshes = [(single(vertices, self._origin), triangles) for vertices, triangles in self._meshes]
                self._native = NativeScene(meshes, self._quality, self._threads, self._notes())
            return self._native

    def _notes(self):
        """What a file has beside what Boxwood itself needs."""
        counts = np.array([len(vertices) for vertices, _ in self._meshes], "<u8")
        indices = [triangles.astype("<u4").tobytes() for _, triangles in self._meshes]
        return [
            ("origin", self._origin.astype("<f8").tobytes()),
            ("quality", self._quality.encode()),
            ("vertices", counts.tobytes()),
            ("indices", b"".join(indices)),
        ]

    def _faces(self):
        """Number of vertices and triangles of each geometry."""
        if not self._is_opened:
            return [(len(vertices), triangles) for vertices, triangles in self._meshes]
        counts, indices = self._native.note("vertices"), self._native.note("indices")
        if counts is None or indices is None:
            raise ValueError("this file does not say which vertices triangles have: interpolate by primitive_ids and primitive_uvs")
        lengths = self._native.mesh_lengths()
        if len(counts) != 8 * len(lengths) or len(indices) != 12 * sum(lengths):
            raise ValueError("the file's notes 'vertices' and 'indices' are not those of its triangles: save the scene again")
        triangles = np.frombuffer(indices, "<u4").reshape(-1, 3)
        parts = np.split(triangles, np.cumsum(lengths)[:-1]) if lengths else []
        counts = np.frombuffer(counts, "<u8").tolist()
        if any(part.size and part.max() >= count for count, part in zip(counts, parts)):
            raise ValueError("the file's note 'indices' has vertices that are not there: save the scene again")
        return list(zip(counts, parts))

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
        faces = self._faces()
        if len(lists) != len(faces):
            raise ValueError(f"{len(lists)} arrays for {len(faces)} geometries")
        lists = [np.asarray(one) for one in lists]
        for one, (count, _) in zip(lists, faces):
            if len(one) != count:
                raise ValueError(f"{len(one)} values for {count} vertices")
        result = np.full((len(hit), *lists[0].shape[1:]), np.nan, np.result_type(np.float32, *lists))
        for number, (one, (_, triangles)) in enumerate(zip(lists, faces)):
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
