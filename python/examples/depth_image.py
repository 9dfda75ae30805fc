"""A picture of a scene, and its depth."""

import sys
import warnings

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import boxwood
from boxwood import jobs

warnings.simplefilter("ignore")
scene = boxwood.Scene.load(sys.argv[2] if len(sys.argv) > 2 else "builtin:bush")
size = (480, 360)
picture = scene.render(size)
depth = jobs.depth_image(scene, size, **picture.camera)

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
left.imshow(picture)
image = right.imshow(np.where(np.isfinite(depth), depth, np.nan), cmap="magma_r")
right.set_facecolor("0.9")
figure.colorbar(image, label="depth in units of the scene")
for axis, title in ((left, "Scene.render"), (right, "jobs.depth_image")):
    axis.set(title=title, xticks=[], yticks=[])
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "depth_image.png", dpi=100)
