"""Two soft balls fall, one on the other: how high are they, and where does the energy go? Writes two_balls.png."""

import matplotlib.pyplot as plt

import softbody

world = softbody.World()
world.add_ground()
ball = softbody.icosphere(2, radius=0.5)
below = world.add_soft_body(ball, mass=1.0, stiffness=200.0, gas=30.0, position=(0.0, 0.0, 0.6), damping=0.3)
above = world.add_soft_body(ball, mass=0.5, stiffness=100.0, gas=20.0, position=(0.1, 0.0, 2.0), damping=0.3)

heights, energies = [], []
for _ in world.frames(seconds=3.0):
    heights.append((below.centre[2], above.centre[2]))
    energies.append(world.energies())

figure, (top, bottom) = plt.subplots(2, sharex=True)
top.plot(heights, label=["below", "above"])
top.set(ylabel="height of the centre [m]")
bottom.plot(energies, label=world.energies()._fields)
bottom.set(xlabel="time [1/60 s]", ylabel="energy [J]")
bottom.legend()
figure.savefig("two_balls.png")
