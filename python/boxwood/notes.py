"""What a scene's file says beside what Boxwood itself needs, so that an opened scene can do what a built one can."""

from __future__ import annotations

from typing import Any, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ._native import NativeLooks, NativeScene

#: The number of vertices and the triangles (F, 3) of a mesh.
Faces = tuple[int, NDArray[np.uint32]]


def notes_of(
    quality: str, origin: NDArray[np.float64], meshes: Sequence[tuple[NDArray[Any], NDArray[np.uint32]]], looks: Mapping[int, NativeLooks]
) -> list[tuple[str, bytes]]:
    """For a scene's file."""
    counts = np.array([len(vertices) for vertices, _ in meshes], "<u8")
    indices = [triangles.astype("<u4").tobytes() for _, triangles in meshes]
    return [
        ("origin", origin.astype("<f8").tobytes()),
        # What is no text the native part refuses.
        ("quality", str(quality).encode()),
        ("vertices", counts.tobytes()),
        ("indices", b"".join(indices)),
        *((f"looks.{number}", look.to_bytes()) for number, look in sorted(looks.items())),
    ]


def quality_in(native: NativeScene) -> str:
    """How much work the build was worth."""
    return (native.note("quality") or b"default").decode("ascii", "replace")


def origin_in(native: NativeScene) -> NDArray[np.float64]:
    """What was subtracted from all coordinates."""
    origin = np.frombuffer(native.note("origin") or bytes(24), np.uint8)
    if origin.size != 24 or not np.isfinite(origin.view("<f8")).all():
        raise ValueError("the file's note 'origin' is not three numbers: save the scene again")
    return origin.view("<f8").astype(np.float64)


def faces_in(native: NativeScene) -> list[Faces]:
    """Of each mesh."""
    counts, indices = native.note("vertices"), native.note("indices")
    if counts is None or indices is None:
        raise ValueError("this file does not say which vertices triangles have: interpolate by primitive_ids and primitive_uvs")
    lengths = native.mesh_lengths()
    if len(counts) != 8 * len(lengths) or len(indices) != 12 * sum(lengths):
        raise ValueError("the file's notes 'vertices' and 'indices' are not those of its triangles: save the scene again")
    triangles = np.frombuffer(indices, "<u4").reshape(-1, 3)
    parts = np.split(triangles, np.cumsum(lengths)[:-1]) if lengths else []
    numbers: list[int] = np.frombuffer(counts, "<u8").tolist()
    if any(part.size and part.max() >= count for count, part in zip(numbers, parts)):
        raise ValueError("the file's note 'indices' has vertices that are not there: save the scene again")
    return list(zip(numbers, parts))


def looks_in(native: NativeScene) -> dict[int, NativeLooks]:
    """What the triangles of each mesh look like, where a file said so."""
    notes = ((number, native.note(f"looks.{number}")) for number in range(len(native.mesh_lengths())))
    return {number: NativeLooks.from_bytes(note) for number, note in notes if note is not None}


def meshes_in(native: NativeScene) -> list[tuple[NDArray[np.float32], NDArray[np.uint32]]]:
    """Positions (V, 3) of each mesh, the origin subtracted, zero where no triangle has the vertex; and triangles (F, 3)."""
    if native.note("vertices") is None or native.note("indices") is None:
        # Each triangle has vertices of its own, then.
        corners = [native.corners(number) for number in range(len(native.mesh_lengths()))]
        return [(each, np.arange(len(each), dtype=np.uint32).reshape(-1, 3)) for each in corners]
    meshes = []
    for number, (count, triangles) in enumerate(faces_in(native)):
        if count > triangles.size and len(native.note(f"looks.{number}") or b"") < count:
            # Vertices that no triangle has, and nothing is told of: a few bytes could ask for all memory.
            kept, indices = np.unique(triangles, return_inverse=True)
            count, triangles = len(kept), indices.reshape(-1, 3).astype(np.uint32)
        positions = np.zeros((count, 3), np.float32)
        positions[triangles.reshape(-1)] = native.corners(number)
        meshes.append((positions, triangles.astype(np.uint32)))
    return meshes
