"""The command line of ``python -m boxwood.cluster``."""

from __future__ import annotations

import argparse
import contextlib
from typing import Any, NoReturn

from .. import __version__
from ..studio import SHADINGS
from .questions import QUESTIONS

EPILOG = """\
Where a job runs: on the cluster of --scheduler; else on --workers processes of this machine; with --workers 0 in this process.
OUT and the input files must be seen under the same names by all machines. The same command again goes on where the last one ended.

Exit codes: 0 all well, 1 some blocks failed and all others are saved, 2 wrong usage or output that cannot be written, 3 an input was
refused, 4 interrupted, or the cluster was lost: what is done is saved, the same command goes on.
"""

RAYS_EXAMPLES = """\
Examples:
  python -m boxwood.cluster rays scene.bwx rays.npy --out hits
  python -m boxwood.cluster rays /shared/scene.bwx /shared/rays.npy --out /shared/hits --scheduler tcp://10.0.0.1:8786
  python -m boxwood.cluster rays terrain.ply sun.npy --out shade --question test_occlusions --workers 4
"""

RENDER_EXAMPLES = """\
Pictures are OUT/frames/0000.png and so on: the bytes of Scene.render(...).png().

Examples:
  python -m boxwood.cluster render scene.bwx --out picture --size 1920x1080 --tile 256 --shading path --samples 64
  python -m boxwood.cluster render scene.bwx --out film --cameras cameras.json --frames 0-239 --scheduler tcp://10.0.0.1:8786

cameras.json is a list with an object for each frame: [{"eye": [0, 1, 5], "target": [0, 0, 0], "up": [0, 1, 0], "fov_deg": 45}, ...]
"""

STATUS_EXAMPLES = """\
Exit codes: 0 complete, 1 some blocks failed, 3 no job there, 4 not complete yet.

Examples:
  python -m boxwood.cluster status hits
  python -m boxwood.cluster status hits --check --json
"""


def parser() -> argparse.ArgumentParser:
    """The command line."""
    about = "Rays and pictures that are too many for one machine, or for one run."
    whole = argparse.ArgumentParser("python -m boxwood.cluster", description=about, epilog=EPILOG, formatter_class=_Plain)
    whole.add_argument("--version", action="version", version=f"boxwood {__version__}")
    commands = whole.add_subparsers(dest="command", metavar="COMMAND", required=True)
    rays = _command(commands, "rays", "ask a question for every ray of a file", RAYS_EXAMPLES + "\n" + EPILOG)
    rays.add_argument("scene", metavar="SCENE", help="a .bwx file, or a model (it is saved as OUT/scene.bwx first)")
    rays.add_argument("rays", metavar="RAYS.npy", help="an array (N, 6) of origins and directions, or (N, 3) of points")
    _add_job(rays)
    rays.add_argument("--question", choices=list(QUESTIONS), default="cast_rays", help="what to ask [cast_rays]")
    rays.add_argument("--fields", metavar="A,B", help="which fields to keep [all]")
    rays.add_argument("--block", type=_count, default=1_000_000, metavar="N", help="rays of a block [1000000]")
    pictures = _command(
        commands, "render", "make a picture, by tiles if wished, or an animation", RENDER_EXAMPLES + "\n" + EPILOG
    )
    pictures.add_argument("scene", metavar="SCENE", help="a .bwx file, or a model (it is saved as OUT/scene.bwx first)")
    _add_job(pictures)
    _add_pictures(pictures)
    status = _command(commands, "status", "tell how far a job is", STATUS_EXAMPLES)
    status.add_argument("out", metavar="OUT", help="the job's folder")
    status.add_argument("--check", action="store_true", help="read all results and compare their hashes")
    status.add_argument("--json", action="store_true", help="one JSON object on stdout")
    return whole


def _command(commands: Any, name: str, about: str, epilog: str) -> argparse.ArgumentParser:
    description = about[0].upper() + about[1:] + "."
    command: argparse.ArgumentParser = commands.add_parser(
        name, help=about, description=description, epilog=epilog, formatter_class=_Plain
    )
    return command


