"""A soft torus rolls over bumps: a film, coloured by strain. Writes rolling.webp; `film.py view` goes on live."""

import sys

import softbody

world = softbody.World()
world.add_ground(friction=0.9)
for k in range(4):
    world.add_box((0.15, 3.0, 0.15), mass=None, position=(1.5 + 1.2 * k, 0.0, 0.05))
ring = softbody.torus(1.0, 0.4, 32, 16).vertices[:, [0, 2, 1]] * (1.0, -1.0, 1.0)
wheel = softbody.Mesh(ring, softbody.torus(1.0, 0.4, 32, 16).triangles)
body = world.add_soft_body(wheel, 2.0, 400.0, 100.0, (0.0, 0.0, 1.45), (3.0, 0.0, 0.0), damping=0.5, friction=0.9)
spin = body.positions - body.centre
body.velocities += 2.2 * spin[:, [2, 1, 0]] * (1.0, 0.0, -1.0)

with softbody.Recorder(world, "rolling.webp", frames_per_second=20, colour="strain", colour_range=(0.0, 0.1)) as film:
    film.run(seconds=1.6)
print(world, world.energies())
if "view" in sys.argv:  # in the browser: pip install softbody[view]
    world.view()
