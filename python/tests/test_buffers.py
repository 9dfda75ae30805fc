"""Arrays that callers bring, limits ray by ray, and hosts with a floating point mode of their own."""

import subprocess
import sys

import numpy as np
import pytest

import boxwood


@pytest.fixture(scope="module")
def ball():
    return boxwood.Scene.load("builtin:sphere?n=1800")


@pytest.fixture(scope="module")
def rays(ball):
    random = np.random.default_rng(11)
    middle = ball.bounds.mean(axis=0)
    origins = middle + random.normal(size=(40, 50, 3)) * 2
    return np.concatenate([origins, middle - origins + random.normal(size=origins.shape) * 0.5], axis=-1).astype(np.float32)


def test_answers_go_into_the_arrays_of_the_caller(ball, rays):
    expected = ball.cast_rays(rays)
    out = {name: np.full_like(array, 7) for name, array in expected.items()}
    answer = ball.cast_rays(rays, out=out)
    for name, array in expected.items():
        assert answer[name] is out[name]
        assert np.array_equal(out[name], array)
    some = {"t_hit": np.empty((40, 50), np.float32)}
    assert ball.cast_rays(rays, out=some)["t_hit"] is some["t_hit"]


@pytest.mark.parametrize("name", ["test_occlusions", "count_intersections", "compute_distance", "compute_signed_distance", "compute_occupancy"])
def test_calls_with_one_answer_write_it_too(ball, rays, name):
    asked = rays if "inter" in name or "test" in name else rays[..., :3]
    expected = getattr(ball, name)(asked)
    out = np.empty_like(expected)
    assert getattr(ball, name)(asked, out=out) is out
    assert np.array_equal(out, expected)


def test_arrays_that_do_not_fit_are_refused_and_left_alone(ball, rays):
    def refused(kind, match, **out):
        before = {name: np.array(array) for name, array in out.items()}
        with pytest.raises(kind, match=match):
            ball.cast_rays(rays, out=out)
        assert all(np.array_equal(before[name], np.array(array)) for name, array in out.items())

    good = np.zeros((40, 50), np.float32)
    locked = good.copy()
    locked.flags.writeable = False
    refused(TypeError, "type float32", t_hit=good.astype(np.float64))
    refused(TypeError, "numpy array", t_hit=good.tolist())
    refused(ValueError, "shape", t_hit=good.T.copy())
    refused(ValueError, "writable and C-contiguous", t_hit=locked)
    refused(ValueError, "writable and C-contiguous", t_hit=np.zeros((40, 100), np.float32)[:, ::2])
    refused(ValueError, "no answer 'distance'", distance=good)
    refused(ValueError, "shares memory", t_hit=rays.reshape(-1)[:2000].reshape(40, 50))
    with pytest.raises(ValueError, match="shares memory"):
        ids = np.zeros((40, 50), np.uint32)
        ball.cast_rays(rays, out={"geometry_ids": ids, "primitive_ids": ids})


def test_nothing_is_written_when_a_call_fails(ball, rays):
    out = np.full((40, 50), 7, np.float32)
    with pytest.raises(ValueError, match="values for"):
        ball.cast_rays(rays, interpolate={"x": np.array([1.0, 2.0])}, out={"t_hit": out})
    assert (out == 7).all()


def test_limits_may_differ_from_ray_to_ray(ball, rays):
    t = ball.cast_rays(rays)["t_hit"]
    hit = np.isfinite(t)
    assert np.array_equal(np.isfinite(ball.cast_rays(rays, tfar=t)["t_hit"]), hit)
    before = np.nextafter(t, np.float32(0))
    assert not np.isfinite(ball.cast_rays(rays, tfar=before)["t_hit"])[hit].any()
    assert not ball.test_occlusions(rays, tfar=before)[hit].any()
    after = np.where(hit, np.nextafter(t, np.float32(np.inf)), 0)
    rest = ball.count_intersections(rays, tnear=after)
    assert np.array_equal(rest, ball.count_intersections(rays) - hit)
    rows = ball.list_intersections(rays, tfar=np.linspace(0, 3, 40)[:, None])
    assert np.array_equal(np.diff(rows["ray_splits"]), ball.count_intersections(rays, tfar=np.linspace(0, 3, 40)[:, None]).ravel())
    with pytest.raises(ValueError, match="tnear"):
        ball.cast_rays(rays, tnear=np.zeros(3))
    with pytest.raises(TypeError, match="tfar"):
        ball.cast_rays(rays, tfar="far")


