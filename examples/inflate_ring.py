"""A ring is blown up: do gas and springs agree at every size? Writes inflated.png and the plot inflating.png."""

import matplotlib.pyplot as plt
import numpy as np

import softbody

world = softbody.World(gravity=(0.0, 0.0, 0.0))
ring = world.add_soft_body(softbody.torus(1.0, 0.3, 32, 16), mass=1.0, stiffness=60.0, gas=1.0, damping=0.2)
gases, volumes, by_springs = np.geomspace(1.0, 300.0, 15), [], []
for gas in gases:
    ring.gas = gas
    world.equilibrium(1e-9)
    length, rest = (1.0 + ring.strain) * ring.rest_length, ring.rest_length
    volumes.append(ring.volume)
    by_springs.append((ring.stiffness * (length - rest) * length).sum() / (3.0 * ring.volume))  # the virial theorem
worst = np.abs(np.array(by_springs) / (gases / volumes) - 1.0).max()
print(f"from {volumes[0]:.2f} to {volumes[-1]:.2f} m³ the two differ by {worst:.1e} at most")
plt.plot(volumes, gases / volumes, label="ideal gas: nRT / V")
plt.plot(volumes, by_springs, "x", label="springs: Σ k (l − l₀) l / 3V")
plt.gca().set(xlabel="volume [m³]", ylabel="pressure [Pa]")
plt.legend()
plt.savefig("inflating.png")
world.picture("inflated.png", colour="strain")
