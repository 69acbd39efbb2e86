"""A part from a mesh file is squeezed by a plate: `python squeeze_part.py part.stl`. Writes squeezed.png, force.png."""

import sys

import matplotlib.pyplot as plt

import softbody

mesh = softbody.Mesh.from_file(sys.argv[1], merge=True)  # pip install softbody[files]
low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
x, y, tall = high - low  # [m]
world = softbody.World()
world.add_ground()
part = world.add_soft_body(mesh, mass=0.1, stiffness=500.0, gas=1.0, position=-low, damping=0.3)
plate = world.add_box((0.9 * x, 0.5 * y, 0.1 * tall), mass=None, position=(0.5 * x, 0.5 * y, 1.05 * tall))
plate.move_to((0.5 * x, 0.5 * y, 0.75 * tall), seconds=2.0)
way, force = [], []
for _ in world.frames(seconds=2.0):
    way.append(1.05 * tall - plate.position[2])
    force.append(world.contact_points().of(part, plate).force_on(plate)[2])
print(f"pressed by {1e3 * way[-1]:.1f} mm, the plate presses with {sum(force[-12:]) / 12:.2f} N")
plt.plot(way, force)
plt.gca().set(xlabel="way [m]", ylabel="force [N]")
plt.savefig("force.png")
world.picture("squeezed.png", colour="strain")
