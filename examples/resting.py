"""A soft sphere comes to rest on a soft torus: who carries how much? Writes resting.png."""

import softbody

world = softbody.World()
world.add_ground()
ring = softbody.torus(1.0, 0.4, 36, 18)
torus = world.add_soft_body(ring, mass=2.0, stiffness=400.0, gas=150.0, position=(0.0, 0.0, 0.45), drag=2.0)
ball = softbody.icosphere(3, radius=0.9)
sphere = world.add_soft_body(ball, mass=1.0, stiffness=300.0, gas=150.0, position=(0.0, 0.0, 1.6), drag=2.0)
world.run(seconds=5.0)

now = world.contact_points()
on_sphere, on_torus = now.force_on(sphere)[2], now.force_on(torus)[2]
print(f"the torus carries {on_sphere:.2f} N: the sphere weighs {9.81 * sphere.mass:.2f} N")
print(f"the ground carries {on_sphere + on_torus:.2f} N: both weigh {9.81 * (sphere.mass + torus.mass):.2f} N")
world.picture("resting.png", colour="strain", size=(560, 360))
