"""What a cluster costs, and that it loses nothing: one process beside a Dask cluster of this machine, and a run whose parts are killed.

    python bench/python/cluster.py                       # 100 million rays; 3.3 GB of results at a time in --folder
    python bench/python/cluster.py --rays 4e6 --chaos    # and a run in which a worker and the scheduler are killed
    python bench/python/cluster.py --what tiles --chaos  # 64 tiles of a path-traced frame; --what frames: 24 frames

Needs ``pip install ./python 'boxwood[dask]'``. Rays are made in the tasks, of a seed for each block. All ways answer the same rays in the
same blocks. A line tells seconds, rays or pixels a second, processor seconds of all processes, and both against the first line.
"""

import argparse
import hashlib
import logging
import os
import shutil
import sys
import tempfile
import time

import dask.array as da
import distributed  # noqa: F401  Sets the levels of its logs, which `main` changes.
import numpy as np
import psutil

import boxwood
import boxwood.dask as bd
from boxwood.cluster.questions import ask

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "../../python/tests"))
from loopback import Loopback, kill


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--what", choices=["rays", "tiles", "frames"], default="rays")
    parser.add_argument("--scene", default="builtin:bush")
    parser.add_argument("--rays", type=float, default=100e6)
    parser.add_argument("--block", type=float, default=1e6)
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes of one thread each")
    parser.add_argument("--folder", help="for results, which are removed [a temporary one]")
    parser.add_argument("--chaos", action="store_true", help="kill a worker, add one, kill the scheduler, go on")
    options = parser.parse_args()
    # A scheduler that is killed is what we want.
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        (Rays if options.what == "rays" else Pictures)(options, folder).run()


class Bench:
    """The same work in several ways. `told` says what it is, `count` how many `unit` it has."""

    def __init__(self, options, folder):
        self.options, self.folder = options, folder
        self.scene = boxwood.Scene.load(options.scene)
        self.ref = bd.SceneRef.save(self.scene, os.path.join(folder, "scene.bwx"))
        self.first = self.first_work = None
        self.others = []

    def run(self):
        """Prints a line for each way."""
        print(f"{boxwood.__version__=} {os.cpu_count()} processors, {self.told} of {self.options.scene}", flush=True)
        wanted = self.line("one process, nothing written", self.plain)
        alone = self.line("one process, a job (--workers 0)", lambda: self.job("alone"))
        assert alone == wanted, "the job's bytes differ"
        with Loopback(self.options.workers) as cluster, cluster.client() as client:
            client.wait_for_workers(self.options.workers)
            client.run(warm, self.ref)
            self.others = [psutil.Process(process.pid) for process in (*cluster.workers, cluster.scheduler)]
            found = self.line(f"{self.options.workers} worker processes, a job", lambda: self.job("cluster", client=client))
        assert found == wanted, "the cluster's bytes differ"
        self.others = []
        if self.options.chaos:
            assert self.line("the same, killed and resumed", self.chaos, whole=False) == wanted, "bytes differ after the kills"
        print(f"all the same bytes: sha256 {wanted}")

    def line(self, name, way, whole=True):
        """Times one way; returns the hash of its answers. What killed processes worked is not known, so it is not told."""
        self.aside = (0.0, 0.0)
        start, work = time.perf_counter(), self.work()
        answers = way()
        seconds, work = time.perf_counter() - start - self.aside[0], self.work() - work - self.aside[1]
        self.first, self.first_work = self.first or seconds, self.first_work or work
        rate, slower, more = self.count / seconds / 1e6, seconds / self.first, work / self.first_work
        told = f"   processors {work:8.1f} s {more:6.2f}" if whole else ""
        print(f"{name:33} {seconds:8.1f} s {rate:6.2f} M{self.unit}/s {slower:6.2f}{told}", flush=True)
        return answers() if callable(answers) else answers

    def work(self):
        """Processor seconds of all processes so far."""
        times = [os.times(), *(process.cpu_times() for process in self.others)]
        return sum(one.user + one.system for one in times)

    def plain(self):
        """All in this process, on all threads; the hash, which does not count."""
        sha = hashlib.sha256()
        for answer in self.answers():
            start, work = time.perf_counter(), time.thread_time()
            update(sha, answer)
            self.aside = (self.aside[0] + time.perf_counter() - start, self.aside[1] + time.thread_time() - work)
        return sha.hexdigest()

    def job(self, name, **where):
        """A job in a folder; gives a function that hashes its results and removes them."""
        out = os.path.join(self.folder, name)
        self.begin(out, **where)
        return lambda: self.hashed(out)

    def hashed(self, out):
        """The hash of a job's results; they are removed."""
        sha = hashlib.sha256()
        for answer in self.results(out):
            update(sha, answer)
        shutil.rmtree(out)
        return sha.hexdigest()

    def chaos(self):
        """A worker is killed and one added after a fifth of the blocks, the scheduler killed at half; then a second cluster goes on."""
        out = os.path.join(self.folder, "chaos")
        with Loopback(3) as cluster, cluster.client() as client:

            def happen(progress):
                if progress.done == progress.total // 5:
                    kill(cluster.workers.pop())
                    cluster.add_worker()
                if progress.done == progress.total // 2:
                    kill(cluster.scheduler)

            try:
                self.begin(out, client=client, progress=happen)
            except bd.ClusterLost as lost:
                print(f"  {lost}")
        with Loopback(3) as cluster, cluster.client() as client:
            report = self.begin(out, client=client)
        print(f"  {report.kept} of {report.done} blocks were there")
        return lambda: self.hashed(out)


