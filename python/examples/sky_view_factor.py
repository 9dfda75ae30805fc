"""How much of the sky each place in the hills sees."""

import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from terrain import hills

from boxwood import jobs

CELL = 20.0
elevation = hills(height=1200)
share = jobs.sky_view_factor(elevation, cell_size=CELL, directions=64, weight="solid_angle")

figure, axis = plt.subplots(figsize=(6.4, 5.4), layout="constrained")
extent = (0, elevation.shape[1] * CELL / 1000, elevation.shape[0] * CELL / 1000, 0)
image = axis.imshow(share, cmap="gray", extent=extent, vmin=share.min(), vmax=1)
axis.set(title="Sky view factor (share of the hemisphere)", xlabel="km east", ylabel="km south")
figure.colorbar(image, shrink=0.8)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "sky_view_factor.png", dpi=100)
