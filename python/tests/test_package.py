"""What the package costs whoever imports it, and whether its examples run."""

import pathlib
import subprocess
import sys

import pytest

HERE = pathlib.Path(__file__).parent


def test_the_import_takes_less_than_fifty_milliseconds_beyond_numpy():
    code = "import numpy, time; begun = time.process_time(); import boxwood; print(time.process_time() - begun)"
    runs = [subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True) for _ in range(3)]
    assert min(float(run.stdout) for run in runs) < 0.05


def test_every_public_name_says_what_it_is():
    import boxwood
    from boxwood import jobs
    from boxwood.trimesh import RayMeshIntersector

    classes = [boxwood.Scene, boxwood.Picture, RayMeshIntersector, jobs.Terrain, jobs.Spinning]
    names = [(owner.__name__, name, getattr(owner, name)) for owner in classes for name in vars(owner) if not name.startswith("_")]
    names += [("jobs", name, getattr(jobs, name)) for name in jobs.__all__]
    silent = [f"{owner}.{name}" for owner, name, thing in names if (callable(thing) or isinstance(thing, property)) and not thing.__doc__]
    assert not silent


def test_the_examples_draw_their_pictures(tmp_path):
    pytest.importorskip("matplotlib")
    # By a plain Python, which finds the modules beside a script.
    environment = {**__import__("os").environ, "PYTHONSAFEPATH": ""}
    subprocess.run([sys.executable, HERE.parent / "examples" / "all.py", tmp_path], check=True, env=environment)
    pictures = sorted(path.name for path in tmp_path.iterdir())
    expected = {path.stem for path in (HERE.parent / "examples").glob("*.py")} - {"all", "terrain"}
    assert pictures == sorted(f"{name}.png" for name in expected)
    assert all((tmp_path / name).stat().st_size > 10_000 for name in pictures)
