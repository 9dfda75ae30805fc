"""The jobs, against cases that can be worked out by hand."""

import numpy as np
import pytest

import boxwood
from boxwood import jobs
from boxwood.jobs.sampling import hemisphere

FLAT = [[0, 1, 2], [1, 3, 2]]


def room():
    """A floor and two walls, large: the corner of an endless room."""
    far = 1e3
    scene = boxwood.Scene()
    scene.add_triangles([[0, 0, 0], [far, 0, 0], [0, far, 0], [far, far, 0]], FLAT)
    scene.add_triangles([[0, 0, 0], [far, 0, 0], [0, 0, far], [far, 0, far]], FLAT)
    scene.add_triangles([[0, 0, 0], [0, far, 0], [0, 0, far], [0, far, far]], FLAT)
    return scene


def test_the_hemisphere_is_filled_evenly():
    cosine, even = hemisphere(4096, 1), hemisphere(4096, 1, cosine=False)
    np.testing.assert_allclose(np.linalg.norm(cosine, axis=1), 1, rtol=1e-12)
    assert abs(cosine[:, 2].mean() - 2 / 3) < 1e-3 and abs(even[:, 2].mean() - 1 / 2) < 1e-3
    assert np.abs(cosine[:, :2].mean(axis=0)).max() < 1e-3
    assert not np.array_equal(cosine, hemisphere(4096, 2))


@pytest.mark.parametrize("place, share", [([300, 300, 0], 1.0), ([300, 0.05, 0], 0.5), ([0.05, 0.05, 0], 0.25)])
def test_a_plane_is_open_the_foot_of_a_wall_half_a_corner_a_quarter(place, share):
    found = jobs.ambient_occlusion(room(), place, [0, 0, 2], rays=4096, offset=1e-3, distance=250)
    assert found.shape == () and abs(found - share) < 0.006


def test_occlusion_knows_what_is_far_and_what_is_no_point():
    scene = room()
    assert jobs.ambient_occlusion(scene, [300, 5, 0], [0, 0, 1], distance=4, offset=1e-3) == 1
    several = jobs.ambient_occlusion(scene, [[[300, 5, 0], [np.nan, 0, 0]]], [[[0, 0, 1], [0, 0, 1]]])
    assert several.shape == (1, 2) and np.isnan(several).tolist() == [[False, True]]
    assert np.isnan(jobs.ambient_occlusion(scene, [300, 5, 0], [0, 0, 0]))


def test_normals_of_a_ball_point_outwards():
    vertices, triangles = boxwood.Scene.load("builtin:sphere?n=1800").mesh()
    normals = jobs.vertex_normals(vertices, triangles)
    used = np.unique(triangles)
    outward = (vertices - vertices[used].mean(axis=0))[used]
    outward = outward / np.linalg.norm(outward, axis=1, keepdims=True)
    assert (np.abs(np.sum(normals[used] * outward, axis=1)) > 0.99).mean() > 0.95


def test_the_sky_above_a_plain_is_whole():
    for weight in ("cosine", "solid_angle"):
        assert (jobs.sky_view_factor(np.full((5, 7), 1234.5), cell_size=10, weight=weight) == 1).all()


def test_the_sky_at_the_foot_of_a_long_wall_is_half():
    elevation = np.zeros((201, 41))
    elevation[:, 20:] = 1e4
    for weight in ("cosine", "solid_angle"):
        share = jobs.sky_view_factor(elevation, cell_size=1e3, directions=1024, weight=weight)[100, 19]
        # The wall leans back over one cell: by an angle of atan(10) it is less than upright.
        lean = np.arctan(0.1)
        expected = (1 + np.sin(lean)) / 2 if weight == "cosine" else (np.pi / 2 + lean) / np.pi
        assert abs(share - expected) < 0.02, (weight, share, expected)


def test_the_sky_of_a_slope_is_that_of_theory():
    slope = 30.0
    elevation = np.tan(np.radians(slope)) * np.arange(101.0) * np.ones((101, 1))
    share = jobs.sky_view_factor(elevation, directions=1024)[50, 50]
    # A horizontal patch sees (1 + cos s) / 2 of the sky, if the slope goes on far enough.
    assert abs(share - (1 + np.cos(np.radians(slope))) / 2) < 0.01


def test_holes_in_the_ground_have_no_sky():
    elevation = np.zeros((4, 4))
    elevation[1, 2] = np.nan
    share = jobs.sky_view_factor(elevation, directions=8)
    assert np.isnan(share).sum() == 1 and np.isnan(share[1, 2])
    masked = np.ma.masked_array(np.zeros((4, 4), np.int16), np.isnan(elevation))
    assert np.array_equal(jobs.sky_view_factor(masked, directions=8), share, equal_nan=True)


