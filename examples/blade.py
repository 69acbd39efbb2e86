"""A blade cuts a block of gas, whose halves fall apart. Writes blade.webp."""

import softbody

world = softbody.World(substeps=2)
world.add_ground()
mesh = softbody.box((1.2, 0.8, 0.8), segments=8)
block = world.add_soft_body(mesh, 2.0, 400.0, gas=20.0, position=(0.0, 0.0, 0.45), damping=1.0, name="block")
blade = world.add_box((0.03, 1.2, 0.8), mass=None, position=(0.1, 0.0, 1.5), velocity=(0.0, 0.0, -1.0))

with softbody.Recorder(world, "blade.webp", frames_per_second=20) as film:
    while blade.position[2] - 0.4 > block.positions[:, 2].max():
        film.run(seconds=0.05)
    halves = block.cut(blade.position, normal=(1.0, 0.0, 0.0))
    film.run(seconds=0.8)
    blade.velocity = (0.0, 0.0, 0.0)
    film.run(seconds=0.5)
for half in halves:
    print(f"{half.name}: {half.mass:.2f} kg, {half.gas:.1f} J of gas, {half.volume:.3f} m³")
