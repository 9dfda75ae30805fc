"""Work that is too large for one machine, or for one run: scenes by reference, and jobs in folders.

:mod:`boxwood.dask` is what to call from Python, ``python -m boxwood.cluster`` from a shell. This package itself needs no Dask: without a
cluster its jobs run in this process.
"""

from .errors import BlocksFailed, ClusterLost, JobRefused, SceneMismatch
from .folder import JobFolder
from .pool import Cluster, InProcess
from .progress import Progress
from .reference import SceneRef, open
from .run import Report, run

__all__ = [
    "BlocksFailed",
    "Cluster",
    "ClusterLost",
    "InProcess",
    "JobFolder",
    "JobRefused",
    "Progress",
    "Report",
    "SceneMismatch",
    "SceneRef",
    "open",
    "run",
]