def test_a_ridge_hides_what_is_behind_it():
    elevation = np.zeros((21, 41))
    elevation[:, 20] = 10
    seen = jobs.viewshed(elevation, (10, 5), observer_height=2)
    assert seen[:, :21].all() and not seen[:, 21:].any()
    higher = jobs.viewshed(elevation, (10, 5), observer_height=2, target_height=30)
    # By similar triangles: over the ridge at 10, from 2 at column 5, the line is at 2 + 8 / 15 * (c - 5).
    columns = np.arange(41)
    assert np.array_equal(higher[10], 2 + 8 / 15 * (columns - 5) < 30 + (columns <= 20) * 1e9)
    near = jobs.viewshed(elevation, (10, 5), observer_height=2, max_distance=5)
    assert near.sum() == sum(np.hypot(y, x) <= 5 for y in range(-5, 6) for x in range(-5, 6))


def test_the_earth_is_round():
    height, radius = 10.0, 6_371_000.0
    elevation = np.zeros((3, 2001))
    seen = jobs.viewshed(elevation, (1, 0), cell_size=10, observer_height=height, earth_radius=radius)[1]
    horizon = np.sqrt(2 * radius * height)
    assert abs(np.flatnonzero(seen).max() * 10 - horizon) < 0.02 * horizon
    farther = jobs.viewshed(elevation, (1, 0), cell_size=10, observer_height=height, earth_radius=radius, refraction=0.13)[1]
    assert abs(farther.sum() / seen.sum() - 1 / np.sqrt(0.87)) < 0.02
    assert jobs.viewshed(elevation, (1, 0), cell_size=10).all()


def test_mountains_far_above_the_sea_keep_their_digits():
    elevation = np.full((50, 50), 8000.0)
    elevation[:, 25] += 0.01
    seen = jobs.viewshed(elevation, (25, 5), observer_height=0.005)
    assert seen[:, :26].all() and not seen[:, 26:].any()


def test_lines_of_sight_for_all_pairs():
    scene = boxwood.Scene()
    scene.add_triangles([[-9, -9, 0], [9, -9, 0], [-9, 9, 0], [9, 9, 0]], FLAT)
    places = np.array([[0, 0, 1], [1, 0, 1], [0.5, 0, -1], [0.3, 0.2, 0], [np.nan, 0, 0]])
    sees = jobs.line_of_sight(scene, places[:, None], places[None])
    # The place on the surface is seen from both sides.
    expected = [[1, 1, 0, 1, 0], [1, 1, 0, 1, 0], [0, 0, 1, 1, 0], [1, 1, 1, 1, 0], [0, 0, 0, 0, 0]]
    assert sees.tolist() == np.array(expected, bool).tolist()
    assert not jobs.line_of_sight(scene, places[0], places[3], margin=0)


def test_a_lidar_over_a_plane_measures_circles():
    scene = boxwood.Scene()
    scene.add_triangles([[-500, -500, 0], [500, -500, 0], [-500, 500, 0], [500, 500, 0]], FLAT)
    pose = np.eye(4)
    pose[:3, 3] = [1, 2, 3]
    pattern = jobs.Spinning(beams=4, lowest_deg=-40, highest_deg=20, azimuths=90)
    scan = jobs.lidar_scan(scene, [pose, pose], pattern, max_range=20)
    rise = np.radians(np.linspace(-40, 20, 4))
    assert scan["ranges"].shape == (2, 90, 4)
    for beam in (0, 1):
        np.testing.assert_allclose(scan["ranges"][:, :, beam], 3 / -np.sin(rise[beam]), rtol=1e-5)
        np.testing.assert_allclose(scan["intensities"][:, :, beam], -np.sin(rise[beam]), rtol=1e-5)
    assert np.isinf(scan["ranges"][:, :, 2:]).all() and (scan["intensities"][:, :, 2:] == 0).all()
    assert scan["points"].shape == (360, 3) and np.abs(scan["points"][:, 2]).max() < 1e-4
    np.testing.assert_allclose(np.linalg.norm(scan["points"] - [1, 2, 3], axis=1), scan["ranges"].ravel()[scan["ray_ids"]])


