"""A ball hangs from a nail, is pulled aside, let go, and blown up until it meets a wall. Writes inflated.png."""

import numpy as np

import softbody

world = softbody.World()
wall = world.add_box((0.2, 4.0, 4.0), mass=None, position=(1.2, 0.0, 0.0))
ball = world.add_soft_body(softbody.icosphere(3, radius=0.5), mass=1.0, stiffness=80.0, gas=40.0, damping=0.2)
ball.fixed = np.argsort(ball.positions[:, 2])[-13:]  # all around the nail: by one alone the skin would fold
ball.external_force = (-0.05, 0.0, 0.0)
touched: set[tuple[int, int]] = set()
for frame in world.frames(seconds=6.0):
    if frame == 60:
        ball.external_force = (0.0, 0.0, 0.0)
    if frame > 120:
        ball.gas = min(60.0, 1.01 * ball.gas)
    now = world.contact_points()
    for pair in now.pairs() - touched:
        print(f"{world.time:.2f} s: {pair} touch, with {np.linalg.norm(now.force_on(wall)):.2f} N")
    for pair in touched - now.pairs():
        print(f"{world.time:.2f} s: {pair} part; the ball's volume is {ball.volume:.2f} m³")
    touched = now.pairs()
world.picture("inflated.png", camera=softbody.Camera((-3.0, -4.0, 1.5), (0.4, 0.0, 0.0)), colour="strain")