def _add_job(command: argparse.ArgumentParser) -> None:
    command.add_argument("--out", required=True, metavar="OUT", help="the job's folder, shared by all machines")
    where = command.add_argument_group("where it runs")
    where.add_argument("--scheduler", metavar="tcp://HOST:PORT", help="a Dask scheduler")
    where.add_argument(
        "--workers",
        type=_count_or_none,
        metavar="N",
        help="processes to start here, without --scheduler; 0: none, in this process [1]",
    )
    where.add_argument("--threads", type=_count, metavar="N", help="of each task [1; with --workers 0 all]")
    where.add_argument(
        "--patience", type=_seconds, default=300.0, metavar="S", help="how long to wait for a scheduler, or a worker [300]"
    )
    command.add_argument(
        "--retries", type=_count_or_none, default=3, metavar="N", help="how often a block that fails is tried again [3]"
    )
    command.add_argument("--resume", action="store_true", help="go on with a job that is there; an error if there is none")
    command.add_argument("--json", action="store_true", help="one JSON object on stdout")


def _add_pictures(command: argparse.ArgumentParser) -> None:
    pictures = command.add_argument_group("pictures")
    pictures.add_argument("--size", type=_size, default=(960, 540), metavar="WxH", help="in pixels [960x540]")
    pictures.add_argument(
        "--tile",
        type=_size,
        metavar="N or WxH",
        help="cut each picture into tiles of this size, one task for each [a task is a picture]",
    )
    pictures.add_argument("--cameras", metavar="FILE.json", help="a camera for each frame")
    pictures.add_argument("--frames", type=_frames, metavar="A-BxN,C", help="which of them, as in 0-99x2,120 [all]")
    pictures.add_argument("--eye", type=_place, metavar="X,Y,Z", help="where the camera stands [one that sees the scene well]")
    pictures.add_argument("--target", type=_place, metavar="X,Y,Z", help="where it looks")
    pictures.add_argument("--up", type=_place, metavar="X,Y,Z", help="what is up")
    pictures.add_argument("--fov", type=float, dest="fov_deg", metavar="DEG", help="vertical field of view")
    pictures.add_argument(
        "--shading", choices=list(SHADINGS), default="whitted", metavar="NAME", help=f"one of {', '.join(SHADINGS)} [whitted]"
    )
    pictures.add_argument("--samples", type=_count, metavar="N", help="per pixel [as the shading needs]")
    pictures.add_argument("--seed", type=_count_or_none, default=0, metavar="N", help="of the noise [0]")
    pictures.add_argument("--max-depth", type=_count, metavar="N", help="most bounces of light [8]")
    pictures.add_argument("--sky", type=float, metavar="X", help="strength of sun and sky")
    pictures.add_argument("--exposure", type=float, metavar="STOPS", help="0 is neutral")
    pictures.add_argument("--top", type=float, metavar="X", help="the bright end of a scale")


class _Plain(argparse.RawDescriptionHelpFormatter):
    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=28, width=110)


def _count(text: str) -> int:
    if not (text.replace("_", "").isdecimal() and int(text) >= 1):
        raise argparse.ArgumentTypeError(f"must be a whole number, at least 1, not {text!r}")
    return int(text)


def _seconds(text: str) -> float:
    with contextlib.suppress(ValueError):
        if 0 <= float(text) < float("inf"):
            return float(text)
    raise argparse.ArgumentTypeError(f"must be a number of seconds, not {text!r}")


def _count_or_none(text: str) -> int:
    if not text.replace("_", "").isdecimal():
        raise argparse.ArgumentTypeError(f"must be a whole number, 0 or more, not {text!r}")
    return int(text)


def _size(text: str) -> tuple[int, int]:
    sides = [int(side) for side in text.lower().split("x")]
    return (sides[0], sides[-1]) if len(sides) < 3 else _refuse(text)


def _place(text: str) -> list[float]:
    place = [float(number) for number in text.split(",")]
    return place if len(place) == 3 else _refuse(text)


def _frames(text: str) -> list[int]:
    """``0-99x2,120`` as numbers."""
    frames: list[int] = []
    for part in text.split(","):
        ends, _, step = part.partition("x")
        first, _, last = ends.partition("-")
        frames += range(int(first), int(last or first) + 1, int(step or 1))
    return frames


def _refuse(text: str) -> NoReturn:
    raise argparse.ArgumentTypeError(f"{text!r} has the wrong number of numbers")
