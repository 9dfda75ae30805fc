"""Lazy questions, and jobs that survive what happens to machines: the answers are always the bytes of one process."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading

import numpy as np
import pytest

import boxwood

pytest.importorskip("distributed", reason="needs boxwood[dask]")

import boxwood.cluster
import boxwood.dask
import dask
import dask.array as da
from boxwood.cluster.cli import main
from boxwood.cluster.interrupts import Interrupts
from boxwood.cluster.questions import QUESTIONS
from loopback import Loopback, kill, until

RAYS = 1_000_000
BLOCK = 25_000


@pytest.fixture(scope="module")
def scene():
    return boxwood.Scene.load("builtin:bush")


@pytest.fixture(scope="module")
def shared(tmp_path_factory):
    return tmp_path_factory.mktemp("shared")


@pytest.fixture(scope="module")
def ref(scene, shared):
    return boxwood.dask.SceneRef.save(scene, shared / "scene.bwx")


@pytest.fixture(scope="module")
def rays():
    return np.random.default_rng(7).normal(size=(RAYS, 6)).astype(np.float32)


@pytest.fixture(scope="module")
def file(rays, shared):
    np.save(shared / "rays.npy", rays)
    return shared / "rays.npy"


@pytest.fixture(scope="module")
def answer(scene, rays):
    return scene.cast_rays(rays)


@pytest.fixture(scope="module")
def few(rays):
    return da.from_array(rays[:5_000], chunks=(1_000, 4))


def same(found, wanted):
    assert list(found) == list(wanted)
    for name, array in wanted.items():
        one = found[name].compute()
        assert one.dtype == array.dtype and one.shape == array.shape, name
        assert one.tobytes() == array.tobytes(), name


@pytest.mark.parametrize("name", QUESTIONS)
def test_a_lazy_question_has_the_answer_of_the_scene(name, scene, ref, few):
    rows = few[:, : QUESTIONS[name].columns]
    lazy = getattr(boxwood.dask, name)(ref, rows)
    wanted = getattr(scene, name)(rows.compute())
    if not isinstance(wanted, dict):
        lazy, wanted = {"it": lazy}, {"it": wanted}
    assert set(lazy) == set(wanted)
    for field, array in lazy.items():
        assert array.chunks[0] == rows.chunks[0]
        assert (array._meta.dtype, array._meta.ndim) == (array.dtype, array.ndim)
        found = array.compute(scheduler="threads")
        assert (found.dtype, found.shape) == (array.dtype, array.shape)
        # Places are float64 here wherever the scene is.
        assert found.tobytes() == wanted[field].astype(found.dtype).tobytes(), field


def test_nothing_is_opened_before_it_is_asked_for(few):
    nowhere = boxwood.dask.SceneRef("/nowhere.bwx", "0" * 64)
    lazy = boxwood.dask.test_occlusions(nowhere, few, tnear=0.5, tfar=1.5)
    with pytest.raises(OSError, match="nowhere.bwx"):
        lazy.compute(scheduler="threads")


def test_rays_keep_their_leading_shape_and_arguments_count(scene, ref, rays):
    image = da.from_array(rays[:600].reshape(20, 30, 6), chunks=(7, 30, 3))
    found = boxwood.dask.test_occlusions(ref, image, tfar=0.5)
    assert found.shape == (20, 30)
    assert np.array_equal(found.compute(), scene.test_occlusions(rays[:600].reshape(20, 30, 6), tfar=0.5))
    assert found.sum().compute() < boxwood.dask.test_occlusions(ref, image).sum().compute()
    assert boxwood.dask.cast_rays(ref, image)["primitive_normals"].compute().shape == (20, 30, 3)


def test_what_cannot_be_asked_is_said_at_once(scene, ref, few, rays, tmp_path):
    with pytest.raises(TypeError, match="da.from_array"):
        boxwood.dask.cast_rays(ref, rays)
    with pytest.raises(ValueError, match=r"rays must have the shape \(..., 6\), not \(5000, 3\)"):
        boxwood.dask.cast_rays(ref, few[:, :3])
    with pytest.raises(TypeError, match="rays must be numbers"):
        boxwood.dask.cast_rays(ref, few.astype(bool))
    with pytest.raises(ValueError, match="the questions about such are compute_closest_points, compute_distance"):
        boxwood.dask.cast_rays(ref, few[:, :3])
    with pytest.raises(TypeError, match="compute_distance takes no 'tnear'"):
        boxwood.dask.compute_distance(ref, few[:, :3], tnear=1)
    with pytest.raises(TypeError, match=r"cast_rays takes no 'fields'.* tnear and tfar; .*run_rays\(..., fields=...\)"):
        boxwood.dask.cast_rays(ref, few, fields=["t_hit"])
    with pytest.raises(TypeError, match="SceneRef.save"):
        boxwood.dask.cast_rays(scene, few)
    with pytest.raises(ValueError, match="not with 'colour'"):
        boxwood.dask.run_rays(ref, few, tmp_path, fields=["colour"])
    with pytest.raises(ValueError, match="none of the questions"):
        boxwood.dask.run_rays(ref, few, tmp_path, question="why")


def test_another_scene_under_the_path_is_refused(ref, few):
    other = boxwood.dask.SceneRef(ref.path, "0" * len(ref.content_hash))
    with pytest.raises(boxwood.dask.SceneMismatch, match=ref.content_hash):
        boxwood.dask.cast_rays(other, few)["hit"].compute(scheduler="threads")


def test_a_scene_by_url_is_copied_once_and_verified(ref, few, scene, tmp_path, monkeypatch):
    monkeypatch.setenv("BOXWOOD_CACHE", str(tmp_path))
    monkeypatch.setattr(boxwood.cluster.reference, "_open", type(boxwood.cluster.reference._open)())
    remote = boxwood.dask.SceneRef("file://" + ref.path, ref.content_hash)
    found = boxwood.dask.count_intersections(remote, few).compute(scheduler="threads")
    assert np.array_equal(found, scene.count_intersections(few.compute()))
    copy = tmp_path / f"{ref.content_hash}.bwx"
    before = copy.stat().st_mtime_ns
    boxwood.cluster.reference._open.clear()
    boxwood.cluster.open(remote)
    assert copy.stat().st_mtime_ns == before
    # A damaged copy is fetched anew; a wrong original is refused.
    copy.write_bytes(copy.read_bytes()[:-1])
    boxwood.cluster.reference._open.clear()
    boxwood.cluster.open(remote)
    with pytest.raises(boxwood.dask.SceneMismatch):
        boxwood.cluster.open(boxwood.dask.SceneRef(remote.path, "1" * 64))


def test_a_job_keeps_what_is_whole_and_mends_what_is_not(ref, few, scene, tmp_path):
    wanted = scene.cast_rays(few.compute())
    report = boxwood.dask.run_rays(ref, few, tmp_path)
    assert (report.done, report.kept, report.failed) == (5, 0, {})
    assert report.counts == {"rays": 5_000, "hits": int(wanted["hit"].sum())}
    same(boxwood.dask.read(tmp_path), wanted)
    assert boxwood.dask.run_rays(ref, few, tmp_path).kept == 5

    # One file is gone, one has another bit, a killed process left half a file and half a line.
    (tmp_path / "blocks/000001.npz").unlink()
    damaged = bytearray((tmp_path / "blocks/000003.npz").read_bytes())
    damaged[2_000] ^= 1
    (tmp_path / "blocks/000003.npz").write_bytes(damaged)
    (tmp_path / "blocks/.000003.npz.0.part").write_bytes(b"half")
    with open(tmp_path / "receipts.jsonl", "a") as receipts:
        receipts.write('{"block": 4, "by')
    assert main(["status", str(tmp_path), "--check"]) == 4
    assert boxwood.dask.run_rays(ref, few, tmp_path).kept == 3
    assert not list(tmp_path.glob("blocks/.*"))
    assert main(["status", str(tmp_path), "--check"]) == 0
    same(boxwood.dask.read(tmp_path), wanted)


def test_only_the_fields_that_are_wanted_are_kept(ref, few, scene, tmp_path):
    boxwood.dask.run_rays(ref, few, tmp_path, fields=["t_hit", "primitive_ids"])
    wanted = scene.cast_rays(few.compute())
    same(boxwood.dask.read(tmp_path), {name: wanted[name] for name in ("t_hit", "primitive_ids")})


def test_another_job_in_the_same_folder_is_refused_by_field(ref, few, file, scene, shared, tmp_path):
    boxwood.dask.run_rays(ref, few, tmp_path, question="test_occlusions", tfar=2.0)
    moved = boxwood.Scene()
    moved.add_triangles([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    other = boxwood.dask.SceneRef.save(moved, shared / "other.bwx")
    asked = {"ref": ref, "rays": few, "question": "test_occlusions", "tfar": 2.0}
    for change, fields in [
        ({"ref": other}, ["scene"]),
        ({"tfar": 3.0}, ["arguments.tfar"]),
        ({"rays": few + 1}, ["rays.name"]),
        ({"rays": few[:4_000]}, ["blocks", "rays.count", "rays.name"]),
        ({"question": "count_intersections", "tfar": None}, ["arguments.tfar", "fields", "question"]),
    ]:
        now = {name: value for name, value in {**asked, **change}.items() if value is not None}
        with pytest.raises(boxwood.dask.JobRefused) as refused:
            boxwood.dask.run_rays(out=tmp_path, **now)
        assert refused.value.fields == fields
        assert fields[0] in str(refused.value)
    job = json.loads((tmp_path / "job.json").read_text())
    (tmp_path / "job.json").write_text(json.dumps({**job, "boxwood": "0.0.1"}))
    with pytest.raises(boxwood.dask.JobRefused, match="boxwood was '0.0.1'"):
        boxwood.dask.run_rays(out=tmp_path, **asked)


def test_a_file_of_rays_that_changed_is_refused_by_block(ref, rays, tmp_path):
    np.save(tmp_path / "rays.npy", rays[:3_000])
    boxwood.dask.run_rays(ref, tmp_path / "rays.npy", tmp_path / "job", block=1_000)
    changed = rays[:3_000].copy()
    changed[2_500, 0] += 1
    np.save(tmp_path / "rays.npy", changed)
    with pytest.raises(boxwood.dask.JobRefused, match="rays of block 2"):
        boxwood.dask.run_rays(ref, tmp_path / "rays.npy", tmp_path / "job", block=1_000)


def test_two_runs_do_not_share_a_folder(ref, few, tmp_path):
    with boxwood.cluster.JobFolder(tmp_path).lock(), pytest.raises(RuntimeError, match="another run is at work"):
        boxwood.dask.run_rays(ref, few, tmp_path)


def test_progress_is_told(ref, few, tmp_path):
    told = []
    boxwood.dask.run_rays(
        ref, few, tmp_path, progress=lambda progress: told.append((progress.done, progress.eta, progress.rate, str(progress)))
    )
    assert [done for done, *_ in told] == [1, 2, 3, 4, 5]
    assert told[0][1] > 0 and told[-1][1] == 0 and told[-1][2] > 0
    assert told[0][3].startswith("1/5 blocks, ")


@pytest.mark.parametrize("shading", boxwood.SHADINGS)
def test_tiles_make_the_picture_of_one_process(shading, ref, scene, tmp_path):
    wanted = scene.render((75, 50), shading=shading, samples=2)
    try:
        report = boxwood.dask.render(ref, tmp_path, (75, 50), tile=(32, 24), shading=shading, samples=2)
    except ValueError as error:
        assert "scale over the whole picture" in str(error)
        assert wanted.png() != scene.render((75, 50), shading=shading, samples=2, crop=(0, 0, 32, 24)).png()
        report = boxwood.dask.render(ref, tmp_path, (75, 50), shading=shading, samples=2)
        assert report.blocks == 1
    else:
        assert (report.blocks, report.counts) == (10, {"pixels": 75 * 50, "pictures": 1})
    assert (tmp_path / "frames/0000.png").read_bytes() == wanted.png()


def test_pictures_are_refused_before_they_are_begun(ref, tmp_path):
    for wrong, why in [
        ({"size": (0, 5)}, "65,535"),
        ({"cameras": [{"eye": [0, 0, 5], "zoom": 2}]}, "zoom"),
        ({"frames": [3]}, "no camera for frame 3"),
        ({"shading": "oil"}, "none of the shadings"),
        ({"tile": 0}, "tile must be"),
        ({"colour": 1}, "takes no 'colour'"),
    ]:
        with pytest.raises((ValueError, TypeError), match=why):
            boxwood.dask.render(ref, tmp_path / "no", **wrong)
    assert not (tmp_path / "no").exists()


@pytest.fixture(scope="module")
def cluster():
    with Loopback(3) as cluster, cluster.client() as client:
        yield cluster, client


def test_a_killed_worker_and_a_new_one_change_no_byte(cluster, ref, file, answer, tmp_path):
    cluster, client = cluster

    def happen(progress):
        if progress.done == 6:
            kill(cluster.workers.pop(0))
        if progress.done == 12:
            cluster.add_worker()

    report = boxwood.dask.run_rays(ref, file, tmp_path, client=client, block=BLOCK, progress=happen)
    assert (report.blocks, report.done, report.failed) == (RAYS // BLOCK, RAYS // BLOCK, {})
    same(boxwood.dask.read(tmp_path), answer)
    until(lambda: len(client.nthreads()) == 3)


def test_a_poisoned_block_fails_alone(cluster, ref, rays, scene, tmp_path):
    _, client = cluster
    dust = da.from_array(rays[:80_000], chunks=(10_000, 6))
    poisoned = dust.map_blocks(at_block(3, poison()), dtype=dust.dtype)
    with pytest.raises(boxwood.dask.BlocksFailed, match="block 3 failed: ValueError: poison") as failed:
        boxwood.dask.run_rays(ref, poisoned, tmp_path, client=client)
    assert list(failed.value.report.failed) == [3] and failed.value.report.done == 7
    assert main(["status", str(tmp_path)]) == 1
    with pytest.raises(ValueError, match="1 of 8 blocks are missing, the first is 3"):
        boxwood.dask.read(tmp_path)
    with np.load(tmp_path / "blocks/000004.npz") as block:
        assert block["t_hit"].tobytes() == scene.cast_rays(rays[40_000:50_000])["t_hit"].tobytes()


def test_tiles_survive_a_killed_worker(cluster, ref, scene, tmp_path):
    cluster, client = cluster
    looks = {"shading": "path", "samples": 4}

    def happen(progress):
        if progress.done == 10:
            kill(cluster.workers.pop())
            cluster.add_worker()

    report = boxwood.dask.render(ref, tmp_path, (192, 128), tile=(24, 16), client=client, progress=happen, **looks)
    assert report.blocks == 64 + 1
    assert (tmp_path / "frames/0000.png").read_bytes() == scene.render((192, 128), **looks).png()


def test_frames_are_those_of_one_process(cluster, ref, scene, tmp_path):
    _, client = cluster
    turns = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    cameras = [{"eye": np.array([6 * np.cos(turn), 2.0, 6 * np.sin(turn)]), "target": [0, 1, 0], "fov_deg": 40} for turn in turns]
    boxwood.dask.render(ref, tmp_path, (64, 36), cameras=cameras, client=client, shading="heat-tests")
    for number, camera in enumerate(cameras):
        assert (tmp_path / f"frames/{number:04}.png").read_bytes() == scene.render((64, 36), shading="heat-tests", **camera).png()
    assert len(list(tmp_path.glob("frames/*"))) == 24


def test_lazy_answers_survive_a_killed_worker(cluster, ref, rays, answer):
    cluster, client = cluster
    count = 300_000
    lazy = boxwood.dask.cast_rays(ref, da.from_array(rays[:count], chunks=(10_000, 6)))
    future = client.compute(lazy)
    until(lambda: sum(map(len, client.has_what().values())) > 5)
    kill(cluster.workers.pop(0))
    found = future.result(timeout=60)
    cluster.add_worker()
    for name, array in answer.items():
        assert found[name].tobytes() == array[:count].tobytes(), name


def test_a_killed_scheduler_ends_the_run_and_another_goes_on(ref, file, answer, tmp_path):
    job = tmp_path / "job"
    with Loopback(2) as cluster:
        cluster.client().close()  # Once workers are there, the command has none to wait for and says nothing of it.
        process = run("rays", ref.path, file, "--out", job, "--block", BLOCK, "--scheduler", cluster.address)
        until(lambda: len(list(job.glob("blocks/0*"))) > 5)
        kill(cluster.scheduler)
        code, _, told = ended(process)
    assert code == 4
    assert (
        told.startswith("error: the scheduler is gone; ")
        and f"of {RAYS // BLOCK} blocks are saved" in told
        and told.count("\n") == 1
    )
    with Loopback(2) as cluster, cluster.client() as client:
        report = boxwood.dask.run_rays(ref, file, job, client=client, block=BLOCK)
    assert 1 <= report.kept < report.done == RAYS // BLOCK
    same(boxwood.dask.read(job), answer)


def test_a_block_that_kills_its_workers_is_told_from_those_beside_it(ref, rays, tmp_path):
    dust = da.from_array(rays[:60_000], chunks=(10_000, 6))
    # Workers of a LocalCluster have nannies, which bring them back.
    with dask.config.set({"distributed.scheduler.allowed-failures": 1}):
        from distributed import Client, LocalCluster

        with (
            LocalCluster(
                n_workers=2, threads_per_worker=2, host="127.0.0.1", dashboard_address="127.0.0.1:0", silence_logs=50
            ) as cluster,
            Client(cluster) as client,
        ):
            with pytest.raises(boxwood.dask.BlocksFailed) as failed:
                boxwood.dask.run_rays(
                    ref, dust.map_blocks(at_block(3, lambda: os._exit(1)), dtype=dust.dtype), tmp_path, client=client
                )
    assert failed.value.report.failed == {3: "the workers that computed it died, one after the other"}
    assert failed.value.report.done == 5


def test_without_any_worker_a_run_gives_up_after_its_patience(ref, file, tmp_path):
    with Loopback(0) as cluster:
        from distributed import Client

        with (
            Client(cluster.address, set_as_default=False) as client,
            pytest.raises(boxwood.dask.ClusterLost, match="no worker and no answer for 1 s"),
        ):
            boxwood.dask.run_rays(ref, file, tmp_path, client=client, patience=1)


def run(*arguments, **options):
    """The command line, as a process with a process group of its own."""
    environment = {**os.environ, "PYTHONSAFEPATH": "1"}
    return subprocess.Popen(
        [sys.executable, "-m", "boxwood.cluster", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
        start_new_session=True,
        **options,
    )


def ended(process, seconds=90):
    out, told = process.communicate(timeout=seconds)
    return process.returncode, out, told


def test_the_command_line_interrupted_and_resumed(ref, file, answer, tmp_path):
    job = tmp_path / "job"
    # So many blocks that on a fast machine, too, some are left when it is interrupted.
    command = ("rays", ref.path, file, "--out", job, "--block", BLOCK // 10, "--workers", 2)
    process = run(*command)
    until(lambda: len(list(job.glob("blocks/0*"))) > 5)
    os.killpg(process.pid, signal.SIGINT)  # As a terminal does: to the workers, too.
    code, _, told = ended(process)
    assert (code, told) == (4, "error: interrupted; what is done is saved, the same command goes on\n")
    assert main(["status", str(job)]) == 4

    # The machine fails; then all is well.
    process = run(*command)
    begun = len(list(job.glob("blocks/0*")))
    until(lambda: len(list(job.glob("blocks/0*"))) > begun + 5)
    os.killpg(process.pid, signal.SIGKILL)
    ended(process)
    code, out, told = ended(run(*command, "--resume", "--json"))
    assert (code, told) == (0, "")
    report = json.loads(out)
    assert report["kept"] >= 5 and report["counts"]["rays"] == RAYS
    same(boxwood.dask.read(job), answer)
    assert main(["status", str(job), "--check"]) == 0


def test_an_interrupt_that_the_interpreter_drops_is_not_lost(capsys):
    class Swallows:
        def __del__(self):
            signal.raise_signal(signal.SIGINT)

    interrupts, told = Interrupts(), []
    before = signal.getsignal(signal.SIGINT)
    with interrupts.listen():
        heeded = interrupts.heeded(told.append)
        heeded("before")
        one = Swallows()
        del one
        with pytest.raises(KeyboardInterrupt):
            heeded("after")
    assert told == ["before"] and capsys.readouterr().err == ""
    assert signal.getsignal(signal.SIGINT) is before


def test_the_command_line_on_a_scheduler(cluster, ref, scene, tmp_path):
    cluster, _ = cluster
    cameras = tmp_path / "cameras.json"
    cameras.write_text(json.dumps([{"eye": [0, 2, 5], "target": [0, 1, 0]}] * 2))
    code, out, told = ended(
        run(
            "render",
            ref.path,
            "--out",
            tmp_path / "film",
            "--size",
            "48x32",
            "--tile",
            16,
            "--cameras",
            cameras,
            "--frames",
            "0-1",
            "--scheduler",
            cluster.address,
        )
    )
    assert (code, told) == (0, "")
    assert "3,072 pixels, 2 pictures" in out
    assert (tmp_path / "film/frames/0001.png").read_bytes() == scene.render((48, 32), eye=[0, 2, 5], target=[0, 1, 0]).png()


@pytest.fixture
def silence():
    """An address where a connection is taken and nothing is ever said."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield f"tcp://127.0.0.1:{server.getsockname()[1]}"


