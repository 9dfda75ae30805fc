"""What a hiker sees from a hill top."""

import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from terrain import hills, relief

from boxwood import jobs

CELL = 20.0
elevation = hills()
observer = np.unravel_index(np.argmax(elevation[60:120, 60:200]), (60, 140))
observer = (int(observer[0]) + 60, int(observer[1]) + 60)
seen = jobs.viewshed(elevation, observer, cell_size=CELL, observer_height=1.7, earth_radius=6_371_000, refraction=0.13)

figure, axis = plt.subplots(figsize=(6.4, 5.6), layout="constrained")
east, south = elevation.shape[1] * CELL / 1000, elevation.shape[0] * CELL / 1000
extent = (0, east, south, 0)
axis.imshow(relief(elevation, CELL), cmap="gray", extent=extent, vmin=0, vmax=1.1)
axis.imshow(np.where(seen, 1.0, np.nan), cmap="autumn_r", alpha=0.45, extent=extent, vmin=0, vmax=1)
axis.plot((observer[1] + 0.5) * CELL / 1000, (observer[0] + 0.5) * CELL / 1000, "^", color="navy", markersize=9, label="observer")
axis.set(title=f"Seen from {elevation[observer]:.0f} m: {seen.mean():.0%} of the land", xlabel="km east", ylabel="km south")
axis.legend(loc="lower right")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "viewshed.png", dpi=100)
