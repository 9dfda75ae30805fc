"""Which of some radio masts in the hills see each other."""

import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from terrain import hills, relief

from boxwood import jobs

CELL, MAST = 20.0, 12.0
terrain = jobs.Terrain(hills(), CELL)
cells = np.random.default_rng(8).integers(12, 244, (14, 2))
tops = terrain.points[cells[:, 0], cells[:, 1]] + [0, 0, MAST]
sees = jobs.line_of_sight(terrain.scene, tops[:, None], tops[None])

figure, axis = plt.subplots(figsize=(6.4, 5.6), layout="constrained")
rows, columns = terrain.shape
extent = (0, columns * CELL / 1000, rows * CELL / 1000, 0)
axis.imshow(relief(terrain.points[..., 2], CELL), cmap="gray", extent=extent, vmin=-0.3, vmax=1.1)
x, y = (cells[:, 1] + 0.5) * CELL / 1000, (cells[:, 0] + 0.5) * CELL / 1000
for i, j in np.argwhere(np.triu(sees, 1)):
    axis.plot(x[[i, j]], y[[i, j]], color="gold", linewidth=1.2)
axis.plot(x, y, "o", color="crimson", markersize=6)
pairs = len(tops) * (len(tops) - 1) // 2
axis.set(title=f"{np.triu(sees, 1).sum()} of {pairs} pairs of masts see each other", xlabel="km east", ylabel="km south")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "line_of_sight.png", dpi=100)
