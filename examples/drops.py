"""Two drops that meet become one. Writes drops.webp."""

import softbody

world = softbody.World(gravity=(0.0, 0.0, 0.0), self_contact=True)
mesh = softbody.icosphere(2, 0.5)
mirrored = softbody.Mesh(mesh.vertices * (-1.0, 1.0, 1.0), mesh.triangles[:, ::-1])
left = world.add_soft_body(mesh, 0.5, 60.0, gas=6.0, position=(-0.7, 0.0, 0.0), velocity=(1.0, 0.0, 0.0), name="drop")
right = world.add_soft_body(mirrored, 0.5, 60.0, gas=6.0, position=(0.7, 0.0, 0.0), velocity=(-1.0, 0.0, 0.0))

with softbody.Recorder(world, "drops.webp", frames_per_second=25) as film:
    while len(world.contact_points()) < 20:
        film.run(seconds=0.04)
    drop = world.join(left, right, within=0.03)  # where triangles lie on each other
    film.run(seconds=1.0)
print(f"{drop!r}: one drop with {drop.gas:.0f} J of gas")