class Rays(Bench):
    """Closest hits of random rays."""

    unit = "rays"

    def __init__(self, options, folder):
        super().__init__(options, folder)
        self.count, block = int(options.rays), int(options.block)
        self.told = f"{self.count:,} rays in blocks of {block:,}"
        self.low, self.high = self.scene.bounds.astype(np.float32)
        sizes = [min(block, self.count - start) for start in range(0, self.count, block)]
        self.rays = da.map_blocks(
            make_rays,
            self.low,
            self.high,
            chunks=(tuple(sizes), 6),
            dtype=np.float32,
            meta=np.empty((0, 6), np.float32),
            name=f"rays-{self.count}-{block}",
        )

    def answers(self):
        """Block after block."""
        scene = boxwood.cluster.open(self.ref)
        for index, size in enumerate(self.rays.chunks[0]):
            yield ask(scene, "cast_rays", rays_of(index, size, self.low, self.high), 0, {})

    def begin(self, out, **where):
        """Begins or goes on."""
        return bd.run_rays(self.ref, self.rays, out, **where)

    def results(self, out):
        """Block after block."""
        folder = boxwood.cluster.JobFolder(out)
        for _, receipt in sorted(folder.finished().items()):
            with np.load(folder.file(receipt)) as block:
                yield {name: block[name] for name in block.files}


class Pictures(Bench):
    """A frame in 8 by 8 tiles, or 24 frames around the scene: path-traced."""

    unit = "pixels"
    looks = {"shading": "path", "samples": 16}

    def __init__(self, options, folder):
        super().__init__(options, folder)
        frames, self.size, tile = (1, (1920, 1080), (240, 135)) if options.what == "tiles" else (24, (480, 270), None)
        self.asked = {"tile": tile, **self.looks}
        self.told = f"{frames} x {self.size[0]} x {self.size[1]} pixels{' in 64 tiles' if tile else ''}"
        self.count = frames * self.size[0] * self.size[1]
        found = self.scene.camera(self.size)
        away = found["eye"] - found["target"]
        up = found["up"] / np.linalg.norm(found["up"])
        self.cameras = [{**found, "eye": found["target"] + turned(away, up, number / frames)} for number in range(frames)]

    def answers(self):
        """Picture after picture."""
        scene = boxwood.cluster.open(self.ref)
        for camera in self.cameras:
            yield {"png": np.frombuffer(scene.render(self.size, **camera, **self.looks).png(), np.uint8)}

    def begin(self, out, **where):
        """Begins or goes on."""
        return bd.render(self.ref, out, self.size, cameras=self.cameras, **self.asked, **where)

    def results(self, out):
        """Picture after picture."""
        for number in range(len(self.cameras)):
            yield {"png": np.fromfile(os.path.join(out, f"frames/{number:04}.png"), np.uint8)}


def turned(arm, axis, share):
    """`arm` turned about `axis` by a share of a whole turn (Rodrigues' formula)."""
    angle = 2 * np.pi * share
    along = axis * (axis @ arm)
    return along + np.cos(angle) * (arm - along) + np.sin(angle) * np.cross(axis, arm)


def rays_of(index, size, low, high):
    """Rays between random places in and around the scene."""
    random = np.random.default_rng([2026, index])
    ends = random.random((size, 2, 3), dtype=np.float32) * (high - low) * 2 + (low - (high - low) / 2)
    ends[:, 1] -= ends[:, 0]
    return ends.reshape(size, 6)


def make_rays(low, high, block_info=None):
    """The same for ``map_blocks``."""
    where = block_info[None]
    return rays_of(where["chunk-location"][0], where["chunk-shape"][0], low, high)


def update(sha, answer):
    """Adds an answer's bytes."""
    for name in sorted(answer):
        sha.update(np.ascontiguousarray(answer[name]))


def warm(ref):
    """Opens the scene, so that the first blocks do not wait for it."""
    boxwood.cluster.open(ref)


if __name__ == "__main__":
    main()
