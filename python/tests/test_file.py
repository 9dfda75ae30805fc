"""Scenes in files, buffers and pickles answer bit for bit like those that were built."""

import mmap
import os
import pickle
import stat

import numpy as np
import pytest

import boxwood


def sphere(rings=24, sectors=32):
    """A closed wavy surface: positions float32 and triangles."""
    theta, phi = np.meshgrid(np.linspace(0.05, np.pi - 0.05, rings), np.linspace(0, 2 * np.pi, sectors, endpoint=False), indexing="ij")
    radius = 1 + 0.2 * np.sin(3 * phi) * np.sin(4 * theta)
    points = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1) * radius[..., None]
    at = np.arange(rings * sectors).reshape(rings, sectors)
    a, b, c, d = at[:-1], at[1:], np.roll(at, -1, axis=1)[1:], np.roll(at, -1, axis=1)[:-1]
    faces = np.concatenate([np.stack([a, b, c], axis=-1).reshape(-1, 3), np.stack([a, c, d], axis=-1).reshape(-1, 3)])
    return points.reshape(-1, 3).astype(np.float32), faces


POINTS, FACES = sphere()
RAYS = np.random.default_rng(7).normal(size=(500, 6)).astype(np.float32)


@pytest.fixture
def scene():
    scene = boxwood.Scene(quality="high")
    scene.add_triangles(POINTS, FACES)
    scene.add_triangles(POINTS * 0.5, FACES[::2])
    return scene


def assert_same(a, b, rays=RAYS):
    for one, other in zip(a.cast_rays(rays).values(), b.cast_rays(rays).values()):
        np.testing.assert_array_equal(one, other)
    assert a.cast_rays(rays)["hit"].sum() > 50
    for one, other in zip(a.list_intersections(rays).values(), b.list_intersections(rays).values()):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(a.test_occlusions(rays), b.test_occlusions(rays))
    np.testing.assert_array_equal(a.compute_signed_distance(rays[:, :3]), b.compute_signed_distance(rays[:, :3]))
    assert a.stats == b.stats and repr(a) == repr(b)
    np.testing.assert_array_equal(a.bounds, b.bounds)


@pytest.mark.parametrize("map", [True, False])
def test_an_opened_scene_is_the_saved_one(scene, tmp_path, map):
    path = tmp_path / "scene.bwx"
    digest = scene.save(path)
    assert digest == scene.content_hash and len(digest) == 64
    opened = boxwood.Scene.open(path, map=map)
    assert opened.content_hash == digest
    assert_same(opened, scene)
    # Saved again it is the same file.
    again = tmp_path / "again.bwx"
    assert opened.save(str(again)) == digest
    assert again.read_bytes() == path.read_bytes()


def test_the_hash_is_that_of_the_content(scene):
    same = boxwood.Scene(quality="high", threads=1)
    same.add_triangles(POINTS.tolist(), FACES.astype(np.int64))
    same.add_triangles(POINTS.astype(np.float64) * 0.5, FACES[::2])
    assert same.content_hash == scene.content_hash
    same.add_triangles(POINTS * 0.25, FACES)
    assert same.content_hash != scene.content_hash


def test_buffers_of_all_kinds(scene, tmp_path):
    path = tmp_path / "scene.bwx"
    scene.save(path)
    content = path.read_bytes()
    room = np.zeros(len(content) + 64, np.uint8)
    room[1 : len(content) + 1] = np.frombuffer(content, np.uint8)
    with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as mapped:
        for buffer in (content, bytearray(content), memoryview(content), room[1 : len(content) + 1], mapped):
            assert_same(boxwood.Scene.from_buffer(buffer), scene)


def test_a_buffer_that_changes_later_changes_nothing(scene, tmp_path):
    path = tmp_path / "scene.bwx"
    scene.save(path)
    for buffer in (bytearray(path.read_bytes()), np.fromfile(path, np.uint8)):
        opened = boxwood.Scene.from_buffer(buffer)
        buffer[:] = bytes(len(buffer)) if isinstance(buffer, bytearray) else 0
        assert_same(opened, scene)


