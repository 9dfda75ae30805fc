"""The scene's questions, against numbers worked out by hand."""

import copy
import pickle
import threading

import numpy as np
import pytest

import boxwood

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float32)
FACES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)


@pytest.fixture
def cube():
    scene = boxwood.Scene()
    assert scene.add_triangles(CUBE, FACES) == 0
    return scene


def test_the_closest_hit(cube):
    rays = np.array([[[0.3, 0.4, -2, 0, 0, 1], [0.3, 0.4, -2, 0, 0, -1]]], np.float32)
    answer = cube.cast_rays(rays)
    assert answer["t_hit"].tolist() == [[2.0, np.inf]]
    assert answer["hit"].tolist() == [[True, False]]
    assert answer["geometry_ids"].tolist() == [[0, boxwood.INVALID_ID]]
    assert answer["primitive_ids"].dtype == np.uint32
    np.testing.assert_allclose(answer["primitive_normals"][0, 0], [0, 0, -1])
    assert answer["primitive_uvs"].shape == (1, 2, 2)


def test_all_hits_and_their_number(cube):
    rays = [[0.5, 0.5, -1, 0, 0, 1], [5, 5, 5, 1, 0, 0], [0.25, 0.5, 0.5, 1, 0, 0]]
    assert cube.count_intersections(rays).tolist() == [2, 0, 1]
    found = cube.list_intersections(rays)
    assert found["ray_splits"].tolist() == [0, 2, 2, 3]
    assert found["ray_ids"].tolist() == [0, 0, 2]
    assert found["t_hit"].tolist() == [1.0, 2.0, 0.75]
    assert cube.test_occlusions(rays).tolist() == [True, False, True]
    assert not cube.test_occlusions(rays, tfar=0.5).any()


def test_distances_and_signs(cube):
    points = [[0.5, 0.5, 0.5], [0.5, 0.5, 2.0], [2.0, 2.0, 0.5], [np.nan, 0, 0]]
    distance = cube.compute_distance(points)
    np.testing.assert_allclose(distance[:3], [0.5, 1.0, np.sqrt(2)], rtol=1e-6)
    assert np.isnan(distance[3])
    np.testing.assert_allclose(cube.compute_signed_distance(points)[:2], [-0.5, 1.0])
    assert cube.compute_occupancy(points).tolist() == [1, 0, 0, 0]
    nearest = cube.compute_closest_points(points)
    assert nearest["points"][1].tolist() == [0.5, 0.5, 1.0]


@pytest.mark.parametrize("kind", ["f4", "f8", ">f8", "f2", "i4", "u1"])
def test_any_type_and_stride(cube, kind):
    rays = np.array([[0, 0, -2, 0, 0, 1]] * 6).astype(kind if kind != "u1" else "i1")
    expected = cube.cast_rays(rays.astype(np.float32))["t_hit"]
    for same in (rays, rays[::-1], np.asfortranarray(rays), rays.tolist()):
        assert np.array_equal(cube.cast_rays(same)["t_hit"], expected)


def test_an_array_may_begin_at_an_odd_address(cube):
    rays = np.array([[0.3, 0.4, -2, 0, 0, 1]] * 4, np.float32)
    odd = np.frombuffer(b"-" + rays.tobytes(), np.uint8)[1:].view(np.float32).reshape(4, 6)
    assert not odd.flags.aligned
    assert cube.cast_rays(odd)["t_hit"].tolist() == [2.0] * 4


def test_map_coordinates_keep_their_places():
    far = np.array([448_262.125, 5_411_932.678, 100.0])
    scene = boxwood.Scene()
    scene.add_triangles(CUBE.astype(np.float64) * 0.001 + far, FACES)
    assert scene.origin.any()
    ray = np.concatenate([far + [0.0005, 0.0004, -1], [0, 0, 1]])
    assert abs(scene.cast_rays(ray)["t_hit"] - 1.0) < 1e-6
    place = scene.compute_closest_points(far + [0.0005, 0.0005, 1.0])["points"]
    np.testing.assert_allclose(place, far + [0.0005, 0.0005, 0.001], rtol=0, atol=1e-6)


def test_what_vertices_carry_is_blended(cube):
    answer = cube.cast_rays([[0.3, 0.4, -2, 0, 0, 1], [9, 9, 9, 0, 0, 1]], interpolate={"place": CUBE, "x": CUBE[:, 0]})
    np.testing.assert_allclose(answer["place"][0], [0.3, 0.4, 0], atol=1e-6)
    assert abs(answer["x"][0] - 0.3) < 1e-6 and np.isnan(answer["x"][1])


