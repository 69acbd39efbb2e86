"""Which of a million points are inside a mesh that moves, and how far are some from it? Writes distance.png."""

import matplotlib.pyplot as plt
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

x, z = np.meshgrid(np.linspace(-1.7, 1.7, 170), np.linspace(-0.7, 1.1, 90))
distance = query.signed_distance(np.column_stack([x.ravel(), np.zeros(x.size), z.ravel()])).reshape(x.shape)
plt.contourf(x, z, distance, levels=20, cmap="RdBu")
plt.contour(x, z, distance, levels=[0.0])
plt.gca().set(aspect="equal", xlabel="x [m]", ylabel="z [m]", title="signed distance [m] in the plane y = 0")
plt.savefig("distance.png")