def test_a_file_may_be_replaced_under_its_readers(scene, tmp_path):
    path = tmp_path / "scene.bwx"
    scene.save(path)
    opened = boxwood.Scene.open(path)
    other = boxwood.Scene()
    other.add_triangles(POINTS, FACES[:7])
    other.save(path)
    assert_same(opened, scene)
    assert boxwood.Scene.open(path).stats["triangles"] == 7
    assert os.listdir(tmp_path) == ["scene.bwx"]
    assert stat.S_IMODE(path.stat().st_mode) & 0o400


def test_map_coordinates_survive_the_file(tmp_path):
    far = np.array([448_262.125, 5_411_932.678, 100.0])
    scene = boxwood.Scene()
    scene.add_triangles(POINTS.astype(np.float64) * 0.001 + far, FACES)
    scene.save(tmp_path / "far.bwx")
    opened = boxwood.Scene.open(tmp_path / "far.bwx")
    assert opened.origin.dtype == np.float64 and opened.origin.any()
    np.testing.assert_array_equal(opened.origin, scene.origin)
    rays = np.concatenate([RAYS[:, :3] * 0.001 + far, RAYS[:, 3:]], axis=1)
    assert_same(opened, scene, rays)
    copy = pickle.loads(pickle.dumps(opened))
    np.testing.assert_array_equal(copy.origin, scene.origin)
    assert_same(copy, scene, rays)


def test_what_vertices_carry_is_blended_after_the_file(scene):
    opened = boxwood.Scene.from_buffer(pickle_bytes(scene))
    values = {"place": [POINTS, POINTS * 0.5]}
    expected = scene.cast_rays(RAYS, interpolate=values)["place"]
    np.testing.assert_array_equal(opened.cast_rays(RAYS, interpolate=values)["place"], expected)
    with pytest.raises(ValueError, match="1 arrays for 2 geometries"):
        opened.cast_rays(RAYS, interpolate={"place": POINTS})


def pickle_bytes(scene):
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "a.bwx")
        scene.save(path)
        with open(path, "rb") as file:
            return file.read()


def test_opened_scenes_pickle_with_all_that_they_are(scene):
    opened = boxwood.Scene.from_buffer(pickle_bytes(scene), threads=2)
    copy = pickle.loads(pickle.dumps(opened))
    assert_same(copy, scene)
    assert copy.content_hash == scene.content_hash
    state = copy.__getstate__()
    assert (state["quality"], state["threads"]) == ("high", 2)
    assert pickle.loads(pickle.dumps(scene)).content_hash == scene.content_hash


def test_a_scene_from_a_file_is_complete(scene):
    opened = boxwood.Scene.from_buffer(pickle_bytes(scene))
    with pytest.raises(ValueError, match="make a new Scene"):
        opened.add_triangles(POINTS, FACES)
    assert_same(opened, scene)


def test_nothing_is_a_scene_too(tmp_path):
    scene = boxwood.Scene()
    scene.save(tmp_path / "nothing.bwx")
    opened = boxwood.Scene.open(tmp_path / "nothing.bwx")
    assert repr(opened) == repr(scene) and not opened.cast_rays(RAYS)["hit"].any()


def test_what_is_wrong_is_said(scene, tmp_path):
    with pytest.raises(FileNotFoundError, match="missing.bwx"):
        boxwood.Scene.open(tmp_path / "missing.bwx")
    (tmp_path / "text.bwx").write_text("v 1 2 3")
    with pytest.raises(ValueError, match=r"text.bwx: is no saved scene .*`Scene.save`.*`Scene.load`"):
        boxwood.Scene.open(tmp_path / "text.bwx")
    content = bytearray(pickle_bytes(scene))
    for cut in (0, 3, 64, len(content) - 1):
        with pytest.raises(ValueError):
            boxwood.Scene.from_buffer(content[:cut])
    content[len(content) // 2] ^= 4
    with pytest.raises(ValueError, match="damaged"):
        boxwood.Scene.from_buffer(content)
    with pytest.raises(OSError, match="no.*folder|exist"):
        scene.save(tmp_path / "no" / "folder.bwx")
    with pytest.raises((TypeError, ValueError)):
        boxwood.Scene.from_buffer(np.arange(3.0)[::2])
