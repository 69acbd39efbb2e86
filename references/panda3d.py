"""Rest shape and breathing of Bullet's soft body with gas (Bullet 2.84 in Panda3D, float32).

Panda3D opens the pressure of Bullet's soft body, which pybullet keeps shut. Nothing damps, drags or collides by
default. Bullet has another law than springs and an ideal gas, seen in its source and in `force_of_gas`; what is chosen
so that both mean the same is in SETTINGS. That makes regular solids exact; on a sphere its twelve vertices of five
triangles keep a fifth too much gas. A velocity is a difference of float32 positions over h: steps below ωh = 0.05 make
every answer worse.
"""

from __future__ import annotations

import numpy as np
from panda3d.bullet import BulletSoftBodyNode, BulletWorld
from panda3d.core import LVecBase3, PTA_int, PTA_LVecBase3, Vec3

from references.analytic import breathing_frequency, equilibrium_scale

PACKAGES = {"panda3d": "panda3d"}  # import name, and the name to install it by
KIND = "third-party engine"  # of judge
SETTINGS = {  # what was chosen against the defaults, and why
    "kPR set anew each step, such that the gas does the work of nRT on a body that swells evenly": (
        "Bullet pushes a node along its normal with kPR/V × the mean |(b−a)×(c−a)| of its triangles at rest: a "
        "third of their area where six meet, 6/5 and 3/2 of it where five and four do, and it does not grow with "
        "the body"
    ),
    "tension and stiffness of the links those of k (l − l0) at the length of rest of the closed form": (
        "a link pulls with k l (l² − r²)/(l² + r²): its r and k are chosen for that"
    ),
    "extrapolated from two steps": "links move the positions that the gas has moved already: an error of (ωh)²",
    "one period only is timed": "each step loses (ωh)²/2 of the amplitude",
}

SETTLE = 60.0  # [rad] of breathing, near the critical damping: the motion that is left is below float32
SAMPLES = 20  # volumes at rest to take the mean of: the last digit of float32 flickers


def volume_at_rest(
    vertices: np.ndarray, edges: np.ndarray, triangles: np.ndarray, stiffness: float, gas: float, phase: float = 0.2
) -> float:
    """Return the volume [m³] at which springs hold the gas, extrapolated from steps of `phase` and half of it.

    `vertices` (n, 3) [m] are the shape at which no spring pulls, `edges` (e, 2), `triangles` (t, 3), `stiffness`
    [N/m], `gas` nRT [J] > 0; `phase` is ωh of the breathing.
    """
    coarse, fine = (_GasBody(vertices, edges, triangles, stiffness, gas, 1.0, p) for p in (phase, 0.5 * phase))
    return (4.0 * fine.settle() - coarse.settle()) / 3.0


def breathing_period(
    vertices: np.ndarray,
    edges: np.ndarray,
    triangles: np.ndarray,
    stiffness: float,
    gas: float,
    mass: float,
    swing: float,
    phase: float = 0.2,
) -> float:
    """Return the time [s] of one breath about the shape at rest, extrapolated from two steps.

    Every particle of the body of `mass` [kg] starts at rest length with the velocity `swing` ω (x − centre), where ω
    is the breathing frequency of a regular solid; other arguments as of `volume_at_rest`.
    """
    coarse, fine = (_GasBody(vertices, edges, triangles, stiffness, gas, mass, p) for p in (phase, 0.5 * phase))
    return (4.0 * fine.breathe(swing) - coarse.breathe(swing)) / 3.0


def force_of_gas(vertices: np.ndarray, triangles: np.ndarray, coefficient: float, node: int) -> float:
    """Return the force [N] with which Bullet's gas of kPR = `coefficient` [J] pushes one node of a body at rest."""
    world, body = _soft_body(vertices, triangles)
    body.get_material(0).linear_stiffness = 1e-9
    body.get_cfg().pressure_coefficient = coefficient
    step = 0.1  # long: the velocity is a difference of positions in float32
    world.do_physics(step, 0)  # Bullet has no normals before its first step
    world.do_physics(step, 0)
    return float(np.linalg.norm(body.get_node(node).velocity)) / step / float(body.get_node(node).inv_mass)


