"""Pictures: what is in them, that they are always the same, and that they end when asked to."""

import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import boxwood


@pytest.fixture(scope="module")
def bush():
    return boxwood.Scene.load("builtin:bush?n=3000")


@pytest.fixture(scope="module")
def cornell():
    return boxwood.Scene.load("builtin:cornell")


def floor_and_wall():
    scene = boxwood.Scene()
    scene.add_triangles([[-1, -1, 0], [1, -1, 0], [-1, 1, 0], [1, 1, 0]], [[0, 1, 2], [1, 3, 2]])
    scene.add_triangles([[-1, -1, -1], [1, -1, -1], [-1, 1, -1], [3, 1, -1]], [[0, 1, 2], [1, 3, 2]])
    return scene


def test_a_camera_is_found_and_the_scene_is_in_the_middle(bush):
    picture = bush.render((64, 48), samples=1)
    assert picture.pixels.shape == (48, 64, 3) and picture.pixels.dtype == np.uint8
    assert picture.linear.shape == (48, 64, 3) and picture.linear.dtype == np.float32
    assert np.isfinite(picture.depth[16:32, 20:44]).mean() > 0.5
    again = bush.render((64, 48), samples=1, **picture.camera)
    assert np.array_equal(again.pixels, picture.pixels)


def test_the_layers_say_what_cast_rays_says():
    scene = floor_and_wall()
    picture = scene.render((31, 21), eye=[0.2, 0.1, 5], target=[0.2, 0.1, 0], up=[0, 1, 0], fov_deg=45, shading="eyelight")
    focal = 21 / 2 / np.tan(np.radians(45 / 2))
    rays = boxwood.Scene.create_rays_pinhole(
        fov_deg=np.degrees(2 * np.arctan(31 / 2 / focal)), center=[0.2, 0.1, 0], eye=[0.2, 0.1, 5], up=[0, 1, 0], width_px=31, height_px=21
    )
    hits = scene.cast_rays(rays)
    assert set(np.unique(picture.geometry_ids)) == {0, 1, boxwood.INVALID_ID}
    assert np.array_equal(picture.geometry_ids, hits["geometry_ids"])
    assert np.array_equal(picture.primitive_ids, hits["primitive_ids"])
    length = np.linalg.norm(rays[..., 3:], axis=-1)
    np.testing.assert_allclose(picture.depth, hits["t_hit"] * length, rtol=1e-5)
    assert np.array_equal(np.linalg.norm(picture.normals, axis=-1) > 0, hits["hit"])


@pytest.mark.parametrize("shading", ["whitted", "path", "ao", "eyelight", "normal", "prim"])
def test_a_crop_has_the_bits_of_the_whole(cornell, shading):
    whole = cornell.render((70, 50), shading=shading, samples=2, seed=7)
    left, top, width, height = 19, 11, 33, 21
    part = cornell.render((70, 50), shading=shading, samples=2, seed=7, crop=(left, top, width, height))
    assert part.crop == (left, top, width, height) and part.full_size == (70, 50)
    for name in ("pixels", "linear", "depth", "normals", "primitive_ids"):
        assert np.array_equal(getattr(part, name), getattr(whole, name)[top : top + height, left : left + width]), name


def test_heat_crops_agree_when_the_scale_is_given(bush):
    whole = bush.render((64, 48), shading="heat-tests", top=60)
    part = bush.render((64, 48), shading="heat-tests", top=60, crop=(10, 20, 30, 25))
    assert np.array_equal(part.pixels, whole.pixels[20:45, 10:40])


def test_threads_do_not_matter(cornell):
    one, two = (cornell.render((40, 30), shading="path", samples=4, threads=n).linear for n in (1, 2))
    assert np.array_equal(one, two)


def test_materials_of_a_file_are_shown_also_after_pickle(cornell):
    def colours(scene):
        return scene.render((40, 40), shading="path", samples=8).linear

    linear = colours(cornell)
    assert (linear[..., 0] > 2 * linear[..., 1]).any() and (linear[..., 1] > 1.5 * linear[..., 0]).any()
    assert np.array_equal(colours(pickle.loads(pickle.dumps(cornell))), linear)


def test_map_coordinates_are_rendered_where_they_are():
    far = np.array([448_262.125, 5_411_932.678, 100.0])
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]])
    scene = boxwood.Scene()
    scene.add_triangles(corners * 0.01 + far, [[0, 1, 2]])
    middle = far + [0.003, 0.003, 0]
    picture = scene.render((9, 9), eye=middle + [0, 0, 0.05], target=middle, up=[0, 1, 0], shading="eyelight")
    assert abs(picture.depth[4, 4] - 0.05) < 1e-6
    np.testing.assert_allclose(picture.camera["eye"], middle + [0, 0, 0.05], rtol=0, atol=1e-8)


