"""A part from a mesh file is squeezed by a plate: `python squeeze_part.py part.stl`. Writes squeezed.png."""

import sys

import softbody

mesh = softbody.Mesh.from_file(sys.argv[1], merge=True)  # pip install softbody[files]
for finding in mesh.check():
    print(finding)
low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
tall, wide = (high - low)[2], (high - low).max()

world = softbody.World()
world.add_ground()
part = world.add_soft_body(mesh, mass=1.0, stiffness=300.0, gas=5.0, position=-low, damping=1.0)
plate = world.add_box((0.9 * wide, 0.4 * wide, 0.1 * wide), 2.0, (*(0.5 * (high - low))[:2], tall + 0.06 * wide))
before = part.volume
for _ in world.frames(seconds=2.0):
    pass
print(f"{tall:.3f} m became {plate.position[2] - 0.05 * wide:.3f} m, and {before:.4f} m³ {part.volume:.4f} m³")
print(f"the plate presses with {world.contact_points().of(part, plate).force_on(plate)[2]:.1f} N")
world.picture("squeezed.png", colour="strain")