def test_pinhole_cameras_look_where_they_should(cube):
    rays = boxwood.Scene.create_rays_pinhole(fov_deg=60, center=[0.5, 0.5, 0.5], eye=[0.5, 0.5, -4], up=[0, 1, 0], width_px=31, height_px=21)
    assert rays.shape == (21, 31, 6) and rays.dtype == np.float32
    hit = cube.cast_rays(rays)["hit"]
    assert hit[10, 15] and not hit[0].any()


@pytest.mark.parametrize(
    "vertices, triangles, kind",
    [
        (CUBE[:, :2], FACES, ValueError),
        (CUBE, FACES[:, :2], ValueError),
        (CUBE, FACES + 1, ValueError),
        (CUBE, FACES - 1, ValueError),
        (CUBE, FACES.astype(float), TypeError),
        (["a", "b"], FACES, TypeError),
        (CUBE, None, ValueError),
    ],
)
def test_mistakes_are_told(vertices, triangles, kind):
    scene = boxwood.Scene()
    with pytest.raises(kind, match="vert|triangle"):
        scene.add_triangles(vertices, triangles)


def test_a_walk_is_told_in_words(cube):
    text = cube.explain([0.3, 0.4, -2, 0, 0, 1])
    assert "hit: triangle" in text and "at t = 2," in text and "flop" in text


def test_rays_of_the_wrong_shape_are_refused(cube):
    for rays in ([1, 2, 3], np.zeros((2, 5)), np.zeros(()), "rays"):
        with pytest.raises((ValueError, TypeError), match="rays"):
            cube.cast_rays(rays)
    with pytest.raises(ValueError, match="threads"):
        cube.cast_rays(np.zeros((1, 6)), nthreads=-1)


def test_no_rays_and_no_triangles(cube):
    assert cube.cast_rays(np.zeros((0, 6)))["t_hit"].shape == (0,)
    assert cube.cast_rays(np.zeros((3, 0, 6)))["primitive_uvs"].shape == (3, 0, 2)
    empty = boxwood.Scene()
    assert np.isinf(empty.cast_rays([0, 0, 0, 0, 0, 1])["t_hit"])


def test_a_scene_goes_through_pickle(cube):
    rays = np.random.default_rng(1).normal(size=(100, 6))
    for other in (pickle.loads(pickle.dumps(cube)), copy.deepcopy(cube)):
        assert np.array_equal(other.cast_rays(rays)["t_hit"], cube.cast_rays(rays)["t_hit"])


def test_threads_ask_at_once_and_agree(cube):
    rays = np.random.default_rng(2).normal(size=(20_000, 6)).astype(np.float32)
    expected = cube.cast_rays(rays, nthreads=1)["t_hit"]
    answers = [None] * 8

    def ask(i):
        answers[i] = cube.cast_rays(rays, nthreads=1 + i % 3)["t_hit"]

    threads = [threading.Thread(target=ask, args=(i,)) for i in range(len(answers))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(answer, expected) for answer in answers)


def test_a_mesh_that_comes_later_is_seen(cube):
    ray = [5.2, 5.2, -1, 0, 0, 1]
    assert not cube.cast_rays(ray)["hit"]
    assert cube.add_triangles(CUBE + 5, FACES) == 1
    assert cube.cast_rays(ray)["geometry_ids"] == 1


def test_the_array_that_was_given_may_change(cube):
    vertices = CUBE.copy()
    scene = boxwood.Scene()
    scene.add_triangles(vertices, FACES)
    vertices[:] = np.nan
    assert scene.cast_rays([0.5, 0.5, -1, 0, 0, 1])["t_hit"] == 1.0


def test_files_and_their_mistakes(tmp_path):
    scene = boxwood.Scene.load("builtin:sphere?n=1800")
    assert scene.stats["triangles"] == boxwood.Scene.load("builtin:sphere?n=1800").stats["triangles"]
    assert scene.stats["triangles"] == 1800
    broken = tmp_path / "broken.obj"
    broken.write_text("v 0 0 0\nf 1 2 3\n")
    with pytest.raises(OSError, match="broken.obj:2"):
        boxwood.Scene.load(broken)
