"""A spinning lidar in a scene: the points from above, and the panorama of its ranges."""

import sys
import warnings

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import boxwood
from boxwood import jobs

warnings.simplefilter("ignore")
scene = boxwood.Scene.load(sys.argv[2] if len(sys.argv) > 2 else "builtin:cornell")
low, high = scene.bounds
# These scenes have y up; the sensor's z goes there, its x to the world's x.
pose = np.eye(4)
pose[:3, :3] = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]).T
pose[:3, 3] = low + (high - low) * [0.5, 0.65, 0.45]
pattern = jobs.Spinning(beams=64, lowest_deg=-50, highest_deg=30, azimuths=1440)
scan = jobs.lidar_scan(scene, pose, pattern, range_noise=0.0005 * float(np.linalg.norm(high - low)), seed=1)

figure, (above, panorama) = plt.subplots(2, 1, figsize=(7.2, 7.6), height_ratios=[3, 1.2], layout="constrained")
points = scan["points"]
above.scatter(points[:, 0], points[:, 2], c=points[:, 1], s=0.4, cmap="viridis", linewidths=0)
above.plot(*pose[[0, 2], 3], "^", color="crimson", markersize=8)
above.set(aspect="equal", title=f"{len(points):,} points of one turn, seen from above", xlabel="x", ylabel="z")
above.invert_yaxis()
ranges = np.where(np.isfinite(scan["ranges"]), scan["ranges"], np.nan)
# Azimuth grows to the left.
image = panorama.imshow(ranges.T[::-1, ::-1], cmap="magma_r", extent=(360, 0, -50, 30), aspect="auto")
panorama.set(title="ranges", xlabel="azimuth in degrees", ylabel="elevation")
figure.colorbar(image)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "lidar.png", dpi=100)
