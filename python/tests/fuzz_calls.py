"""Random calls: every method with arrays of every kind, from several threads, in forked children, while others write into the arrays
and resize them. Each call gives an answer of the right shape, or raises an error that programs expect; nothing else.

    python python/tests/fuzz_calls.py 100000 --seed 1

A failure prints the number of the call, which `--only NUMBER` runs again.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import pickle
import sys
import threading
import time
import warnings
from types import SimpleNamespace

import numpy as np

import boxwood
from boxwood import jobs
from boxwood.trimesh import RayMeshIntersector

#: What a caller may have to deal with.
EXPECTED = (ValueError, TypeError, OverflowError, MemoryError, OSError, IndexError)

KINDS = ["f4", "f8", "f2", ">f4", ">f8", "i1", "u1", "i4", "i8", "u8", "?", "c8", "O", "U3", "M8[s]", "g"]
SPECIAL = [0.0, -0.0, 1.0, -1.0, np.nan, np.inf, -np.inf, 1e-45, 1e-38, 3e38, 1e308, 2.0**100, 2.0**31, 2.0**63]


class Random:
    """What calls are made of."""

    def __init__(self, seed: int) -> None:
        self.draw = np.random.default_rng(seed)

    def chance(self, share: float) -> bool:
        return bool(self.draw.random() < share)

    def one(self, things):
        return things[self.draw.integers(len(things))]

    def shape(self, columns: int) -> tuple[int, ...]:
        last = columns if self.chance(0.9) else int(self.draw.integers(0, 9))
        lead = self.one([(), (1,), (0,), (5,), (2, 3), (0, 4), (1, 1, 3), (33,), (2000,)])
        return (*lead, last) if self.chance(0.97) else ()

    def numbers(self, shape) -> np.ndarray:
        array = self.draw.normal(size=shape) * self.one([1.0, 1.0, 1.0, 1e-3, 1e3, 1e20])
        if self.chance(0.3) and array.size:
            flat = array.reshape(-1)
            for _ in range(self.draw.integers(1, 6)):
                flat[self.draw.integers(flat.size)] = self.one(SPECIAL)
            array = flat.reshape(shape)
        return array

    def array(self, columns: int):
        """Of some type, with some strides."""
        array = self.numbers(self.shape(columns))
        kind = self.one(KINDS) if self.chance(0.4) else self.one(["f4", "f8"])
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                array = array.astype(kind)
            except (ValueError, TypeError, OverflowError):
                pass
        return self.strange(np.asarray(array))

    def strange(self, array: np.ndarray):
        way = self.draw.integers(0, 14)
        if way == 0 and array.ndim:
            return array[::-1]
        if way == 1 and array.ndim:
            return np.repeat(array, 2, axis=0)[::2]
        if way == 2:
            return np.asfortranarray(array)
        if way == 3:
            array.flags.writeable = False
        elif way == 4:
            return np.ma.masked_array(array, self.draw.random(array.shape) < 0.3)
        elif way == 5 and array.ndim and array.shape[0]:
            return np.broadcast_to(array[:1], (7, *array.shape[1:]))
        elif way == 6:
            return array.tolist()
        elif way == 7 and array.dtype.kind == "f":
            return np.ndarray(array.shape, array.dtype, np.zeros(array.nbytes + 1, np.uint8), offset=1)
        elif way == 8:
            return array.view(np.recarray)
        elif way == 9 and self.chance(0.2):
            return self.one([None, "rays", 3.5, {}, [], [[1, 2], [3]], object(), b"x", np.float32(2), range(6)])
        elif way == 10 and array.ndim:
            return np.swapaxes(np.ascontiguousarray(np.swapaxes(array, 0, -1)), 0, -1)
        return array

    def threads(self):
        return self.one([None, None, None, 0, 1, 2, 3, np.int8(1), True, -1, 5000, "two", 1.5, 2**70]) if self.chance(0.4) else None

    def limit(self):
        return self.one([0.0, 1.0, -1.0, np.nan, np.inf, 1e300, "near", None, [1.0, 2.0], np.zeros(5), np.zeros((2, 3)), np.ones(2000)])

    def out(self, like: dict[str, np.ndarray]):
        """Arrays for the answers, right ones and wrong ones."""
        out = {name: np.empty_like(array) for name, array in like.items() if self.chance(0.5)}
        if out and self.chance(0.4):
            name = self.one(list(out))
            array = out[name]
            spoil = self.one([lambda a: a.astype("f8"), lambda a: a[..., None], lambda a: a[::2] if a.ndim else a, lambda a: None, lambda a: a.tolist()])
            out[name] = spoil(array)
        if self.chance(0.05):
            out["nothing"] = np.zeros(3)
        return out


def scenes() -> list[boxwood.Scene]:
    """Small ones of all sorts."""
    empty, flat, odd, far, several = (boxwood.Scene(threads=2) for _ in range(5))
    flat.add_triangles([[-1, -1, 0], [1, -1, 0], [-1, 1, 0], [1, 1, 0]], [[0, 1, 2], [1, 3, 2]])
    vertices = np.random.default_rng(0).normal(size=(60, 3)).astype(np.float32)
    vertices[::7] = np.nan
    vertices[5], vertices[9] = np.inf, 3e38
    odd.add_triangles(vertices, np.arange(60).reshape(-1, 3))
    far.add_triangles(np.random.default_rng(1).normal(size=(90, 3)) * 50 + [448_262.125, 5_411_932.678, 100.0], np.arange(90).reshape(-1, 3))
    ball = boxwood.Scene.load("builtin:sphere?n=1800")
    for size in (1, 2, 3):
        several.add_triangles(ball.mesh()[0] * size, ball.mesh()[1])
    several.add_triangles(np.zeros((0, 3)), np.zeros((0, 3), int))
    return [empty, flat, odd, far, several, ball]


def has_shape(array, shape) -> None:
    assert isinstance(array, np.ndarray) and array.shape == tuple(shape), f"{getattr(array, 'shape', array)} is not {shape}"


def cast(random: Random, scene: boxwood.Scene):
    rays, options = random.array(6), {}
    if random.chance(0.3):
        options.update(tnear=random.limit(), tfar=random.limit())
    if random.chance(0.2):
        count = sum(len(mesh[0]) for mesh in scene._meshes)
        options["interpolate"] = {random.one(["a", "t_hit", 7]): random.one([random.numbers((count, 2)), [], random.numbers(count), "none", None])}
    if random.chance(0.3):
        with contextlib.suppress(*EXPECTED):
            options["out"] = random.out(scene.cast_rays(rays))
    answer = scene.cast_rays(rays, random.threads(), **options)
    shape = np.shape(rays)[:-1]
    for name, tail in {"t_hit": (), "hit": (), "primitive_ids": (), "geometry_ids": (), "primitive_uvs": (2,), "primitive_normals": (3,)}.items():
        has_shape(answer[name], (*shape, *tail))
    assert not np.isnan(answer["t_hit"]).any()


def plain(name: str, columns: int):
    def call(random: Random, scene: boxwood.Scene):
        data, options = random.array(columns), {}
        if columns == 6 and random.chance(0.3):
            options.update(tnear=random.limit(), tfar=random.limit())
        if random.chance(0.2):
            with contextlib.suppress(*EXPECTED):
                options["out"] = random.one([np.empty_like(getattr(scene, name)(data)), np.zeros(5, np.float32), np.zeros((0, 4), bool), "out"])
        if random.chance(0.3):
            options["nthreads"] = random.threads()
        has_shape(getattr(scene, name)(data, **options), np.shape(data)[:-1])

    return call


def listed(random: Random, scene: boxwood.Scene):
    rays = random.array(6)
    found = scene.list_intersections(rays, random.threads(), tfar=random.limit() if random.chance(0.3) else np.inf)
    splits, hits = found["ray_splits"], len(found["ray_ids"])
    has_shape(splits, (int(np.prod(np.shape(rays)[:-1])) + 1,))
    assert splits[0] == 0 and splits[-1] == hits and (np.diff(splits) >= 0).all()
    has_shape(found["primitive_uvs"], (hits, 2))


def drop_in(scene: boxwood.Scene) -> RayMeshIntersector:
    """With this scene in the place of a mesh."""
    ray = RayMeshIntersector(SimpleNamespace(vertices=(), faces=()))
    ray._read = None, scene
    return ray


def by_trimesh(random: Random, scene: boxwood.Scene):
    """The drop-in for trimesh."""
    ray = drop_in(scene)
    origins, directions = random.array(3), random.array(3)
    if random.chance(0.7):
        directions = random.strange(random.numbers(np.shape(origins)))
    first = ray.intersects_first(origins, directions)
    tri, which, places = ray.intersects_id(origins, directions, return_locations=True, multiple_hits=False)
    has_shape(places, (len(which), 3))
    assert np.array_equal(np.flatnonzero(first >= 0), which) and np.array_equal(first.reshape(-1)[which], tri)


def nearest(random: Random, scene: boxwood.Scene):
    points, options = random.array(3), {}
    if random.chance(0.2):
        with contextlib.suppress(*EXPECTED):
            options["out"] = random.out(scene.compute_closest_points(points))
    answer = scene.compute_closest_points(points, random.threads(), **options)
    has_shape(answer["points"], (*np.shape(points)[:-1], 3))


def added(random: Random, scene: boxwood.Scene):
    other = boxwood.Scene(quality=random.one(["fast", "default", "high", "fast", "best", 3]), threads=1)
    vertices = random.array(3)
    triangles = random.one([None, random.strange(random.draw.integers(-1, 40, (20, 3)).astype(random.one(["i4", "u8", "i8", "f4", "u1"]))), random.array(3)])
    other.add_triangles(vertices, triangles)
    other.cast_rays(np.zeros((3, 6), np.float32))
    assert other.stats["triangles"] >= 0
    has_shape(other.bounds, (2, 3))


def rendered(random: Random, scene: boxwood.Scene):
    options = {}
    for name in ("eye", "target", "up"):
        if random.chance(0.2):
            options[name] = random.array(3)
    options.update({name: random.one(some) for name, some in RENDER.items() if random.chance(0.15)})
    size = random.one([(8, 6), (1, 1), (17, 3), (8, 6), (0, 4), (70000, 1), (3,), "ab", (2.5, 3), None, (-1, 4)])
    picture = scene.render(size, **options)
    left, top, width, height = picture.crop
    has_shape(picture.pixels, (height, width, 3))
    has_shape(picture.depth, (height, width))
    has_shape(picture.geometry_ids, (height, width))


RENDER = {
    "fov_deg": [40, 0, np.nan, 200, "wide"],
    "shading": ["ao", "path", "depth", "heat-tests", "none", 3, "prim"],
    "samples": [1, 2, 0, -1, 2**40, 1.5, "x"],
    "seed": [0, 2**64 - 1, 2**64, -1, 1.5, None],
    "crop": [(0, 0, 4, 3), (1, 1, 1, 1), (0, 0, 99, 99), (0, 0, 0, 0), (-1, 0, 1, 1), "crop", (1, 2)],
    "max_depth": [0, 1, 2**32 - 1, -1, None],
    "lights": [[(0, 0, 3)], [(0, 0, 3, 2)], [(np.nan, 0, 0)], [3], "ab", [(0, 0, 3, -1)]],
    "sky": [0, 1, -1, np.nan, np.inf],
    "exposure": [0, 3, np.nan, 1e30, "x"],
    "top": [1, 0, -3, np.nan, np.inf],
    "log": [True, 0, "yes"],
    "floor": [False, 1],
    "threads": [0, 1, 2, -1],
}


def jobbed(random: Random, scene: boxwood.Scene):
    which = random.draw.integers(0, 6)
    grid = random.strange(random.numbers(random.one([(5, 6), (1, 1), (0, 3), (9, 9), (3,)])).astype(random.one(["f4", "f8", "i2"])))
    if which == 0:
        seen = jobs.viewshed(grid, random.one([(0, 0), (2, 3), (9, 9), (-1, 0), (0.5, 1)]), cell_size=random.one([1, (2, 3), 0, np.nan, "x"]))
        has_shape(seen, np.shape(grid))
    elif which == 1:
        has_shape(jobs.sky_view_factor(grid, directions=random.one([1, 7, 16, 0, -1, "x"])), np.shape(grid))
    elif which == 2:
        a, b = random.array(3), random.array(3)
        has_shape(jobs.line_of_sight(scene, a, b), np.broadcast_shapes(np.shape(a), np.shape(b))[:-1])
    elif which == 3:
        a, b = random.array(3), random.array(3)
        has_shape(jobs.ambient_occlusion(scene, a, b, rays=random.one([1, 3, 0])), np.broadcast_shapes(np.shape(a), np.shape(b))[:-1])
    elif which == 4:
        jobs.lidar_scan(scene, random.one([np.eye(4), [np.eye(4)] * 2, np.zeros((4, 4)), random.array(4)]), jobs.Spinning(beams=3, azimuths=random.one([5, 0])))
    else:
        has_shape(jobs.depth_image(scene, (6, 5), eye=random.array(3) if random.chance(0.3) else None), (5, 6))


def pickled(random: Random, scene: boxwood.Scene):
    other = pickle.loads(pickle.dumps(scene))
    rays = random.numbers((20, 6))
    assert np.array_equal(other.cast_rays(rays)["t_hit"], scene.cast_rays(rays)["t_hit"])


def told(random: Random, scene: boxwood.Scene):
    assert isinstance(scene.explain(random.array(6)), str)
    assert isinstance(repr(scene), str)


def mutated(random: Random, scene: boxwood.Scene):
    """Another thread writes into the array, and resizes it, while it is asked about."""
    rays = random.numbers((random.one([50, 3000]), 6)).astype(random.one(["f4", "f8"]))
    origins, directions = rays[:, :3].copy(), rays[:, 3:].copy()
    stop = threading.Event()

    def disturb():
        k = 0
        while not stop.is_set():
            k += 1
            with contextlib.suppress(*EXPECTED):
                rays[k % max(len(rays), 1)] = k
            if k % 3 == 0:
                with contextlib.suppress(*EXPECTED):
                    rays.resize((len(rays) % 4000 + 1, 6))
                # Beneath whoever looks at it, too.
                with contextlib.suppress(*EXPECTED):
                    origins.resize((len(origins) % 4000 + 1, 3))
                    directions.resize(origins.shape)
            time.sleep(0)

    thread = threading.Thread(target=disturb)
    thread.start()
    try:
        for _ in range(3):
            answer = scene.cast_rays(rays, random.threads())
            assert answer["t_hit"].shape == answer["hit"].shape
            with contextlib.suppress(*EXPECTED):
                _, which, places = drop_in(scene).intersects_id(origins, directions, return_locations=True, multiple_hits=False)
                has_shape(places, (len(which), 3))
    finally:
        stop.set()
        thread.join()


def crowded(random: Random, scene: boxwood.Scene):
    """Several threads ask at once, and one adds meshes."""
    rays = random.numbers((200, 6))
    own = boxwood.Scene(threads=2)
    own.add_triangles([[-1, -1, 0], [1, -1, 0], [-1, 1, 0]], [[0, 1, 2]])
    faults = []

    def ask():
        try:
            has_shape(own.cast_rays(rays)["t_hit"], (200,))
            own.compute_distance(rays[:, :3])
        except BaseException as fault:
            faults.append(fault)

    threads = [threading.Thread(target=ask) for _ in range(3)]
    for thread in threads:
        thread.start()
    own.add_triangles(random.numbers((30, 3)), np.arange(30).reshape(-1, 3))
    for thread in threads:
        thread.join()
    if faults:
        raise faults[0]


def forked(random: Random, scene: boxwood.Scene):
    """The child asks too, while threads of the parent are at work."""
    rays = random.numbers((2000, 6))
    expected = scene.cast_rays(rays)["t_hit"]
    busy = threading.Thread(target=lambda: scene.cast_rays(random_rays))
    random_rays = random.numbers((5000, 6))
    busy.start()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        code = 1
        try:
            code = 0 if np.array_equal(scene.cast_rays(rays, 2)["t_hit"], expected) else 2
        finally:
            os._exit(code)
    until = time.monotonic() + 60
    while True:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            break
        if time.monotonic() > until:
            os.kill(child, 9)
            os.waitpid(child, 0)
            raise AssertionError("the child hangs")
        time.sleep(0.001)
    busy.join()
    assert status == 0, f"the child ended with {status}"


#: Each call, and how often.
CALLS = [
    (cast, 30),
    (plain("test_occlusions", 6), 10),
    (plain("count_intersections", 6), 8),
    (listed, 10),
    (by_trimesh, 10),
    (nearest, 8),
    (plain("compute_distance", 3), 5),
    (plain("compute_signed_distance", 3), 5),
    (plain("compute_occupancy", 3), 5),
    (added, 8),
    (rendered, 3),
    (jobbed, 5),
    (told, 2),
    (pickled, 1),
    (mutated, 0.3),
    (crowded, 0.3),
    (forked, 0.1 if hasattr(os, "fork") else 0),
]


def fuzz(count: int, seed: int, only: int | None = None, say=lambda text: None) -> dict[str, int]:
    """Makes so many calls; returns how many gave an answer, and how many raised what."""
    calls, weights = zip(*CALLS)
    share = np.cumsum(weights) / np.sum(weights)
    pool, told_of = scenes(), {}
    for number in range(count) if only is None else [only]:
        random = Random(seed * 1_000_003 + number)
        call = calls[int(np.searchsorted(share, random.draw.random(), side="right"))]
        scene = random.one(pool)
        try:
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore")
                call(random, scene)
            name = "answered"
        except EXPECTED as error:
            name = type(error).__name__
        except BaseException as error:
            raise AssertionError(f"call {number} ({call.__qualname__}), seed {seed}: {type(error).__name__}: {error}") from error
        told_of[name] = told_of.get(name, 0) + 1
        if number and number % 10_000 == 0:
            say(f"{number:,} calls: {told_of}")
    return told_of


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", type=int, nargs="?", default=3000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int)
    options = parser.parse_args()
    told_of = fuzz(options.count, options.seed, options.only, lambda text: print(text, file=sys.stderr, flush=True))
    print(f"{sum(told_of.values()):,} calls, seed {options.seed}: {told_of}")


if __name__ == "__main__":
    main()
