"""Twelve soft balls fill a box: how high do they lie, and what does its floor carry? Writes container.png."""

import softbody

world, wide, thick, high = softbody.World(), 0.8, 0.1, 1.2
floor = world.add_box((wide + 2 * thick, wide + 2 * thick, thick), None, (0.0, 0.0, -thick / 2), name="floor")
for side in (-1, 1):
    world.add_box((thick, wide + 2 * thick, high), None, (side * (wide + thick) / 2, 0.0, high / 2))
    world.add_box((wide, thick, high), None, (0.0, side * (wide + thick) / 2, high / 2))
ball = softbody.icosphere(2, 0.18)
for k in range(12):
    place = (-0.2 + 0.4 * (k % 2), -0.2 + 0.4 * (k // 2 % 2), 0.25 + 0.42 * (k // 4))
    world.add_soft_body(ball, mass=0.5, stiffness=150.0, pressure=800.0, position=place, drag=0.5)
world.run(seconds=4.0)
top = max(body.positions[:, 2].max() for body in world.soft_bodies)
carried = [-world.contact_points().force_on(floor)[2] for _ in world.frames(seconds=1.0)]
mean = sum(carried) / len(carried)
print(f"they lie up to {top:.2f} m; the floor carries {mean:.0f} N of {12 * 0.5 * 9.81:.0f} N, the walls the rest")
world.picture("container.png", colour="pressure", size=(560, 360))
