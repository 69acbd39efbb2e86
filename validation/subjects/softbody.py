"""The core itself, as the first subject."""

from __future__ import annotations

import numpy as np

from softbody import Mesh, World
from softbody.collision.boxes import sat_boxes
from softbody.geometry import points_in_mesh as ask_points
from validation.cases import BoxPairs
from validation.effort import finer, iterations
from validation.subject import Boxes, GasBody, Motion, SoftMotion, SoftScene, moving, moving_soft, swells_again

SETTINGS = {  # what was chosen against the defaults, and why
    "gyroscopic torque on": "a body that turns freely is asked whether it keeps its angular momentum",
    "integrator rk4 for gas": "the default is the paper's; rest and breath are asked about, not its order",
}

SAMPLES = 400  # of a breath: the crossing between two of them is straight to 1e-6


def move_boxes(boxes: Boxes, step: float, steps: int, every: int) -> Motion:
    """Let boxes move."""
    world = _world_of(boxes)

    def now() -> tuple[np.ndarray, ...]:
        state = world.state
        return state.box_position, state.box_orientation, state.box_velocity, state.box_angular_velocity

    return moving(now, lambda count: world.step(step, count), steps, every)


def move_soft(scene: SoftScene, step: float, steps: int, every: int) -> SoftMotion:
    """Let bodies with gas move among boxes."""
    world = _world_of(scene.boxes)
    bodies = []
    for body, velocity in scene.rows():
        mesh = Mesh(body.vertices, body.triangles)
        one = world.add_soft_body(mesh, body.mass, body.stiffness, body.gas, damping=0.0, drag=scene.drag)
        one.restitution, one.friction = scene.boxes.restitution, scene.boxes.friction
        bodies.append(one)
        bodies[-1].velocities[:] = velocity

    def now() -> tuple[np.ndarray, ...]:
        state = world.state
        soft = [rows for one in bodies for rows in (one.positions, one.velocities)]
        boxes = state.box_position, state.box_orientation, state.box_velocity, state.box_angular_velocity
        return *soft, *boxes

    return moving_soft(now, lambda count: world.step(step, count), steps, every)


def _world_of(boxes: Boxes) -> World:
    world = World(gravity=(0.0, 0.0, -boxes.gravity), gyroscopic=True, iterations=iterations(30))
    for size, mass, position, orientation, velocity, spin in boxes.rows():
        world.add_box(
            size,
            None if np.isinf(mass) else float(mass),
            position,
            orientation,
            velocity,
            spin,
            restitution=boxes.restitution,
            friction=boxes.friction,
        )
    return world


def boxes_overlap(*pairs: np.ndarray) -> np.ndarray:
    """Tell whether boxes overlap."""
    both = BoxPairs(*pairs)
    return np.asarray(sat_boxes.box_pairs_overlap(both.a, both.b))


def gas_volume(body: GasBody) -> float:
    """Return the volume at rest."""
    return float(_at_rest(body).soft_bodies[0].volume)


def gas_period(body: GasBody, swing: float) -> float:
    """Return the time of a breath."""
    world = _at_rest(body)
    (ball,) = world.soft_bodies
    ball.velocities[:] = swing * body.frequency * (ball.positions - ball.centre)
    samples = round(SAMPLES * finer())
    middle, time_step = ball.volume, 2.0 * np.pi / body.frequency / samples

    def advance() -> float:
        world.step(time_step)
        return float(ball.volume) - middle

    return time_step * swells_again(advance, samples)


def points_in_mesh(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Tell whether points are inside."""
    return np.asarray(ask_points(points, vertices, triangles))


def _at_rest(body: GasBody) -> World:
    world = World(gravity=(0.0, 0.0, 0.0), integrator="rk4")
    mesh = Mesh(body.vertices, body.triangles)
    world.add_soft_body(mesh, mass=body.mass, stiffness=body.stiffness, gas=body.gas, damping=0.0)
    world.equilibrium()
    return world
