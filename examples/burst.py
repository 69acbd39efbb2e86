"""A ball with a weak spot is blown up until it bursts, and flies off. Writes burst.webp, the burst in slow motion."""

import numpy as np

import softbody

world = softbody.World()
world.add_ground()
mesh = softbody.icosphere(3, radius=0.5)
middles = mesh.vertices[mesh.edges].mean(axis=1)
weak = np.linalg.norm(middles - (0.4, 0.0, 0.25), axis=1) < 0.15
ball = world.add_soft_body(
    mesh, 2.0, 300.0, gas=20.0, position=(0.0, 0.0, 0.5), tear_at=np.where(weak, 1.6, 2.2), leak=10.0, name="ball"
)
camera = softbody.Camera(eye=(4.0, -4.5, 2.0), target=(0.0, 0.0, 0.9))

with softbody.Recorder(world, "burst.webp", frames_per_second=25, camera=camera) as film:
    while not world.events:
        film.run(seconds=0.04)
        ball.gas += 12.0
    print(f"it bursts at {world.events[0].time:.2f} s and {ball.pressure:.0f} Pa")
    for _ in range(60):
        world.run(seconds=0.004)
        film.frame()
print(f"{len(world.soft_bodies)} pieces, {ball.gas:.1f} J of gas left")
