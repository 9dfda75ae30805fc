"""Boxwood beside Open3D and trimesh with embreex: the same rays and points, in one run, by turns.

    python bench/python/rivals.py bunny.obj sponza.obj dragon.ply --markdown results.md
"""

from __future__ import annotations

import argparse
import os
import platform
import time
import warnings
from fractions import Fraction
from typing import Any, Callable

import numpy as np

import boxwood
from boxwood.trimesh import RayMeshIntersector

#: An answer, by the names of Open3D.
Answer = dict[str, np.ndarray]
#: Origins and directions.
Lines = tuple[np.ndarray, np.ndarray]


def random_rays(bounds: np.ndarray, count: int, seed: int = 1) -> np.ndarray:
    """From anywhere in the box around the scene, a fifth wider, to anywhere."""
    random = np.random.default_rng(seed)
    middle, half = bounds.mean(axis=0), np.diff(bounds, axis=0)[0] * 0.6
    origins = middle + random.uniform(-1, 1, (count, 3)) * half
    directions = random.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return np.concatenate([origins, directions], axis=1).astype(np.float32)


class Boxwood:
    name = "Boxwood"

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray) -> None:
        import trimesh

        mesh = trimesh.Trimesh(vertices, triangles, process=False)
        self.rays = {threads: RayMeshIntersector(mesh, threads=threads) for threads in (0, 1)}
        for ray in self.rays.values():
            ray.intersects_first(np.zeros((1, 3)), np.ones((1, 3)))
        self.scene = boxwood.Scene()
        self.scene.add_triangles(vertices, triangles)
        self.scene.stats

    def closest_hit(self, rays: np.ndarray, threads: int) -> Answer:
        return self.scene.cast_rays(rays, threads)

    def first_triangle(self, lines: Lines, threads: int) -> Answer:
        return first_triangle(self.rays[threads], lines)

    def first_place(self, lines: Lines, threads: int) -> Answer:
        return first_place(self.rays[threads], lines)

    def all_hits(self, rays: np.ndarray, threads: int) -> Answer:
        return self.scene.list_intersections(rays, threads)

    def closest_point(self, points: np.ndarray, threads: int) -> Answer:
        return self.scene.compute_closest_points(points, threads)

    def signed_distance(self, points: np.ndarray, threads: int) -> Answer:
        return {"distance": self.scene.compute_signed_distance(points, threads)}


def first_triangle(intersector: Any, lines: Lines) -> Answer:
    """By trimesh's names, from either: numbers alone."""
    return {"first": intersector.intersects_first(*lines)}


def first_place(intersector: Any, lines: Lines) -> Answer:
    """By trimesh's names, from either: numbers and places."""
    triangles, which, _ = intersector.intersects_id(*lines, return_locations=True, multiple_hits=False)
    return {"triangles": triangles, "which": which}


def numbers(answer: Answer, count: int) -> np.ndarray:
    """The triangle of each ray."""
    if "first" in answer:
        return answer["first"].astype(np.uint32)
    if "which" in answer:
        first = np.full(count, 0xFFFFFFFF, np.uint32)
        first[answer["which"]] = answer["triangles"]
        return first
    return answer["primitive_ids"]


class Open3d:
    name = "Open3D"

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray) -> None:
        import open3d

        self.tensor = open3d.core.Tensor
        self.scene = open3d.t.geometry.RaycastingScene()
        self.scene.add_triangles(self.tensor(vertices), self.tensor(triangles))
        self.closest_hit(np.zeros((1, 6), np.float32), 1)

    def _plain(self, answer: Any) -> Answer:
        return {name: tensor.numpy() for name, tensor in answer.items()}

    def closest_hit(self, rays: np.ndarray, threads: int) -> Answer:
        return self._plain(self.scene.cast_rays(self.tensor(rays), nthreads=threads))

    def all_hits(self, rays: np.ndarray, threads: int) -> Answer:
        return self._plain(self.scene.list_intersections(self.tensor(rays), nthreads=threads))

    def closest_point(self, points: np.ndarray, threads: int) -> Answer:
        return self._plain(self.scene.compute_closest_points(self.tensor(points), nthreads=threads))

    def signed_distance(self, points: np.ndarray, threads: int) -> Answer:
        return {"distance": self.scene.compute_signed_distance(self.tensor(points), nthreads=threads).numpy()}


class Trimesh:
    """Knows one thread only; its closest points are made of numpy and an R tree, so that fewer are asked."""

    name = "trimesh + embreex"
    fewer = {"closest_point": 100, "signed_distance": 100}

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray) -> None:
        import trimesh
        from trimesh.ray.ray_pyembree import RayMeshIntersector

        self.mesh = trimesh.Trimesh(vertices, triangles, process=False)
        self.ray = RayMeshIntersector(self.mesh)
        self.ray.intersects_first(np.zeros((1, 3)), np.ones((1, 3)))
        self.proximity = trimesh.proximity.ProximityQuery(self.mesh)

    def first_triangle(self, lines: Lines, threads: int) -> Answer:
        return first_triangle(self.ray, lines)

    def first_place(self, lines: Lines, threads: int) -> Answer:
        return first_place(self.ray, lines)

    def all_hits(self, rays: np.ndarray, threads: int) -> Answer:
        triangles, which = self.ray.intersects_id(rays[:, :3], rays[:, 3:], multiple_hits=True)
        return {"ray_ids": which, "primitive_ids": triangles}

    def closest_point(self, points: np.ndarray, threads: int) -> Answer:
        places, distances, triangles = self.proximity.on_surface(points)
        return {"points": places, "distances": distances, "primitive_ids": triangles}

    def signed_distance(self, points: np.ndarray, threads: int) -> Answer:
        return {"distance": -self.proximity.signed_distance(points)}