def test_both_names_for_threads(ball, rays):
    expected = ball.cast_rays(rays)["t_hit"]
    for options in ({"nthreads": 1}, {"threads": 1}, {"threads": 2, "nthreads": 2}):
        assert np.array_equal(ball.cast_rays(rays, **options)["t_hit"], expected)
    with pytest.raises(ValueError, match="mean the same"):
        ball.cast_rays(rays, 1, threads=2)


def test_double_precision_is_rounded_once(ball, rays):
    wide = rays.astype(np.float64)
    assert np.array_equal(ball.cast_rays(wide)["t_hit"], ball.cast_rays(rays)["t_hit"])


def test_masked_rays_meet_nothing(ball, rays):
    mask = np.zeros(rays.shape, bool)
    mask[3, 4, 5] = True
    hit = ball.cast_rays(np.ma.masked_array(rays, mask))["hit"]
    expected = ball.cast_rays(rays)["hit"].copy()
    expected[3, 4] = False
    assert np.array_equal(hit, expected)


def test_normals_of_tiny_and_of_huge_triangles():
    for size in (1e-30, 1e-20, 1.0, 1e15, 1e25):
        scene = boxwood.Scene()
        scene.add_triangles(np.array([[0, 0, 0], [size, 0, 0], [0, size, 0]], np.float32), [[0, 1, 2]])
        hits = scene.cast_rays(np.array([size / 4, size / 4, size, 0, 0, -1], np.float32))
        if hits["hit"]:
            assert hits["primitive_normals"].tolist() == [0, 0, 1], size
    assert hits["hit"]


FLUSHED = """
import ctypes, mmap, sys
import numpy as np

def flush():
    code = mmap.mmap(-1, mmap.PAGESIZE, prot=mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC)
    code.write(bytes([0x0F, 0xAE, 0x17, 0xC3]))  # ldmxcsr [rdi]; ret
    address = ctypes.addressof(ctypes.c_char.from_buffer(code))
    word = ctypes.c_uint32(0xFFC0 if sys.argv[1] == "all" else 0x9FC0)  # flush, denormals are zero; and all: round towards zero
    ctypes.CFUNCTYPE(None, ctypes.POINTER(ctypes.c_uint32))(address)(ctypes.byref(word))
    return code

tiny = np.float32(1e-40)
if sys.argv[1] != "no":
    keep = flush()
    assert tiny * np.float32(0.5) == 0, "the mode is not set"

import boxwood
scene = boxwood.Scene.load("builtin:bush?n=3000")
vertices, triangles = scene.mesh()
small = boxwood.Scene()
small.add_triangles(vertices * np.float32(2.0**-60), triangles)
random = np.random.default_rng(5)
rays = random.integers(-4096, 4096, (20000, 6)).astype(np.float32) / np.float32(1024)
digest = []
for one, scale in ((scene, 1.0), (small, 2.0**-60)):
    rays_here = rays * np.float32([scale] * 3 + [1] * 3)
    hits = one.cast_rays(rays_here)
    digest += [hits[name].tobytes() for name in sorted(hits)]
    digest += [one.compute_distance(rays_here[:500, :3]).tobytes(), one.count_intersections(rays_here).tobytes()]
    digest.append(one.render((32, 24), samples=1).linear.tobytes())
import hashlib
print(hashlib.sha256(b"".join(digest)).hexdigest())
if sys.argv[1] != "no":
    assert tiny * np.float32(0.5) == 0, "the host's mode was changed"
"""


@pytest.mark.skipif(sys.platform != "linux" or __import__("platform").machine() != "x86_64", reason="sets a register of x86-64")
def test_a_host_that_flushes_denormals_or_rounds_otherwise_changes_no_answer():
    answers = []
    for mode in ("no", "flush", "all"):
        run = subprocess.run([sys.executable, "-c", FLUSHED, mode], capture_output=True, text=True)
        assert run.returncode == 0, run.stderr
        answers.append(run.stdout)
    assert answers[0] == answers[1] == answers[2]