def test_pictures_are_saved_and_shown(bush, tmp_path):
    picture = bush.render((32, 24), shading="normal")
    picture.save(tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes() == picture.png() == picture._repr_png_()
    picture.save(tmp_path / "a.EXR")
    assert (tmp_path / "a.EXR").read_bytes()[:4] == b"\x76\x2f\x31\x01"
    assert np.array_equal(np.asarray(picture), picture.pixels)
    assert bush._repr_png_()[:8] == b"\x89PNG\r\n\x1a\n"
    assert boxwood.Scene()._repr_png_() is None
    with pytest.raises(ValueError, match="saved as .png or .exr"):
        picture.save(tmp_path / "a.jpg")
    with pytest.raises(OSError, match="folder does not exist"):
        picture.save(tmp_path / "none" / "a.png")


@pytest.mark.parametrize(
    "options, word",
    [
        ({"size": (0, 5)}, "65535"),
        ({"size": (5,)}, "size"),
        ({"shading": "none"}, "whitted"),
        ({"samples": 0}, "samples"),
        ({"crop": (0, 0, 99, 1)}, "crop"),
        ({"eye": [0, 0, 0], "target": [0, 0, 0]}, "eye"),
        ({"eye": [np.nan, 0, 0]}, "finite"),
        ({"eye": [0, 0]}, "eye"),
        ({"fov_deg": 180}, "field of view"),
        ({"lights": [[0, 0]]}, "light"),
        ({"samples": -1}, "samples"),
        ({"seed": 2**64}, "seed"),
        ({"sky": -1}, "sky"),
        ({"exposure": np.nan}, "exposure"),
        ({"top": np.inf}, "top"),
    ],
)
def test_what_makes_no_picture_is_told(bush, options, word):
    with pytest.raises(ValueError, match=word):
        bush.render(**{"size": (20, 20), **options})


def test_an_empty_scene_has_no_picture():
    with pytest.raises(ValueError, match="no triangles"):
        boxwood.Scene().render((4, 4))


def test_other_threads_go_on_while_a_picture_is_made(bush):
    ticks = []
    work = threading.Thread(target=lambda: bush.render((400, 300), samples=64, threads=1))
    work.start()
    while work.is_alive():
        ticks.append(time.perf_counter())
        time.sleep(0.001)
    assert len(ticks) > 20


def test_ctrl_c_ends_a_long_picture():
    code = (
        "import boxwood; s = boxwood.Scene.load('builtin:bush')\n"
        "print('begun', flush=True)\n"
        "try: s.render((4000, 3000), shading='path', samples=10000)\n"
        "except KeyboardInterrupt: print('ended', flush=True)"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "begun\n"
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    begun = time.monotonic()
    out, _ = process.communicate(timeout=30)
    assert out == "ended\n"
    assert time.monotonic() - begun < 5


def test_a_saved_scene_makes_the_pictures_it_was_saved_from(tmp_path):
    loaded = boxwood.Scene.load("builtin:cornell")
    loaded.add_triangles([[0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 9, 9]], [[0, 1, 2]])
    loaded.save(tmp_path / "scene.bwx")
    opened = boxwood.Scene.open(tmp_path / "scene.bwx")
    for shading in ("whitted", "path", "part"):
        assert np.array_equal(opened.render((60, 40), shading=shading).pixels, loaded.render((60, 40), shading=shading).pixels), shading


def test_a_file_that_counts_vertices_it_does_not_have_takes_no_memory(tmp_path):
    from boxwood._native import NativeScene

    positions, triangles = np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.uint32)
    notes = [("vertices", (2**40).to_bytes(8, "little")), ("indices", np.array([7, 2**31, 2**32 - 1], "<u4").tobytes())]
    NativeScene([(positions, triangles)], np.zeros(3), "default", 1, notes).save(str(tmp_path / "scene.bwx"), 1)
    picture = boxwood.Scene.open(tmp_path / "scene.bwx").render((8, 8), eye=[3, 3, 3], target=[0, 0, 0])
    assert picture.primitive_ids[4, 4] == 0


def test_a_file_without_notes_makes_plain_pictures(tmp_path):
    from boxwood._native import NativeScene

    bush = boxwood.Scene.load("builtin:bush")
    positions, triangles = bush._meshes[0]
    NativeScene([(positions, triangles)], np.zeros(3), "default", 1, []).save(str(tmp_path / "scene.bwx"), 1)
    plain = boxwood.Scene()
    plain.add_triangles(positions, triangles)
    opened = boxwood.Scene.open(tmp_path / "scene.bwx")
    assert np.array_equal(opened.render((60, 40)).pixels, plain.render((60, 40)).pixels)