def test_a_lidar_turns_with_its_pose_and_its_noise_has_a_seed():
    scene = boxwood.Scene()
    scene.add_triangles([[5, -9, -9], [5, 9, -9], [5, -9, 9], [5, 9, 9]], FLAT)
    turned = np.eye(4)
    turned[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    # The beam to the right (-y) of a sensor that looks along y goes along x.
    assert jobs.lidar_scan(scene, turned, [[0, -2, 0]])["ranges"] == [5.0]
    noisy = [jobs.lidar_scan(scene, turned, [[0, -1, 0]], range_noise=0.1, seed=seed)["ranges"][0] for seed in (1, 1, 2)]
    assert noisy[0] == noisy[1] != noisy[2] and abs(noisy[0] - 5) < 0.6
    with pytest.raises(ValueError, match="rigid"):
        jobs.lidar_scan(scene, 2 * np.eye(4))


def test_depth_is_along_the_axis_and_distance_along_the_ray():
    scene = boxwood.Scene()
    scene.add_triangles([[-50, -50, 0], [50, -50, 0], [-50, 50, 0], [50, 50, 0]], FLAT)
    camera = dict(eye=[0, 0, 4], target=[0, 0, 0], up=[0, 1, 0], fov_deg=60)
    depth = jobs.depth_image(scene, (30, 20), **camera)
    np.testing.assert_allclose(depth, 4, rtol=1e-6)
    distance = jobs.depth_image(scene, (30, 20), kind="distance", **camera)
    np.testing.assert_allclose(distance, scene.render((30, 20), shading="normal", **camera).depth, rtol=1e-5)


def test_a_depth_image_finds_its_camera():
    scene = boxwood.Scene.load("builtin:bush?n=3000")
    depth = jobs.depth_image(scene, (48, 32))
    assert depth.shape == (32, 48)
    assert np.array_equal(np.isfinite(depth), np.isfinite(scene.render((48, 32), shading="normal").depth))


@pytest.mark.parametrize(
    "call",
    [
        lambda: jobs.viewshed(np.zeros((3, 3)), (3, 0)),
        lambda: jobs.viewshed(np.full((3, 3), np.nan), (0, 0)),
        lambda: jobs.viewshed(np.zeros(3), (0, 0)),
        lambda: jobs.viewshed(np.zeros((3, 3)), (0, 0), cell_size=0),
        lambda: jobs.sky_view_factor(np.zeros((3, 3)), weight="none"),
        lambda: jobs.sky_view_factor(np.zeros((3, 3)), directions=0),
        lambda: jobs.line_of_sight(boxwood.Scene(), [0, 0], [1, 1]),
        lambda: jobs.lidar_scan(boxwood.Scene(), np.eye(3)),
        lambda: jobs.depth_image(boxwood.Scene(), kind="none"),
    ],
)
def test_what_makes_no_sense_is_told(call):
    with pytest.raises(ValueError):
        call()


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: jobs.lidar_scan(room(), np.eye(4), range_noise=-1), "range_noise"),
        (lambda: jobs.lidar_scan(room(), np.eye(4), reflectivity=5), "reflectivity"),
        (lambda: jobs.lidar_scan(room(), np.eye(4), max_range=np.nan), "max_range"),
        (lambda: jobs.lidar_scan(room(), np.eye(4), min_range=3, max_range=2), "min_range"),
        (lambda: jobs.lidar_scan(room(), np.eye(4), min_range=-1), "min_range"),
        (lambda: jobs.Spinning(beams=0), "beams must be 1 or more"),
        (lambda: jobs.ambient_occlusion(room(), np.zeros((3, 3)), np.zeros((2, 3))), r"points \(3, 3\) and normals \(2, 3\)"),
        (lambda: jobs.line_of_sight(room(), [0, 0, 0], [1, 1]), r"b must have the shape \(..., 3\)"),
        (lambda: jobs.ambient_occlusion("bunny.obj", [0, 0, 0], [0, 0, 1]), "boxwood.Scene.load"),
        (lambda: jobs.depth_image("bunny.obj"), "not str"),
        (lambda: jobs.viewshed(np.zeros((3, 3)), (1.5, 0)), r"two whole numbers, not \(1.5, 0\)"),
        (lambda: jobs.viewshed(np.zeros((3, 3)), 4), "row and the column"),
    ],
)
def test_what_is_wrong_is_named(call, told):
    with pytest.raises((ValueError, TypeError), match=told):
        call()


def test_noise_makes_no_range_negative():
    scan = jobs.lidar_scan(room(), [[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 0.1], [0, 0, 0, 1]], range_noise=5.0)
    assert scan["ranges"].min() == 0


def test_an_upright_lidar_where_y_is_up():
    scene = boxwood.Scene()
    scene.add_triangles([[-9, 0, -9], [9, 0, -9], [-9, 0, 9], [9, 0, 9]], FLAT)
    pose = [[1, 0, 0, 1], [0, 0, 1, 2], [0, -1, 0, 3], [0, 0, 0, 1]]
    scan = jobs.lidar_scan(scene, pose, jobs.Spinning(beams=1, lowest_deg=-45, azimuths=8))
    np.testing.assert_allclose(scan["ranges"], 2 * np.sqrt(2), rtol=1e-6)


def test_grids_without_cells_and_scenes_without_triangles():
    assert jobs.sky_view_factor(np.zeros((0, 5))).shape == (0, 5)
    assert jobs.sky_view_factor(np.zeros((1, 1))).tolist() == [[1.0]]
    assert jobs.ambient_occlusion(boxwood.Scene(), [0, 0, 0], [0, 0, 1], offset=0.1) == 1
    assert jobs.line_of_sight(boxwood.Scene(), [0, 0, 0], [1, 1, 1])
