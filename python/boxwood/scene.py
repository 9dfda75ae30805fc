"""A scene of triangle meshes and the questions about it, by the names of Open3D's ``RaycastingScene``."""

from __future__ import annotations

import operator
import os
import threading
import warnings
import weakref
from typing import TYPE_CHECKING, Any, Callable, Mapping, Sequence

import numpy as np

from ._native import NativeLooks, NativeScene, load
from .arrays import INVALID_ID, Out, leading, out_of, rays_of, threads_of, triangles_of, vertices_of
from .blend import blend
from .camera import pinhole
from .notes import Faces, faces_in, looks_in, meshes_in, notes_of, origin_in, quality_in
from .origin import origin_of
from .picture import Picture
from .studio import Studio

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._native import Lines

__all__ = ["INVALID_ID", "Scene"]


#: For the sake of forks, see :func:`_fork`.
_SCENES: weakref.WeakSet[Scene] = weakref.WeakSet()


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

    def __init__(self, *, quality: str = "default", threads: int = 0) -> None:
        self._quality = quality
        self._threads = threads_of(threads)
        self._meshes: list[tuple[NDArray[Any], NDArray[np.uint32]]] = []
        self._looks: dict[int, NativeLooks] = {}
        self._ready: tuple[NativeScene, NDArray[np.float64]] | None = None
        self._studio: Studio | None = None
        self._is_opened = False
        self._lock = threading.Lock()
        _SCENES.add(self)

    @classmethod
    def load(cls, path: str | os.PathLike[str], **options: Any) -> Scene:
        """A scene of the file at `path`: OBJ, PLY, STL, glTF, GLB, or ``builtin:bush``. :meth:`render` shows its materials.

        Warnings of the reader are given as :class:`UserWarning`.
        """
        positions, indices, looks, told = load(os.fspath(path))
        for text in told:
            warnings.warn(text, stacklevel=2)
        scene = cls(**options)
        scene._looks[scene.add_triangles(positions, indices)] = looks
        return scene

    @classmethod
    def open(cls, path: str | os.PathLike[str], *, map: bool = True, threads: int = 0) -> Scene:
        """A scene that :meth:`save` wrote, without a build.

        It answers bit for bit like the one that was saved, has its :attr:`origin`, and makes the same pictures. All of the file
        is checked first; one that is damaged, or no scene, is a :class:`ValueError`.

        Parameters
        ----------
        path : str or path
        map : bool
            True: the file becomes memory, which all processes of this machine that open it share. It must not be written to or
            cut short while the scene is there: that would end the process. Replacing it, as :meth:`save` does, is no harm.
            False: it is copied, for files that others may write to.
        threads : int
            For opening, and for questions that do not say; 0: as many as the machine has.
        """
        return cls._of(NativeScene.open(os.fsdecode(path), bool(map), threads_of(threads)), threads)

    @classmethod
    def from_buffer(cls, buffer: Any, *, threads: int = 0) -> Scene:
        """The scene in the bytes of a file, as :meth:`open`.

        ``bytes`` that begin at a multiple of 64 are read in place; anything else (an array, a memory map, shared memory), which
        somebody might change, is copied.
        """
        count = threads_of(threads)
        if type(buffer) is bytes:
            return cls._of(NativeScene.of_bytes(buffer, count), threads)
        return cls._of(NativeScene.of_array(np.frombuffer(buffer, np.uint8), count), threads)

    @classmethod
    def _of(cls, native: NativeScene, threads: int) -> Scene:
        """A scene that is opened already."""
        scene = cls(quality=quality_in(native), threads=threads)
        scene._ready, scene._is_opened = (native, origin_in(native)), True
        return scene

    def save(self, path: str | os.PathLike[str]) -> str:
        """Writes the scene to the file `path`, which :meth:`open` opens without a build, and returns its :attr:`content_hash`.

        The file has some 130 bytes for each triangle, and the textures. It is written beside `path` and renamed there, so that no
        reader ever sees a half.
        """
        return self._built()[0].save(os.fsdecode(path), self._threads)

    @property
    def content_hash(self) -> str:
        """What :meth:`save` returns: 64 hexadecimal digits, the same for the same scene on every machine."""
        return self._built()[0].content_hash(self._threads)

    def add_triangles(self, vertex_positions: ArrayLike, triangle_indices: ArrayLike | None = None) -> int:
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
            self._meshes = [*self._meshes, (vertices, triangles)]
            self._ready = None
            return len(self._meshes) - 1

    @property
    def origin(self) -> NDArray[np.float64]:
        """What is subtracted from all coordinates before they become single precision: float64 (3,)."""
        return self._built()[1].copy()

    def cast_rays(
        self,
        rays: ArrayLike,
        nthreads: int | None = None,
        *,
        tnear: ArrayLike = 0.0,
        tfar: ArrayLike = np.inf,
        interpolate: Mapping[str, Any] | None = None,
        out: Mapping[str, NDArray[Any]] | None = None,
        threads: int | None = None,
    ) -> dict[str, NDArray[Any]]:
        """The closest hit of each ray.

        Parameters
        ----------
        rays : array (..., 6)
            Origin and direction; a direction of any length but zero.
        nthreads, threads : int
            On how many threads; 0: as many as the machine has. Both names mean the same.
        tnear, tfar : float or array that goes with (...)
            Only hits from ``tnear`` to ``tfar``, both included, in units of the direction.
        interpolate : dict of name to array (V, ...), or list of such arrays, one for each geometry
            What vertices carry, to be blended at the hits; NaN where nothing is hit.
        out : dict of name to array
            Contiguous arrays of the answers' shapes and types to write these answers to, once all are known.

        Returns
        -------
        dict
            ``t_hit`` (...) float32 in units of the direction, inf where nothing is hit; ``geometry_ids`` and ``primitive_ids``
            (...), uint32, :data:`INVALID_ID` where nothing is hit; ``primitive_uvs`` (..., 2) float32: weights of the second and
            the third vertex; ``primitive_normals`` (..., 3) float32, unit; ``hit`` (...), bool; and what was to be interpolated.
        """
        asked, shape = rays_of(rays, tnear, tfar)
        kinds = {
            "t_hit": (np.float32, shape),
            "geometry_ids": (np.uint32, shape),
            "primitive_ids": (np.uint32, shape),
            "primitive_uvs": (np.float32, (*shape, 2)),
            "primitive_normals": (np.float32, (*shape, 3)),
            "hit": (np.bool_, shape),
        }
        given = Out(out, kinds, [rays, tnear, tfar])
        count = self._count(nthreads, threads)
        for name in interpolate or {}:
            if name in kinds:
                raise ValueError(f"{name!r} is an answer already: call it otherwise")
        native, origin = self._built()
        found = dict(zip(kinds, native.cast(asked, origin, count)))
        answer = {name: array.reshape(kinds[name][1]) for name, array in found.items()}
        for name, values in (interpolate or {}).items():
            blended = blend(values, self._faces(), found)
            answer[name] = blended.reshape(*shape, *blended.shape[1:])
        return given.fill(answer)

    def test_occlusions(
        self,
        rays: ArrayLike,
        tnear: ArrayLike = 0.0,
        tfar: ArrayLike = np.inf,
        nthreads: int | None = None,
        *,
        out: NDArray[np.bool_] | None = None,
        threads: int | None = None,
    ) -> NDArray[np.bool_]:
        """True for each ray (..., 6) that meets anything from ``tnear`` to ``tfar``; each is a number or an array that goes with
        (...). ``out``: bool (...)."""
        count = self._count(nthreads, threads)
        return self._each_ray(NativeScene.occluded, np.bool_, rays, tnear, tfar, out, count)

    def count_intersections(
        self,
        rays: ArrayLike,
        nthreads: int | None = None,
        *,
        tnear: ArrayLike = 0.0,
        tfar: ArrayLike = np.inf,
        out: NDArray[np.int64] | None = None,
        threads: int | None = None,
    ) -> NDArray[np.int64]:
        """How many triangles each ray (..., 6) meets from ``tnear`` to ``tfar``, int64; an edge that triangles share counts once.
        ``out``: int64 (...)."""
        count = self._count(nthreads, threads)
        return self._each_ray(NativeScene.count, np.int64, rays, tnear, tfar, out, count)

    def list_intersections(
        self,
        rays: ArrayLike,
        nthreads: int | None = None,
        *,
        tnear: ArrayLike = 0.0,
        tfar: ArrayLike = np.inf,
        threads: int | None = None,
    ) -> dict[str, NDArray[Any]]:
        """All hits of all rays (..., 6) from ``tnear`` to ``tfar``, those of one ray beside each other, nearest first.

        Returns
        -------
        dict
            ``ray_splits`` (n + 1,) int64: the hits of ray ``i`` are ``ray_splits[i]:ray_splits[i + 1]``; and for each of h hits
            ``ray_ids`` (h,) int64, ``t_hit`` (h,) float32, ``geometry_ids``, ``primitive_ids`` (h,) uint32, ``primitive_uvs``
            (h, 2) float32.
        """
        asked, _ = rays_of(rays, tnear, tfar)
        count = self._count(nthreads, threads)
        native, origin = self._built()
        names = ("ray_splits", "ray_ids", "t_hit", "geometry_ids", "primitive_ids", "primitive_uvs")
        return dict(zip(names, native.list(asked, origin, count)))

    def compute_closest_points(
        self,
        query_points: ArrayLike,
        nthreads: int | None = None,
        *,
        out: Mapping[str, NDArray[Any]] | None = None,
        threads: int | None = None,
    ) -> dict[str, NDArray[Any]]:
        """The place of the surface that is nearest to each point (..., 3).

        Returns
        -------
        dict
            ``points`` (..., 3), float32, but float64 where :attr:`origin` is not zero; ``geometry_ids``, ``primitive_ids`` (...)
            uint32; ``primitive_uvs`` (..., 2) and ``primitive_normals`` (..., 3) float32; ``distances`` (...) float32. NaN and
            :data:`INVALID_ID` for a point that is not finite, or where there are no triangles.
        """
        flat, shape = leading(query_points, 3, "points")
        native, origin = self._built()
        moved = bool(np.any(origin))
        kinds = {
            "points": (np.float64 if moved else np.float32, (*shape, 3)),
            "distances": (np.float32, shape),
            "geometry_ids": (np.uint32, shape),
            "primitive_ids": (np.uint32, shape),
            "primitive_uvs": (np.float32, (*shape, 2)),
            "primitive_normals": (np.float32, (*shape, 3)),
        }
        given = Out(out, kinds, [query_points])
        found = dict(zip(kinds, native.nearest(flat, origin, self._count(nthreads, threads))))
        if moved:
            found["points"] = found["points"] + origin
        return given.fill({name: array.reshape(kinds[name][1]) for name, array in found.items()})

    def compute_distance(
        self,
        query_points: ArrayLike,
        nthreads: int | None = None,
        *,
        out: NDArray[np.float32] | None = None,
        threads: int | None = None,
    ) -> NDArray[np.float32]:
        """The distance of each point (..., 3) to the surface, in the unit of the scene: float32 (...), as is ``out``."""
        wanted = None if out is None else {"distances": out}
        return self.compute_closest_points(query_points, nthreads, out=wanted, threads=threads)["distances"]

    def compute_signed_distance(
        self,
        query_points: ArrayLike,
        nthreads: int | None = None,
        nsamples: int = 1,
        *,
        out: NDArray[np.float32] | None = None,
        threads: int | None = None,
    ) -> NDArray[np.float32]:
        """The same, negative inside. Exact on closed meshes, so one sample is enough; ``nsamples`` is for who comes from Open3D."""
        _odd(nsamples)
        return self._each_point(NativeScene.signed, query_points, out, self._count(nthreads, threads))

    def compute_occupancy(
        self,
        query_points: ArrayLike,
        nthreads: int | None = None,
        nsamples: int = 1,
        *,
        out: NDArray[np.float32] | None = None,
        threads: int | None = None,
    ) -> NDArray[np.float32]:
        """1 for each point (..., 3) that is inside, else 0: float32 (...), as is ``out``. As exact as the sign of the distance."""
        _odd(nsamples)
        return self._each_point(NativeScene.inside, query_points, out, self._count(nthreads, threads))

    @staticmethod
    def create_rays_pinhole(
        intrinsic_matrix: ArrayLike | None = None,
        extrinsic_matrix: ArrayLike | None = None,
        width_px: int | None = None,
        height_px: int | None = None,
        *,
        fov_deg: float | None = None,
        center: ArrayLike | None = None,
        eye: ArrayLike | None = None,
        up: ArrayLike | None = None,
    ) -> NDArray[np.float32]:
        """Rays (height, width, 6) of a pinhole camera, float32: by matrices (3, 3) and (4, 4), or by ``fov_deg`` (horizontal),
        ``center``, ``eye`` and ``up``. The rays of the centres of pixels; directions have depth 1.
        """
        return pinhole(intrinsic_matrix, extrinsic_matrix, width_px, height_px, fov_deg=fov_deg, center=center, eye=eye, up=up)

    def render(
        self,
        size: tuple[int, int] = (960, 540),
        *,
        eye: ArrayLike | None = None,
        target: ArrayLike | None = None,
        up: ArrayLike | None = None,
        fov_deg: float | None = None,
        shading: str = "whitted",
        samples: int | None = None,
        seed: int = 0,
        crop: tuple[int, int, int, int] | None = None,
        max_depth: int = 8,
        lights: Sequence[ArrayLike] = (),
        sky: float | None = None,
        floor: bool = True,
        exposure: float | None = None,
        top: float | None = None,
        log: bool = False,
        threads: int | None = None,
    ) -> Picture:
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

    def camera(
        self,
        size: tuple[int, int] = (960, 540),
        *,
        eye: ArrayLike | None = None,
        target: ArrayLike | None = None,
        up: ArrayLike | None = None,
        fov_deg: float | None = None,
        threads: int | None = None,
    ) -> dict[str, Any]:
        """The camera that :meth:`render` takes for a picture of this size: ``eye``, ``target``, ``up``, float64 (3,), and
        ``fov_deg``, vertical."""
        return self._staged().camera(size, (eye, target, up, fov_deg), self._count(threads))

    def mesh(self, geometry_id: int = 0) -> tuple[NDArray[Any], NDArray[np.uint32]]:
        """Positions (V, 3), float32 or float64, and triangles (F, 3), uint32, of a mesh, as they were given: read-only."""
        native, origin = self._built()
        meshes = meshes_in(native) if self._is_opened else self._meshes
        number = operator.index(geometry_id)
        if not 0 <= number < len(meshes):
            raise ValueError(f"there is no geometry {number}: the scene has {len(meshes)}")
        given, indices = meshes[number]
        vertices = given + origin if self._is_opened and np.any(origin) else given.view()
        triangles = indices.view()
        vertices.flags.writeable = triangles.flags.writeable = False
        return vertices, triangles

    def _repr_png_(self) -> bytes | None:
        """What a notebook shows: a small picture; nothing where there is nothing to show."""
        return self.render((640, 360)).png() if any(len(triangles) for _, triangles in self._faces()) else None

    def explain(self, ray: ArrayLike) -> str:
        """How one ray (6,) finds its answer: every box and triangle looked at, as text."""
        flat, shape = leading(ray, 6, "ray")
        if flat.size != 6:
            raise ValueError(f"one ray has the shape (6,), not {(*shape, 6)}")
        native, origin = self._built()
        near = flat.reshape(6).astype(np.float64)
        near[:3] -= origin
        return native.explain(near.tolist())

    @property
    def stats(self) -> dict[str, Any]:
        """Triangles, those that can never be hit, nodes, leaves, depth, bytes and surface area cost of the tree, as a dict."""
        names = ("triangles", "skipped", "nodes", "leaves", "max_depth", "bytes", "sah_cost")
        return dict(zip(names, self._built()[0].stats()))

    @property
    def bounds(self) -> NDArray[np.float64]:
        """Smallest and largest corner, float64 (2, 3)."""
        native, origin = self._built()
        return np.array(native.bounds(), np.float64) + origin

    def __getstate__(self) -> dict[str, Any]:
        state: dict[str, Any] = {"quality": self._quality, "threads": self._threads}
        if self._is_opened:
            return {**state, "file": self._built()[0].to_bytes(self._threads)}
        # Smaller than the file, and soon built.
        return {**state, "meshes": self._meshes, "looks": self._looks}

    def __setstate__(self, state: dict[str, Any]) -> None:
        # Of a class that is derived with a constructor of its own, too.
        Scene.__init__(self, quality=state["quality"], threads=state["threads"])
        if "file" in state:
            opened = Scene.from_buffer(state["file"], threads=state["threads"])
            self._ready, self._is_opened = opened._ready, True
        else:
            self._meshes = state["meshes"]
            self._looks = state["looks"]

    def __repr__(self) -> str:
        lengths = self._built()[0].mesh_lengths() if self._is_opened else [len(triangles) for _, triangles in self._meshes]
        return f"<boxwood.Scene: {len(lengths)} meshes, {sum(lengths):,} triangles>"

    def _of_lines(self, ask: Callable[..., Any], lines: Lines) -> Any:
        """A question of the native part about origins and directions apart."""
        native, origin = self._built()
        return ask(native, lines, origin, self._threads)

    def _each_ray(
        self,
        ask: Callable[..., NDArray[Any]],
        kind: type[np.generic],
        rays: ArrayLike,
        tnear: ArrayLike,
        tfar: ArrayLike,
        out: NDArray[Any] | None,
        threads: int,
    ) -> NDArray[Any]:
        """One number for each ray."""
        asked, shape = rays_of(rays, tnear, tfar)
        given = out_of(out, kind, shape, [rays, tnear, tfar])
        native, origin = self._built()
        return given.fill({"out": ask(native, asked, origin, threads).reshape(shape)})["out"]

    def _each_point(
        self, ask: Callable[..., NDArray[Any]], points: ArrayLike, out: NDArray[Any] | None, threads: int
    ) -> NDArray[np.float32]:
        """One number for each point."""
        flat, shape = leading(points, 3, "points")
        given = out_of(out, np.float32, shape, [points])
        native, origin = self._built()
        answers = ask(native, flat, origin, threads).astype(np.float32, copy=False)
        return given.fill({"out": answers.reshape(shape)})["out"]

    def _built(self) -> tuple[NativeScene, NDArray[np.float64]]:
        """What answers, and what it wants to be subtracted: of one build, whatever other threads add meanwhile."""
        ready = self._ready
        if ready is not None:
            return ready
        with self._lock:
            if self._ready is None:
                origin = origin_of([vertices for vertices, _ in self._meshes])
                notes = notes_of(self._quality, origin, self._meshes, self._looks)
                self._ready = NativeScene(self._meshes, origin, self._quality, self._threads, notes), origin
            return self._ready

    def _staged(self) -> Studio:
        """What pictures are made of, kept for the next one."""
        while True:
            native, origin = self._built()
            with self._lock:
                # Another thread may have added a mesh in between.
                if self._ready is None or self._ready[0] is not native:
                    continue
                if self._studio is None or self._studio.native_scene is not native:
                    self._studio = Studio(native, *self._parts(), origin, self._threads)
                return self._studio

    def _parts(self) -> tuple[Sequence[tuple[NDArray[Any], NDArray[np.uint32]]], dict[int, NativeLooks], bool]:
        """The meshes, what they look like, and whether the origin has been subtracted already."""
        if self._ready is not None and self._is_opened:
            return meshes_in(self._ready[0]), looks_in(self._ready[0]), True
        return self._meshes, self._looks, False

    def _faces(self) -> list[Faces]:
        """Number of vertices and triangles of each mesh."""
        if self._is_opened:
            return faces_in(self._built()[0])
        return [(len(vertices), triangles) for vertices, triangles in self._meshes]

    def _count(self, nthreads: Any, threads: Any = None) -> int:
        if nthreads is not None and threads is not None and nthreads != threads:
            raise ValueError(f"threads and nthreads mean the same: {threads} or {nthreads}?")
        asked = nthreads if threads is None else threads
        return self._threads if asked is None else threads_of(asked)


def _fork() -> None:
    """In the child of a fork: what another thread of the parent held is let go, since that thread is not here."""
    for scene in list(_SCENES):
        scene._lock = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_fork)


def _odd(nsamples: Any) -> None:
    """Open3D asks for an odd number of rays to vote by."""
    if operator.index(nsamples) < 1 or nsamples % 2 == 0:
        raise ValueError(f"nsamples must be odd and positive, not {nsamples}")
