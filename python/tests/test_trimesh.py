"""The drop-in for trimesh: the same questions, the same shapes."""

import numpy as np
import pytest

trimesh = pytest.importorskip("trimesh")

from boxwood.trimesh import RayMeshIntersector  # noqa: E402


@pytest.fixture
def ball():
    mesh = trimesh.creation.icosphere(subdivisions=3)
    mesh.ray = RayMeshIntersector(mesh)
    return mesh


def test_it_serves_as_mesh_ray(ball):
    origins = np.random.default_rng(3).uniform(-2, 2, (2000, 3))
    inside = ball.contains(origins)
    assert np.array_equal(inside, ball.ray.contains_points(origins))
    radius = np.linalg.norm(origins, axis=1)
    assert not inside[radius > 1].any() and inside[radius < 0.98].all()


def test_places_rays_and_triangles_belong_together(ball):
    origins = np.tile([[0.0, 0.1, -3.0]], (5, 1)) + np.arange(5)[:, None] * [0.05, 0, 0]
    directions = np.tile([[0.0, 0.0, 1.0]], (5, 1))
    places, ray, tri = ball.ray.intersects_location(origins, directions)
    assert len(places) == len(ray) == len(tri) == 10
    np.testing.assert_allclose(places[:, :2], origins[ray, :2], atol=1e-6)
    normals, corners = ball.face_normals[tri], ball.triangles[tri, 0]
    assert np.abs(np.einsum("ij,ij->i", normals, places - corners)).max() < 1e-5
    first, _, _ = ball.ray.intersects_location(origins, directions, multiple_hits=False)
    assert len(first) == 5 and (first[:, 2] < 0).all()


@pytest.mark.parametrize("kind", ["float32", "float64", "int16", ">f8"])
@pytest.mark.parametrize("shift", [0.0, 4_000_000.0])
def test_first_places_are_those_of_casting(kind, shift):
    """Of any type and layout, near and far from zero, in more than one piece."""
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=100.0)
    mesh.apply_translation([shift, 0, 0])
    ray = RayMeshIntersector(mesh, threads=2)
    random = np.random.default_rng(5)
    both = random.integers(-200, 200, (5000, 7)).astype(kind)
    origins, directions = both[::2, :3], both[::2, 3:6]
    if kind != "int16":
        origins = origins + np.array([shift, 0, 0], kind)
    hits = ray._scene.cast_rays(np.concatenate([origins, directions], axis=1))
    tri, which, places = ray.intersects_id(origins, directions, multiple_hits=False, return_locations=True)
    assert (tri.dtype, which.dtype, places.dtype) == (np.int64, np.int64, np.float64)
    assert np.array_equal(which, np.flatnonzero(hits["hit"])) and np.array_equal(tri, hits["primitive_ids"][which])
    exact = origins[which].astype(float) + hits["t_hit"][which, None].astype(float) * directions[which].astype(float)
    assert np.array_equal(places, exact)
    assert np.array_equal(ray.intersects_first(origins, directions)[which], tri)


def test_masked_rays_meet_nothing(ball):
    origins = np.ma.masked_array([[0, 0.1, 3.0], [0, 0.1, 3.0]], mask=[[False] * 3, [True, False, False]])
    directions = [[0, 0, -1.0]] * 2
    assert ball.ray.intersects_any(origins, directions).tolist() == [True, False]
    assert ball.ray.intersects_id(origins, directions, multiple_hits=False)[1].tolist() == [0]
    assert set(ball.ray.intersects_id(origins, directions)[1].tolist()) == {0}


def test_no_rays_and_no_hits(ball):
    nothing = np.zeros((0, 3))
    assert [len(one) for one in ball.ray.intersects_id(nothing, nothing, multiple_hits=False, return_locations=True)] == [0, 0, 0]
    tri, ray, places = ball.ray.intersects_id([[9, 9, 9]], [[1, 0, 0]], multiple_hits=False, return_locations=True)
    assert len(tri) == len(ray) == 0 and places.shape == (0, 3)


def test_it_serves_primitives():
    """Also within a constructor, as trimesh makes its own: before there are faces."""

    class Unfinished(trimesh.primitives.Box):
        def __init__(self):
            self.ray = RayMeshIntersector(self)
            super().__init__(extents=[2, 2, 2])
            self.ray = RayMeshIntersector(self)

    assert Unfinished().ray.intersects_any([[0.1, 0.2, 5]], [[0, 0, -1]]).all()


def test_a_scene_of_meshes_is_refused_with_a_remedy(ball):
    with pytest.raises(TypeError, match="to_mesh"):
        RayMeshIntersector(trimesh.Scene(ball))
    with pytest.raises(TypeError, match="not str"):
        RayMeshIntersector("ball.obj")


def test_first_and_any(ball):
    origins, directions = [[0, 0.1, -3], [0, 5, -3]], [[0, 0, 1], [0, 0, 1]]
    first = ball.ray.intersects_first(origins, directions)
    assert first[0] >= 0 and first[1] == -1
    assert ball.ray.intersects_any(origins, directions).tolist() == [True, False]
    tri, ray = ball.ray.intersects_id(origins, directions, max_hits=1)
    assert tri.tolist() == [first[0]] and ray.tolist() == [0]
