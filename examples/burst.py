"""A ball with a weak spot is blown up until it bursts. Writes burst.webp."""

import numpy as np

import softbody

world = softbody.World()
world.add_ground()
mesh = softbody.icosphere(3, radius=0.5)
weak = mesh.vertices[mesh.edges].mean(axis=1)[:, 0] > 0.45
ball = world.add_soft_body(
    mesh, 1.0, 300.0, gas=20.0, position=(0.0, 0.0, 0.5), tear_at=np.where(weak, 1.6, 2.5), damping=0.4, name="ball"
)
with softbody.Recorder(world, "burst.webp", frames_per_second=25) as film:
    while not world.events:
        film.run(seconds=0.04)
        ball.gas += 12.0
    print(f"bursts at {world.events[0].time:.2f} s, {ball.pressure:.0f} Pa")
    film.run(seconds=1.0)
print(f"{len(world.soft_bodies)} pieces, {ball.gas:.1f} J of gas left")
