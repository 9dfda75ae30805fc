"""Which scene, told in a few bytes: where its file is and what must be in it."""

# mypy: disable-error-code="import-untyped"

from __future__ import annotations

import collections
import contextlib
import getpass
import os
import tempfile
import threading
from dataclasses import dataclass
from typing import Iterator

from ..scene import Scene
from .errors import SceneMismatch
from .files import TEMPORARY

#: Scenes that a process keeps open; they are mapped, so what they cost is mostly the machine's page cache.
KEPT = 4

_open: collections.OrderedDict[str, Scene] = collections.OrderedDict()
_lock = threading.Lock()


@dataclass(frozen=True)
class SceneRef:
    """A scene's file and its content hash. Tasks carry this; the scene itself is opened where it is needed.

    Parameters
    ----------
    path : str
        A ``.bwx`` file that every worker sees under the same name, or a URL that `fsspec <https://filesystem-spec.readthedocs.io>`_
        reads (``s3://...``): each machine copies it once, to ``$BOXWOOD_CACHE`` or the folder for temporary files.
    content_hash : str
        What :meth:`boxwood.Scene.save` returned. A file with another content is refused.
    """

    path: str
    content_hash: str

    @classmethod
    def of(cls, path: str | os.PathLike[str]) -> SceneRef:
        """A reference to the file at `path`, which must be there for this process as well."""
        path = os.fspath(path)
        if is_url(path):
            raise ValueError(
                f"{path}: its content hash is not known: say SceneRef(url, content_hash), with what Scene.save returned"
            )
        path = os.path.abspath(path)
        return cls(path, Scene.open(path).content_hash)

    @classmethod
    def save(cls, scene: Scene, path: str | os.PathLike[str]) -> SceneRef:
        """Saves `scene` to `path` and refers to it."""
        path = os.path.abspath(os.fspath(path))
        return cls(path, scene.save(path))


def open(ref: SceneRef) -> Scene:  # noqa: A001, as gzip.open and others do
    """The scene of a :class:`SceneRef`, opened once for each process and content.

    Raises
    ------
    SceneMismatch
        If the file holds another scene.
    OSError, ValueError
        If there is none.
    """
    with _lock:
        scene = _open.get(ref.content_hash)
        if scene is None:
            scene = _verified(ref)
            _open[ref.content_hash] = scene
            while len(_open) > KEPT:
                _open.popitem(last=False)
        _open.move_to_end(ref.content_hash)
        return scene


def is_url(path: str) -> bool:
    """True for ``s3://...`` and its like; ``file://`` too, which fsspec reads."""
    return "://" in path


def _verified(ref: SceneRef) -> Scene:
    path = local_copy(ref) if is_url(ref.path) else ref.path
    scene = Scene.open(path)
    if scene.content_hash != ref.content_hash:
        raise SceneMismatch(
            f"{ref.path}: the scene there has the content hash {scene.content_hash}, not {ref.content_hash}: "
            "save it again, or make a new reference"
        )
    return scene


def local_copy(ref: SceneRef) -> str:
    """The file of a URL on this machine, fetched by whichever process comes first."""
    try:
        import fsspec
    except ImportError:
        raise ImportError(f"{ref.path} is a URL, which needs fsspec: pip install 'boxwood[dask]'") from None
    path = os.path.join(_cache(), f"{ref.content_hash}.bwx")
    with only_one(path + ".lock"):
        # A copy that is damaged is fetched again.
        if _hash_of(path) != ref.content_hash:
            fs, remote = fsspec.core.url_to_fs(ref.path)
            fs.get_file(remote, path + TEMPORARY)
            found = _hash_of(path + TEMPORARY)
            if found != ref.content_hash:
                os.unlink(path + TEMPORARY)
                there = f"the scene there has the content hash {found}" if found else "what is there is no scene"
                raise SceneMismatch(f"{ref.path}: {there}, not {ref.content_hash}")
            os.replace(path + TEMPORARY, path)
    return path


def _cache() -> str:
    """The folder of copies; one for each user, whom it must belong to."""
    chosen = os.environ.get("BOXWOOD_CACHE")
    folder = chosen or os.path.join(tempfile.gettempdir(), f"boxwood-{getpass.getuser()}")
    os.makedirs(folder, mode=0o700, exist_ok=True)
    if not chosen and hasattr(os, "getuid") and os.stat(folder).st_uid != os.getuid():
        raise PermissionError(f"{folder} belongs to somebody else: set BOXWOOD_CACHE to a folder of yours")
    return folder


def _hash_of(path: str) -> str | None:
    """The content hash of a scene's file; None if there is none."""
    try:
        return Scene.open(path).content_hash
    except (OSError, ValueError):
        return None


@contextlib.contextmanager
def only_one(path: str, wait: bool = True) -> Iterator[None]:
    """Holds a lock between processes by the file `path`; a process that dies lets it go.

    Raises
    ------
    BlockingIOError
        If another one holds it, unless `wait`.
    """
    try:
        import fcntl
    except ImportError:  # Windows: renaming alone keeps files whole.
        yield
        return
    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        yield
    finally:
        os.close(handle)