def test_a_scheduler_that_is_not_there_is_waited_for(ref, file, silence, tmp_path):
    command = ("rays", ref.path, file, "--out", tmp_path / "job", "--scheduler", silence, "--patience")
    code, out, told = ended(run(*command, 2), 30)
    waits, error = told.splitlines()
    assert (code, out) == (2, "")
    assert waits == f"waiting for a scheduler at {silence}, 2 s at most"
    assert error.startswith(f"error: no scheduler answers at {silence}: ")

    process = run(*command, 300)
    assert process.stderr.readline().startswith("waiting")
    process.send_signal(signal.SIGTERM)
    assert ended(process, 10) == (4, "", "error: interrupted\n")


def test_the_exit_codes(ref, rays, tmp_path, capsys):
    small = tmp_path / "rays.npy"
    np.save(small, rays[:3_000])
    job, here = tmp_path / "job", ("--workers", "0")

    # Something stands where block 1 should go: that one fails, the others are saved.
    (job / "blocks/000001.npz").mkdir(parents=True)
    command = ["rays", ref.path, str(small), "--out", str(job), "--block", "1000", *here]
    assert main(command) == 1
    told = capsys.readouterr().err
    assert "block 1 failed: IsADirectoryError" in told and "2 of 3 blocks are saved" in told
    (job / "blocks/000001.npz").rmdir()
    assert main(command) == 0
    assert "3 blocks (2 were there), 3,000 rays" in capsys.readouterr().out

    assert main([*command, "--question", "test_occlusions"]) == 3
    assert "question was 'cast_rays', is 'test_occlusions' now" in capsys.readouterr().err
    (tmp_path / "torn.npy").write_bytes(small.read_bytes()[:-9])
    np.save(tmp_path / "points.npy", rays[:9, :3])
    np.save(tmp_path / "image.npy", rays[:48].reshape(6, 8, 6))
    for wrong, code, why in [
        (["rays", "missing.bwx", str(small), "--out", str(tmp_path / "a"), *here], 3, "missing.bwx"),
        (["rays", ref.path, "missing.npy", "--out", str(tmp_path / "a"), *here], 3, "missing.npy"),
        (["rays", ref.path, str(tmp_path / "torn.npy"), "--out", str(tmp_path / "a"), *here], 3, "not an .npy file of numbers"),
        (["rays", ref.path, str(tmp_path / "points.npy"), "--out", str(tmp_path / "a"), *here], 3, "about such are compute_closest"),
        (["rays", ref.path, str(tmp_path / "image.npy"), "--out", str(tmp_path / "a"), *here], 3, "save array.reshape(-1, 6)"),
        (["rays", ref.path, str(small), "--out", str(tmp_path / "a"), "--resume", *here], 2, "no job to go on with"),
        (["rays", ref.path, str(small), "--out", str(tmp_path / "a"), "--fields", "colour", *here], 2, "not with 'colour'"),
        (["rays", ref.path, str(small), "--out", "/dev/null/a", *here], 2, "/dev/null"),
        (["status", str(tmp_path / "a")], 3, "is no job's folder"),
        (
            ["render", ref.path, "--out", str(tmp_path / "a"), "--tile", "16", "--shading", "depth", *here],
            2,
            "leave out the tiles",
        ),
    ]:
        assert main(wrong) == code, wrong
        told = capsys.readouterr().err
        assert told.startswith("error: ") and why in told and told.count("\n") == 1
    for wrong in (["rays"], ["rays", "a", "b", "--out", "c", "--block", "0"], ["render", "a", "--out", "c", "--eye", "1,2"]):
        with pytest.raises(SystemExit) as ended_by:
            main(wrong)
        assert ended_by.value.code == 2
    capsys.readouterr()


@pytest.mark.parametrize("command", ["rays", "render", "status"])
def test_the_help_has_examples(command, capsys):
    with pytest.raises(SystemExit) as ended_by:
        main([command, "--help"])
    assert ended_by.value.code == 0
    assert f"python -m boxwood.cluster {command} " in capsys.readouterr().out.split("Examples:")[1]


def at_block(number, happens):
    """For ``map_blocks``: something happens in one block. (A function within a function goes to workers by value.)"""

    def passed(block, block_id=None):
        if block_id == (number, 0):
            happens()
        return block

    return passed


def poison():
    """For :func:`at_block`."""

    def happens():
        raise ValueError("poison")

    return happens
