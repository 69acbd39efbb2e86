"""A ball with a weak spot is blown up until it bursts. Writes burst.webp, which ends in slow motion."""

import numpy as np

import softbody

world = softbody.World()
world.add_ground()
mesh = softbody.icosphere(3, radius=0.5)
weak = np.linalg.norm(mesh.vertices[mesh.edges].mean(axis=1) - (0.4, 0.0, 0.25), axis=1) < 0.15
limits = np.where(weak, 1.5, 2.1)
ball = world.add_soft_body(mesh, 2.0, 300.0, gas=60.0, position=(0.0, 0.0, 0.5), tear_at=limits, leak=10.0, name="ball")
camera = softbody.Camera(eye=(4.0, -4.5, 2.0), target=(0.0, 0.0, 0.9))

with softbody.Recorder(world, "burst.webp", frames_per_second=25, camera=camera) as film:
    while not world.events:
        film.run(seconds=0.04)
        ball.gas += 30.0
    print(f"it bursts at {world.events[0].time:.2f} s and {ball.pressure:.0f} Pa")
    for _ in range(40):
        world.run(seconds=0.006)
        film.frame()
print(f"{len(world.soft_bodies)} pieces, {ball.gas:.1f} J of gas left")
