"""The questions of a scene that rows of an array ask, one line each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Mapping

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ..scene import Scene

Field = tuple[Any, tuple[int, ...]]

# A field of an answer: type, and what stands behind the rows' own axes.
_ID: Field = (np.uint32, ())
_FLOAT: Field = (np.float32, ())
_PLACE: dict[str, Field] = {
    "geometry_ids": _ID,
    "primitive_ids": _ID,
    "primitive_uvs": (np.float32, (2,)),
    "primitive_normals": (np.float32, (3,)),
}
# What may be said about rays, a number each.
_LIMITS = ("tnear", "tfar")


@dataclass(frozen=True)
class Question:
    """A method of :class:`boxwood.Scene` whose answers have as many rows as what is asked."""

    columns: int
    """6 for rays, 3 for points."""
    fields: dict[str, Field]
    """Name to (type, shape behind the rows' axes), in the order in which they are told."""
    single: bool = False
    """True if the method returns the one field as an array rather than a dict."""
    arguments: tuple[str, ...] = ()
    """What else may be said."""


QUESTIONS = {
    "cast_rays": Question(6, {"t_hit": _FLOAT, **_PLACE, "hit": (np.bool_, ())}, arguments=_LIMITS),
    "test_occlusions": Question(6, {"occluded": (np.bool_, ())}, True, _LIMITS),
    "count_intersections": Question(6, {"count": (np.int64, ())}, True, _LIMITS),
    # Places are float64 where the scene has an origin and float32 elsewhere: float64 holds both.
    "compute_closest_points": Question(3, {"points": (np.float64, (3,)), "distances": _FLOAT, **_PLACE}),
    "compute_distance": Question(3, {"distances": _FLOAT}, True),
    "compute_signed_distance": Question(3, {"distances": _FLOAT}, True),
    "compute_occupancy": Question(3, {"inside": _FLOAT}, True),
}


#: What users of :func:`boxwood.dask.run_rays` try on the lazy questions.
_REMEDY = {"fields": "; of a lazy answer use the fields you want, and run_rays(..., fields=...) writes but some"}


def question_of(name: str) -> Question:
    """The line of the table."""
    if name not in QUESTIONS:
        raise ValueError(f"{name!r} is none of the questions {', '.join(QUESTIONS)}")
    return QUESTIONS[name]


def ask(scene: Scene, name: str, rows: NDArray[Any], threads: int, arguments: Mapping[str, float]) -> dict[str, NDArray[Any]]:
    """The answer as a dict of arrays with the types of the table."""
    question = question_of(name)
    answer = getattr(scene, name)(rows, threads=threads, **arguments)
    if question.single:
        answer = {next(iter(question.fields)): answer}
    return {field: np.asarray(answer[field], kind) for field, (kind, _) in question.fields.items()}


def check_rows(name: str, shape: tuple[int, ...], dtype: Any) -> None:
    """Raises unless an array of this shape and type can be asked about."""
    columns = question_of(name).columns
    what = "rays" if columns == 6 else "points"
    if np.dtype(dtype).kind not in "fiu":
        raise TypeError(f"{what} must be numbers, not {dtype}")
    if not shape or shape[-1] != columns:
        raise ValueError(f"{what} must have the shape (..., {columns}), not {tuple(shape)}{_other_question(name, shape)}")


def _other_question(name: str, shape: tuple[int, ...]) -> str:
    """What to say to points for a question about rays, or rays for one about points."""
    fitting = [other for other, question in QUESTIONS.items() if shape and question.columns == shape[-1]]
    return f"; the questions about such are {', '.join(fitting)}" if fitting else ""


def numbers_of(name: str, arguments: Mapping[str, Any]) -> dict[str, float]:
    """What else is said, as numbers; raises on what the question does not take."""
    for argument in arguments:
        if argument not in question_of(name).arguments:
            known = question_of(name).arguments
            takes = f"beside threads it takes {' and '.join(known)}" if known else "it takes nothing but threads"
            raise TypeError(f"{name} takes no {argument!r}: {takes}{_REMEDY.get(argument, '')}")
    return {argument: float(value) for argument, value in arguments.items()}
