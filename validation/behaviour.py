"""Behaviour of the paper's scenes by its own rules and by the defaults, each run and measured."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import process_time

import numpy as np

from references import igl, pybullet_world
from softbody import SoftBody, World
from softbody.scenes import boxes_on_torus, rolling_torus, sphere_on_torus, torus_stack
from validation.cases import corners_of, rotation_matrix
from validation.checks.worlds.fast import FLIGHT, TARGETS, shoot
from validation.record import Behaviour

SECONDS = 3.0  # of each scene
LOOK = 0.05  # [s] between two looks
STEP = 0.8  # of the stable time step

DEFAULTS, PAPER = "defaults", "the paper's own"
RULES: dict[str, Callable[..., World]] = {DEFAULTS: World, PAPER: World.paper}
SCENES: dict[str, Callable[..., World]] = {
    "1: sphere on torus": sphere_on_torus.build,
    "2: rolling torus": rolling_torus.build,
    "3: boxes on torus": boxes_on_torus.build,
    "4: stack of tori": torus_stack.build,
}


SHOTS = "balls shot at a plate"


def behaviours_of(scene: str, seconds: float = SECONDS) -> list[Behaviour]:
    """Run a scene by each of the RULES, in turns, and return what was seen."""
    if scene == SHOTS:
        return list(shots_by_rules())
    watched = {rules: Watched(SCENES[scene](world=world())) for rules, world in RULES.items()}
    for one in watched.values():
        one.world.step(one.step)  # compiles, before the clock starts
    for _ in range(round(seconds / LOOK)):
        for one in watched.values():
            one.look()
    return [
        Behaviour(
            scene=scene,
            rules=rules,
            seconds=seconds,
            penetration=float(one.deepest),
            energy_gain=float(one.gain),
            slip=float(np.mean(one.slips)) if scene.startswith("2") else None,
            cost=one.cost / watched[DEFAULTS].cost,
            real_time=seconds / one.cost,
        )
        for rules, one in watched.items()
    ]


def shots_by_rules(shots: int = 60) -> Iterator[Behaviour]:
    """Shoot the same fast balls at a plate of 0.1 m by each of the RULES, and yield what share went through."""
    passed, costs = {}, {}
    for rules, world in RULES.items():
        shoot(TARGETS[0], np.random.default_rng(0), world)  # compiles, before the clock starts
        rng, begin = np.random.default_rng(1), process_time()
        passed[rules] = 1.0 - np.mean([shoot(TARGETS[0], rng, world) for _ in range(shots)])
        costs[rules] = process_time() - begin
    for rules in RULES:
        seconds = shots * FLIGHT
        yield Behaviour(
            scene=SHOTS,
            rules=rules,
            seconds=seconds,
            penetration=None,
            energy_gain=None,
            slip=None,
            cost=costs[rules] / costs[DEFAULTS],
            real_time=seconds / costs[rules],
            tunnelled=float(passed[rules]),
        )


class Watched:
    """A world that is run, timed and looked at every LOOK."""

    def __init__(self, world: World) -> None:
        self.world = world
        world.model.soft_drag[:] = 0.0  # that of the stack, which would hide energy that contacts add
        self.step = STEP * world.stable_time_step()
        self.size = max(np.ptp(SoftBody(world, i).positions, axis=0).max() for i in range(world.model.soft_count))
        # What the weights could do if everything fell to the ground, which is at 0.
        heights = world.state.particle_position[:, 2] / world.model.particle_inverse_mass
        box_heights = world.state.box_position[:, 2] / world.model.box_inverse_mass
        self.fall = np.linalg.norm(world.controls.gravity) * (heights.sum() + box_heights.sum())
        self.lowest = self.energy()
        self.cost = self.deepest = self.gain = 0.0
        self.slips: list[float] = []

    def look(self) -> None:
        """Run on, on the clock of this process, for others run meanwhile; then measure."""
        begin = process_time()
        steps = max(1, round(LOOK / self.step))
        self.world.step(LOOK / steps, steps)
        self.cost += process_time() - begin
        energy = self.energy()
        self.gain = max(self.gain, (energy - self.lowest) / self.fall)
        self.lowest = min(self.lowest, energy)
        self.deepest = max([self.deepest, *(depth / self.size for depth in depths(self.world))])
        self.slips.extend(slips(self.world))

    def energy(self) -> float:
        """Return the energy [J], from which the world takes the work of the forces on particles: it must never rise."""
        return self.world.energy()


def slips(world: World) -> Iterator[float]:
    """Yield how fast the particles of body 0 that touch the ground slide, as a part of its speed, once it has one."""
    body = SoftBody(world, 0)
    speed = np.linalg.norm(body.velocities.mean(axis=0)[:2])
    touching = body.positions[:, 2] <= world.model.ground_height
    if touching.any() and speed > 1.0:
        yield float(np.linalg.norm(body.velocities[touching, :2], axis=1).mean() / speed)


def depths(world: World) -> Iterator[float]:
    """Yield how deep [m] things are inside each other, by igl and Bullet."""
    soft = [SoftBody(world, i) for i in range(world.model.soft_count)]
    sizes, places, turns = world.model.box_size, world.state.box_position, world.state.box_orientation
    corners = [place + corners_of(size) @ rotation_matrix(q).T for size, place, q in zip(sizes, places, turns)]
    for a in soft:
        yield max(0.0, world.model.ground_height - a.positions[:, 2].min())
        for b in soft:
            if a is not b:
                yield depth_in_mesh(a.positions, b.positions, b.triangles)
        edges = world.model.edge_particles[slice(*world.model.soft_edge_start[a.index : a.index + 2])]
        middles = world.state.particle_position[edges].mean(axis=1)  # edges may go in between their ends
        points_of_surface = np.concatenate([a.positions, middles])
        for size, place, q, points in zip(sizes, places, turns, corners):
            yield depth_in_mesh(points, a.positions, a.triangles)
            behind = 0.5 * size - np.abs((points_of_surface - place) @ rotation_matrix(q))
            yield max(0.0, behind.min(axis=1).max())
    for points in corners:
        yield max(0.0, world.model.ground_height - points[:, 2].min())
    i, j = np.triu_indices(len(sizes), 1)
    if len(i):
        distance, _ = pybullet_world.closest(sizes[i], places[i], turns[i], sizes[j], places[j], turns[j])
        yield max(0.0, -np.nanmin(distance, initial=0.0))


def depth_in_mesh(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> float:
    """Return how deep the deepest of `points` is inside a mesh [m], by igl."""
    near = points[((points > vertices.min(axis=0)) & (points < vertices.max(axis=0))).all(axis=1)]
    if not len(near):
        return 0.0
    inside = igl.points_in_mesh_by_distance(near, vertices, triangles)
    return float(igl.closest_points(near[inside], vertices, triangles)[0].max()) if inside.any() else 0.0
