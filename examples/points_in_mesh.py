"""Which of a million points are inside a mesh that moves, and how far are some from it?"""

import numpy as np

import softbody
from softbody.geometry import MeshQuery

mesh = softbody.torus(major_radius=1.0, minor_radius=0.4)
points = np.random.default_rng(0).uniform(-1.5, 1.5, (1_000_000, 3))
query = MeshQuery(mesh)
for frame in range(3):
    query.move(mesh.vertices + (0.0, 0.0, 0.1 * frame))
    inside = query.contains(points)
    print(f"frame {frame}: {inside.sum()} inside, so {27.0 * inside.mean():.3f} m³ of {mesh.volume:.3f}")
    print(f"the deepest of a thousand is {-query.signed_distance(points[:1000]).min():.4f} m inside")