QUESTIONS = {"closest_hit": "rays", "first_triangle": "lines", "first_place": "lines", "all_hits": "rays", "closest_point": "points", "signed_distance": "points"}


def race(arms: list[Any], question: str, data: Any, count: int, threads: int, rounds: int) -> tuple[dict[str, list[float]], dict[str, Answer]]:
    """Nanoseconds for each ray or point, round by round, and the answers."""
    times: dict[str, list[float]] = {arm.name: [] for arm in arms}
    answers: dict[str, Answer] = {}
    for turn in range(rounds):
        for arm in arms if turn % 2 == 0 else arms[::-1]:
            fewer = getattr(arm, "fewer", {}).get(question, 1)
            some = data if fewer == 1 else data[::fewer]
            # Threads of the one before wait for more work for a while, and keep a core busy with that.
            time.sleep(0.1)
            begun = time.perf_counter()
            answers[arm.name] = getattr(arm, question)(some, threads)
            times[arm.name].append((time.perf_counter() - begun) / -(-count // fewer) * 1e9)
    return times, answers


def edge_share(rays: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """The least of the three weights of where each ray meets the plane of its triangle, in double precision: near 0 on an edge,
    below it outside; NaN where the ray runs within the plane."""
    a, b, c = (corners[:, k].astype(np.float64) for k in range(3))
    origins, directions = rays[:, :3].astype(np.float64), rays[:, 3:].astype(np.float64)
    p = np.cross(directions, c - a)
    determinant = np.sum(p * (b - a), axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = np.sum(p * (origins - a), axis=1) / determinant
        v = np.sum(np.cross(origins - a, b - a) * directions, axis=1) / determinant
    return np.minimum(np.minimum(u, v), 1 - u - v)


def differences(rays: np.ndarray, corners: np.ndarray, ours: Answer, theirs: Answer) -> str:
    """Where the closest hits are not the same, and why."""
    nothing = np.uint32(0xFFFFFFFF)
    mine, other = numbers(ours, len(rays)), numbers(theirs, len(rays))
    only_mine, only_other = (mine != nothing) & (other == nothing), (mine == nothing) & (other != nothing)
    both = (mine != nothing) & (other != nothing) & (mine != other)

    def on_edge(which: np.ndarray, ids: np.ndarray) -> int:
        return int(np.sum(~(np.abs(edge_share(rays[which], corners[ids[which]])) > 1e-4)))

    near = on_edge(both, mine) if both.any() else 0
    return (
        f"{int(only_mine.sum())} hit by Boxwood alone ({on_edge(only_mine, mine)} of them within 1e-4 of an edge), "
        f"{int(only_other.sum())} by the other alone ({on_edge(only_other, other)}), {int(both.sum())} another triangle ({near})"
    )


def is_hit(ray: np.ndarray, corners: np.ndarray) -> bool:
    """By exact arithmetic: inside the triangle or on its edge, not behind the origin."""
    origin, direction, a, b, c = ([Fraction(float(x)) for x in place] for place in (ray[:3], ray[3:], *corners))
    p, q, r = ([x - o for x, o in zip(corner, origin)] for corner in (a, b, c))

    def volume(x: list[Fraction], y: list[Fraction]) -> Fraction:
        return sum(direction[k] * (x[k - 2] * y[k - 1] - x[k - 1] * y[k - 2]) for k in range(3))

    weights = volume(q, r), volume(r, p), volume(p, q)
    whole = sum(weights)
    if whole == 0 or min(weights) < 0 < max(weights):
        return False
    depth = sum(p[k] * ((q[k - 2] - p[k - 2]) * (r[k - 1] - p[k - 1]) - (q[k - 1] - p[k - 1]) * (r[k - 2] - p[k - 2])) for k in range(3))
    return depth / whole >= 0


def more_or_fewer(rays: np.ndarray, corners: np.ndarray, ours: Answer, theirs: Answer) -> str:
    """Where the lists of all hits are not the same, and why."""
    pairs = [answer["ray_ids"].astype(np.int64) << 32 | answer["primitive_ids"].astype(np.int64) for answer in (ours, theirs)]
    # Hits are in order within each ray: what is at the same distance stands side by side. trimesh goes on by 1e-6 of the size.
    ray, t = ours["ray_ids"], ours["t_hit"]
    size = np.linalg.norm(np.ptp(corners.reshape(-1, 3), axis=0))
    beside = (ray[1:] == ray[:-1]) & (np.abs(t[1:] - t[:-1]) <= np.maximum(1e-5 * np.abs(t[1:]), 1.1e-6 * size))
    crowded = pairs[0][np.append(beside, False) | np.append(False, beside)]

    def kinds(pairs: np.ndarray) -> str:
        on_edge = ~(np.abs(edge_share(rays[pairs >> 32], corners[pairs & 0xFFFFFFFF])) > 1e-4)
        at_another = np.isin(pairs, crowded) & ~on_edge
        rest = pairs[~on_edge & ~at_another]
        right = sum(is_hit(rays[pair >> 32], corners[pair & 0xFFFFFFFF]) for pair in rest)
        return (
            f"{len(pairs):,} ({int(on_edge.sum()):,} within 1e-4 of an edge, {int(at_another.sum()):,} others beside another hit of the same ray, "
            f"{len(rest)} more, of which exact arithmetic confirms {right})"
        )

    alone = np.setdiff1d(*pairs), np.setdiff1d(*pairs[::-1])
    return f"{len(pairs[0]):,} and {len(pairs[1]):,} in all; by Boxwood alone {kinds(alone[0])}, by the other alone {kinds(alone[1])}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="+")
    parser.add_argument("--rays", type=int, default=1_000_000)
    parser.add_argument("--points", type=int, default=100_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 0], help="0: all")
    parser.add_argument("--questions", nargs="+", default=list(QUESTIONS), choices=list(QUESTIONS))
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    kinds: list[Callable[..., Any]] = [Boxwood, Open3d, Trimesh]
    print(f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores; boxwood {boxwood.__version__}, ", end="")
    import embreex
    import open3d
    import trimesh

    print(f"Open3D {open3d.__version__}, trimesh {trimesh.__version__}, embreex {embreex.__version__}, numpy {np.__version__}")
    print(f"{options.rays:,} rays, {options.points:,} points, best of {options.rounds} rounds by turns; millions a second\n")
    print("| scene | question | threads | Boxwood | Open3D | trimesh + embreex | to Open3D | to embreex |\n|---|---|---|---|---|---|---|---|")
    notes = []
    for file in options.files:
        scene = boxwood.Scene.load(file)
        vertices, triangles = (np.array(array) for array in scene.mesh())
        arms = [kind(vertices, triangles) for kind in kinds]
        name = os.path.splitext(os.path.basename(file))[0]
        rays = random_rays(scene.bounds, options.rays)
        lines = np.ascontiguousarray(rays[:, :3]), np.ascontiguousarray(rays[:, 3:])
        asked: dict[str, Any] = {"rays": rays, "lines": lines, "points": np.ascontiguousarray(lines[0][: options.points])}
        for question in options.questions:
            data = asked[QUESTIONS[question]]
            count = len(data[0] if isinstance(data, tuple) else data)
            for threads in options.threads:
                here = [arm for arm in arms if hasattr(arm, question)]
                # Where there is one that knows more threads, those who do not are told once.
                if threads != 1 and len(here) == len(arms):
                    here = [arm for arm in here if arm.name != Trimesh.name]
                times, answers = race(here, question, data, count, threads, options.rounds)
                speed = {arm: 1e3 / min(times[arm]) for arm in times}
                # Of each round: what disturbs the machine disturbs all.
                ratio = {arm: np.median(np.divide(times[arm], times["Boxwood"])) for arm in times}
                row = [f"{speed[arm.name]:.3g}" if arm.name in speed else "" for arm in arms]
                row += [f"{ratio[arm.name]:.2f}" if arm.name in ratio else "" for arm in arms[1:]]
                print(f"| {name} | {question.replace('_', ' ')} | {threads or 'all'} | {' | '.join(row)} |", flush=True)
                if threads == options.threads[0]:
                    notes += explained(name, question, rays if QUESTIONS[question] == "lines" else data, vertices[triangles], answers)
    print("\n" + "\n".join(notes))


def explained(name: str, question: str, data: np.ndarray, corners: np.ndarray, answers: dict[str, Answer]) -> list[str]:
    """In what the answers differ."""
    ours, notes = answers["Boxwood"], []
    for other, theirs in answers.items():
        if other == "Boxwood":
            continue
        if question in ("closest_hit", "first_triangle", "first_place"):
            text = differences(data, corners, ours, theirs)
        elif question == "all_hits":
            text = more_or_fewer(data, corners, ours, theirs)
        else:
            key = "distances" if question == "closest_point" else "distance"
            if key in theirs:
                mine, his = ours[key], theirs[key]
            else:
                mine, his = ours["distances"], np.linalg.norm(theirs["points"] - data, axis=1)
            mine = mine[:: len(mine) // len(his)] if len(his) < len(mine) else mine
            mine = mine[: len(his)]
            scale = np.abs(corners).max()
            text = f"{int(np.sum(np.abs(np.abs(mine) - np.abs(his)) > 1e-5 * scale))} distances farther apart than 1e-5 of the size"
            if key == "distance":
                text += f", {int(np.sum((mine < 0) != (his < 0)))} with another sign, of {len(his):,}"
        notes.append(f"- {name}, {question.replace('_', ' ')}, {other}: {text}.")
    return notes


if __name__ == "__main__":
    main()