class _GasBody:
    """One body in Bullet with its step, links and gas chosen as the file says."""

    def __init__(
        self,
        vertices: np.ndarray,
        edges: np.ndarray,
        triangles: np.ndarray,
        stiffness: float,
        gas: float,
        mass: float,
        phase: float,
    ) -> None:
        if not gas > 0.0:
            raise ValueError(f"gas is {gas} J; Bullet's links are chosen for a stretched body: use a positive one")
        rest_squared = stiffness * ((vertices[edges[:, 1]] - vertices[edges[:, 0]]) ** 2).sum()
        spread = vertices - vertices.mean(axis=0)
        particle = mass / len(vertices)
        self.frequency = float(breathing_frequency(gas, rest_squared, particle * (spread**2).sum()))
        self.step = phase / self.frequency
        self.phase, self.gas = phase, gas

        # Equal tension and slope at l = λ l0: with ε = λ − 1, y = (r/l)² solves y² + 4 ε y − 1 = 0.
        scale = float(equilibrium_scale(gas, rest_squared))
        strain = scale - 1.0
        y = np.sqrt(1.0 + 4.0 * strain**2) - 2.0 * strain
        link = stiffness * strain / scale * (1.0 + y) / (1.0 - y)
        self.world, self.body = _soft_body(spread * scale * np.sqrt(y), triangles)
        self.nodes = range(len(vertices))
        for node in self.nodes:
            self.body.set_mass(node, particle)
        # A link moves each end by kLST/2 (l² − r²)/(l² + r²) of itself, that is by force × h²/m.
        self.body.get_material(0).linear_stiffness = 2.0 * link * self.step**2 / particle
        self.settings = self.body.get_cfg()
        self.world.do_physics(self.step, 0)  # takes the positions as r, and makes areas and normals
        self.start = self.body.get_volume()
        elements = [self.body.get_node(node) for node in self.nodes]
        self.share = 3.0 * self.start / sum(e.area * np.dot(e.normal, e.pos) for e in elements)

    def advance(self) -> float:
        """Take one step with the gas that the volume asks for; return the volume before it."""
        volume = self.body.get_volume()
        self.settings.pressure_coefficient = self.gas * self.share * (volume / self.start) ** (2.0 / 3.0)
        self.world.do_physics(self.step, 0)
        return volume

    def settle(self) -> float:
        """Let damping bring the body to rest; return its volume [m³]."""
        self.settings.damping_coefficient = min(2.0 * self.phase, 0.9)
        for _ in range(int(SETTLE / self.phase)):
            self.advance()
        return float(np.mean([self.advance() for _ in range(SAMPLES)]))

    def breathe(self, swing: float) -> float:
        """Kick the body at rest, evenly in all directions; return when [s] it swells through that volume again."""
        middle = self.settle()
        self.settings.damping_coefficient = 0.0
        for node in self.nodes:
            position = np.array(self.body.get_node(node).pos)
            self.body.add_velocity(Vec3(*(swing * self.frequency * position).tolist()), node)
        above = [self.advance() - middle for _ in range(int(1.25 * 2.0 * np.pi / self.phase))]
        quarter = len(above) // 5  # past the start, where rounding decides the sign
        upward = next(i for i in range(quarter, len(above)) if above[i - 1] < 0.0 <= above[i])
        return self.step * (upward - above[upward] / (above[upward] - above[upward - 1]))


def _soft_body(positions: np.ndarray, triangles: np.ndarray) -> tuple[BulletWorld, BulletSoftBodyNode]:
    """Return a world without gravity and in it a body: nodes of 1 kg, a link on every edge."""
    world = BulletWorld()
    world.set_gravity(Vec3(0.0, 0.0, 0.0))
    points, indices = PTA_LVecBase3.empty_array(0), PTA_int.empty_array(0)
    for position in positions.tolist():
        points.push_back(LVecBase3(*position))
    for index in triangles.ravel().tolist():
        indices.push_back(index)
    body = BulletSoftBodyNode.make_tri_mesh(world.get_world_info(), points, indices, False)
    world.attach(body)
    return world, body
