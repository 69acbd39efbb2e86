"""Two hands pull a ring until it rips, and falls. Writes rip.webp."""

import numpy as np

import softbody

world = softbody.World()
world.add_ground()
mesh = softbody.torus(0.8, 0.2, 48, 12)
ring = world.add_soft_body(mesh, 2.0, 400.0, 2.0, position=(0.0, 0.0, 1.5), tear_at=1.3, damping=3.0, name="ring")
hands = []
for side in (-1.0, 1.0):
    grip = np.flatnonzero(mesh.vertices[:, 0] * side > 0.9)
    hands += [(world.add_joint((ring, int(i)), ring.positions[i], 500.0, 5.0), side) for i in grip]
camera = softbody.Camera(eye=(0.5, -6.5, 3.0), target=(0.0, 0.0, 0.8))
with softbody.Recorder(world, "rip.webp", frames_per_second=20, camera=camera) as film:
    while len(world.soft_bodies) == 1:
        for hand, side in hands:
            hand.target += (0.03 * side, 0.0, 0.0)
        film.run(seconds=0.05)
    for hand, _ in hands:
        world.remove(hand)
    film.run(seconds=0.8)
print(f"{len(world.events)} tears, the first at {world.events[0].time:.2f} s; {len(world.soft_bodies)} pieces")
