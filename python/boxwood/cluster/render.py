"""Work whose blocks are pictures, or tiles of pictures that are put together afterwards."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Iterable

import numpy as np
from numpy.typing import NDArray

from .._native import encode_png
from ..picture import Picture
from ..studio import SHADINGS
from .files import Bytes, packed
from .folder import path_in
from .reference import SceneRef, open

#: What a camera tells, as :meth:`boxwood.Scene.render` takes it.
CAMERA = ("eye", "target", "up", "fov_deg")
#: And what else it takes.
LOOKS = ("shading", "samples", "seed", "max_depth", "lights", "sky", "floor", "exposure", "top", "log")


@dataclass(frozen=True)
class RenderWork:
    """Pictures by :meth:`boxwood.Scene.render`, one for each of `frames`.

    Without `tile` a block is a picture. With it the tiles of all pictures come first, row by row, and then the pictures.
    """

    scene: SceneRef
    size: tuple[int, int]
    """Width and height."""
    frames: tuple[int, ...]
    """Numbers of the pictures, which name their files."""
    cameras: tuple[dict[str, Any], ...]
    """A dict for each picture; what it does not say is chosen by the renderer."""
    tile: tuple[int, int] | None = None
    """Most columns and rows of a tile."""
    looks: dict[str, Any] = field(default_factory=dict)
    threads: int = 1

    kind = "render"
    unit = "pixels"

    def __post_init__(self) -> None:
        _check_size("size", self.size)
        for camera in self.cameras:
            _check_names("a camera", camera, CAMERA)
        _check_names("render", self.looks, LOOKS)
        shading = self.looks.get("shading", "whitted")
        if shading not in SHADINGS:
            raise ValueError(f"{shading!r} is none of the shadings {', '.join(SHADINGS)}")
        if self.tile is not None:
            _check_size("tile", self.tile)
            if has_scale(shading):
                raise ValueError(f"{shading!r} colours by a scale over the whole picture: leave out the tiles")

    @cached_property
    def windows(self) -> list[tuple[int, int, int, int]]:
        """Left, top, width and height of each tile of a picture."""
        if self.tile is None:
            return []
        (width, height), (columns, rows) = self.size, self.tile
        corners = [(x, y) for y in range(0, height, rows) for x in range(0, width, columns)]
        return [(x, y, min(columns, width - x), min(rows, height - y)) for x, y in corners]

    @property
    def _tiles(self) -> int:
        return len(self.frames) * len(self.windows)

    @property
    def blocks(self) -> int:
        """How many there are."""
        return self._tiles + len(self.frames)

    @property
    def stages(self) -> list[range]:
        """Tiles, then pictures."""
        return [range(self._tiles), range(self._tiles, self.blocks)]

    def needs(self, index: int) -> range:
        """The tiles of a picture."""
        if index < self._tiles:
            return range(0)
        first = (index - self._tiles) * len(self.windows)
        return range(first, first + len(self.windows))

    def file_of(self, index: int) -> str:
        """Where a tile or picture goes, within the job's folder."""
        return f"blocks/{index:06}.npz" if index < self._tiles else f"frames/{self.frames[index - self._tiles]:04}.png"

    def identity(self) -> dict[str, Any]:
        """What must be the same when a job is taken up again."""
        return {
            "kind": self.kind,
            "scene": self.scene.content_hash,
            "size": list(self.size),
            "tile": None if self.tile is None else list(self.tile),
            "frames": list(self.frames),
            "cameras": list(self.cameras),
            "looks": self.looks,
        }

    def input_digest(self, index: int) -> str | None:
        """Nothing goes in but what the identity tells."""
        return None

    def compute(self, folder: str, index: int, rows: NDArray[Any] | None) -> tuple[Bytes, dict[str, int]]:
        """The bytes of a block's file, and what to count of it."""
        if index < self._tiles:
            frame, number = divmod(index, len(self.windows))
            picture = self._rendered(frame, crop=self.windows[number])
            height, width = picture.shape
            return packed({"pixels": picture.pixels}), {"pixels": width * height}
        width, height = self.size
        if self.tile is None:
            return self._rendered(index).png(), {"pixels": width * height, "pictures": 1}
        return self._assembled(folder, index), {"pictures": 1}

    def _rendered(self, frame: int, crop: tuple[int, int, int, int] | None = None) -> Picture:
        return open(self.scene).render(self.size, **self.cameras[frame], **self.looks, crop=crop, threads=self.threads)

    def _assembled(self, folder: str, index: int) -> bytes:
        width, height = self.size
        pixels = np.zeros((height, width, 3), np.uint8)
        for block, (x, y, columns, rows) in zip(self.needs(index), self.windows):
            with np.load(path_in(folder, self.file_of(block))) as tile:
                pixels[y : y + rows, x : x + columns] = tile["pixels"]
        png: bytes = encode_png(pixels, self.looks.get("shading", "whitted"))
        return png


def has_scale(shading: str) -> bool:
    """True if a shading's colours depend on the whole picture, which has a legend."""
    return shading == "depth" or shading.startswith("heat")


def _check_size(what: str, size: tuple[int, int]) -> None:
    if len(size) != 2 or not all(isinstance(side, int) and 1 <= side <= 65_535 for side in size):
        raise ValueError(f"{what} must be two whole numbers from 1 to 65,535, not {size}")


def _check_names(what: str, given: Iterable[str], known: tuple[str, ...]) -> None:
    for name in given:
        if name not in known:
            raise TypeError(f"{what} takes no {name!r}; it takes {', '.join(known)}")
