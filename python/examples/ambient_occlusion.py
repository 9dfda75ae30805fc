"""Ambient occlusion at the vertices, blended over the triangles that a camera sees."""

import sys
import warnings

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import boxwood
from boxwood import jobs

warnings.simplefilter("ignore")
scene = boxwood.Scene.load(sys.argv[2] if len(sys.argv) > 2 else "builtin:bush?n=20000")
vertices, triangles = scene.mesh()
normals = jobs.vertex_normals(vertices, triangles)
diagonal = float(np.linalg.norm(np.diff(scene.bounds, axis=0)))
share = jobs.ambient_occlusion(scene, vertices, normals, rays=128, distance=diagonal / 2)

size = (720, 540)
camera = scene.camera(size)
wide = np.degrees(2 * np.arctan(np.tan(np.radians(camera["fov_deg"]) / 2) * size[0] / size[1]))
rays = scene.create_rays_pinhole(
    fov_deg=wide, center=camera["target"], eye=camera["eye"], up=camera["up"], width_px=size[0], height_px=size[1]
)
picture = scene.cast_rays(rays, interpolate={"share": share})["share"]
shown = np.where(np.isnan(picture)[..., None], [0.62, 0.72, 0.85], picture[..., None])
plt.imsave(sys.argv[1] if len(sys.argv) > 1 else "ambient_occlusion.png", np.clip(shown, 0, 1))
