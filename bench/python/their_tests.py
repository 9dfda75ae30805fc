"""Runs the ray tests of trimesh and of Open3D against Boxwood. Their tests are fetched from where they are published, not kept here.

    python bench/python/their_tests.py trimesh          # from its source distribution, of the version that is installed
    python bench/python/their_tests.py open3d FILE      # FILE: python/test/t/geometry/test_raycasting_scene.py of its repository
"""

from __future__ import annotations

import argparse
import os
import pathlib
import subprocess
import sys
import tarfile
import tempfile

TRIMESH = """
import trimesh.ray.ray_triangle, trimesh.ray, boxwood.trimesh
# Both of trimesh's ways to ask become Boxwood.
trimesh.ray.ray_triangle.RayMeshIntersector = boxwood.trimesh.RayMeshIntersector
try:
    import trimesh.ray.ray_pyembree
    trimesh.ray.ray_pyembree.RayMeshIntersector = boxwood.trimesh.RayMeshIntersector
except ImportError:
    pass
"""


#: The distribution has the tests, but neither their helpers nor their meshes: these stand in for them.
GENERIC = '''
import logging, os, time
import numpy as np
import pytest, trimesh

log = logging.getLogger("trimesh")
random = np.random.default_rng(0).random


class Data(dict):
    def __missing__(self, key):
        pytest.skip(f"{key} is not in the distribution")


data = Data()


def get_mesh(name, use_embree=True, **_):
    shared = os.environ.get("SCENES", "")
    if name.startswith("unit_cube"):
        mesh = trimesh.creation.box()
    elif name.startswith("unit_sphere"):
        mesh = trimesh.creation.icosphere(subdivisions=3)
    elif name.startswith("7_8ths"):
        whole, corner = trimesh.creation.box([10, 10, 10]), trimesh.creation.box([5, 5, 5])
        corner.apply_translation([2.5, 2.5, 2.5])
        mesh = trimesh.boolean.difference([whole, corner], engine="manifold")
    else:
        known = {"featuretype.STL": "objects/featuretype.STL", "teapot.stl": "objects/teapot.obj"}
        path = os.path.join(shared, known.get(name, name))
        if not os.path.exists(path):
            pytest.skip(f"{name} is not here; SCENES names the folder of shared scenes")
        mesh = trimesh.load_mesh(path)
    mesh.ray = trimesh.ray.ray_triangle.RayMeshIntersector(mesh)
    return mesh
'''


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("whose", choices=["trimesh", "open3d"])
    parser.add_argument("file", nargs="?", type=pathlib.Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        home = pathlib.Path(folder)
        code = trimesh_tests(home) if options.whose == "trimesh" else open3d_tests(home, options.file)
    sys.exit(code)


def trimesh_tests(home: pathlib.Path) -> int:
    """All tests that cast rays, with Boxwood in the place of both of trimesh's ways. SCENES in the environment: shared/scenes."""
    import trimesh

    wanted = f"trimesh=={trimesh.__version__}"
    subprocess.run([sys.executable, "-m", "pip", "download", "-q", "--no-binary", "trimesh", "--no-deps", "--no-build-isolation", wanted], cwd=home, check=True)
    with tarfile.open(next(home.glob("trimesh-*.tar.gz"))) as archive:
        archive.extractall(home, filter="data")
    source = next(path for path in home.glob("trimesh-*") if path.is_dir())
    (source / "tests" / "conftest.py").write_text(TRIMESH)
    (source / "tests" / "generic.py").write_text(GENERIC)
    # The installed trimesh is asked, not the one beside the tests.
    (source / "trimesh").rename(source / "not_trimesh")
    tests = sorted((source / "tests").glob("test_ray*.py"))
    paths = os.pathsep.join([str(source / "tests"), os.environ.get("PYTHONPATH", "")])
    command = [sys.executable, "-m", "pytest", "-q", "-rfEs", "--import-mode=prepend", *tests]
    return subprocess.run(command, cwd=source / "tests", env={**os.environ, "PYTHONPATH": paths}).returncode


def open3d_tests(home: pathlib.Path, file: pathlib.Path | None) -> int:
    """Open3D's own tests with its ray casting scene replaced; its tensors and meshes stay."""
    if file is None:
        raise SystemExit("name Open3D's test_raycasting_scene.py")
    text = file.read_text().replace("o3d.t.geometry.RaycastingScene", "OURS")
    (home / "ours.py").write_text(OURS)
    (home / "open3d_test.py").write_text("def list_devices(*_, **__):\n    import open3d\n    return [open3d.core.Device('CPU:0')]\n")
    (home / "test_raycasting_scene.py").write_text("from ours import OURS\n" + text)
    return subprocess.run([sys.executable, "-m", "pytest", "-q", "-rfEs", home / "test_raycasting_scene.py"], cwd=home).returncode


OURS = '''
import numpy as np
import open3d as o3d
import boxwood


def plain(value):
    return value.numpy() if isinstance(value, o3d.core.Tensor) else value


def tensors(value):
    if isinstance(value, dict):
        # What Open3D has not: its test of shapes knows the names that there are.
        return {name: tensors(array) for name, array in value.items() if name not in ("hit", "distances")}
    return o3d.core.Tensor(np.ascontiguousarray(value)) if isinstance(value, (np.ndarray, np.generic)) else value


class OURS:
    """Boxwood with Open3D's tensors."""

    INVALID_ID = int(boxwood.INVALID_ID)

    def __init__(self, nthreads=0, device=None):
        self.scene = boxwood.Scene(threads=nthreads)

    def add_triangles(self, vertices, triangles=None, *, vertex_positions=None, triangle_indices=None):
        vertices = vertex_positions if vertices is None else vertices
        triangles = triangle_indices if triangles is None else triangles
        if triangles is None:
            vertices, triangles = vertices.vertex.positions, vertices.triangle.indices
        return self.scene.add_triangles(plain(vertices), plain(triangles))

    def __getattr__(self, name):
        method = getattr(self.scene, name)
        return lambda *a, **k: tensors(method(*map(plain, a), **{key: plain(value) for key, value in k.items()}))

    @staticmethod
    def create_rays_pinhole(*a, **k):
        return tensors(boxwood.Scene.create_rays_pinhole(*map(plain, a), **{key: plain(value) for key, value in k.items()}))
'''


if __name__ == "__main__":
    main()
