"""Small worlds of every kind, in the middle of what happens to them: to be damaged."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import cache

import numpy as np

import softbody
from softbody import Mesh, SoftBody, SoftbodyError, World
from softbody.storage.snapshot_entries import Snapshot

BALL, SOLID = softbody.icosphere(1, 0.4), softbody.octahedron(0.4)


def two_tips() -> Mesh:
    """Return two tetrahedra that share a vertex: what surrounds it is no single ring."""
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1)], float)
    one, other = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)], [(0, 4, 5), (0, 6, 4), (4, 6, 5), (5, 6, 0)]
    mirrored = [(a, c, b) for a, b, c in other]
    for triangles in (one + other, one + mirrored):
        try:
            return Mesh(0.5 * corners, np.array(triangles))
        except softbody.MeshError:
            continue
    raise AssertionError("neither way round is closed")


def one_ball() -> World:
    """Return a ball that hangs on a particle, above a ground."""
    world = World()
    world.add_ground(-0.3, restitution=0.2, friction=0.4)
    world.add_soft_body(BALL, 1.0, 100.0, 10.0, velocity=(0.0, 0.0, -1.0), fixed=(0, 5), deflated_below=0.1)
    return world


def soft_bodies() -> World:
    """Return soft bodies of different meshes that touch each other, pushed and with springs that differ."""
    world = World(integrator="rk4")
    world.add_ground()
    meshes = softbody.box((0.6, 0.5, 0.4), 2), BALL, softbody.torus(0.4, 0.15, 8, 6), two_tips(), BALL
    for k, mesh in enumerate(meshes):
        stiffness = np.linspace(80.0, 120.0, len(mesh.edges)) if k % 2 else 100.0
        world.add_soft_body(mesh, 1.0 + k, stiffness, 5.0, (0.05 * k, 0.0, 0.2 + 0.4 * k), damping=0.1, friction=0.3)
    SoftBody(world, 1).external_force = (0.1, 0.0, 0.2)
    return world


def boxes() -> World:
    """Return a leaning stack of boxes on the ground and a static one."""
    world = World(gyroscopic=True, iterations=20)
    world.add_ground(friction=0.6)
    world.add_box((2.0, 2.0, 0.2), None, (0.0, 0.0, 0.1))
    for k in range(4):
        box = world.add_box((0.5, 0.4, 0.3), 1.0 + k, (0.05 * k, 0.0, 0.35 + 0.299 * k), restitution=0.1)
        box.apply_force((0.1, 0.0, 0.0), box.position + (0.0, 0.0, 0.1))
    world.add_box((0.3, 0.3, 0.3), 0.5, (2.0, 0.0, 1.0), velocity=(1.0, 0.0, 0.0), angular_velocity=(1.0, 2.0, 3.0))
    return world


def everything() -> World:
    """Return soft bodies and boxes on each other."""
    world = World((0.3, 0.0, -9.0), integrator="symplectic_euler", speed_ceiling=50.0)
    world.add_ground()
    world.add_soft_body(BALL, 1.0, 100.0, 20.0, (0.0, 0.0, 0.38), drag=0.05, fixed=(3,))
    world.add_soft_body(SOLID, 1.0, 100.0, 10.0, (0.1, 0.0, 1.0))
    for k in range(3):
        world.add_box((0.5, 0.4, 0.3), 2.0, (0.6, 0.0, 0.149 + 0.298 * k))
    world.add_box((0.4, 0.4, 0.2), 0.5, (0.0, 0.1, 1.4), velocity=(0.0, 0.0, -1.0))
    return world


def single() -> World:
    """Return soft bodies and a box in single precision."""
    world = World(precision="single")
    world.add_soft_body(BALL, 1.0, 100.0, 20.0)
    world.add_soft_body(two_tips(), 1.0, np.linspace(80.0, 120.0, 12), 10.0, (0.1, 0.0, 0.8))
    world.add_box((1.0, 1.0, 0.2), None, (0.0, 0.0, -0.45))
    return world


def papers() -> World:
    """Return bodies by the paper's own rules."""
    world = World.paper()
    world.add_ground()
    world.add_soft_body(BALL, 1.0, 100.0, 20.0, (0.0, 0.0, 0.6))
    world.add_soft_body(SOLID, 1.0, 100.0, 20.0, (0.2, 0.0, 1.2))
    world.add_box((0.5, 0.4, 0.3), 2.0, (0.0, 0.0, 0.15))
    world.add_box((0.5, 0.4, 0.3), 2.0, (0.1, 0.0, 0.44))
    return world


def joined() -> World:
    """Return bodies that hang on joints and on each other, and a box that moves by script."""
    world = World()
    ball = world.add_soft_body(BALL, 1.0, 100.0, 20.0, (0.0, 0.0, 1.0), drag=0.1)
    body = world.add_soft_body(SOLID, 1.0, 200.0, 10.0, (1.0, 0.0, 1.0))
    box = world.add_box((0.3, 0.2, 0.1), 2.0, (0.0, 0.0, 2.0))
    belt = world.add_box((3.0, 3.0, 0.2), None, (0.0, 0.0, 0.4), velocity=(0.5, 0.0, 0.1))
    world.add_joint((ball, 3), (box, box.position), 50.0, 0.1, 0.8)
    world.add_joint((box, (0.1, 0.0, 2.0)), (0.0, 0.0, 3.0), 80.0)
    world.add_joint((body, (1.3, 0.1, 1.0)), (ball, (0.3, 0.0, 1.0)), 20.0, 0.0, 0.5)
    world.add_joint((1.0, 0.0, 2.0), (body, 2), 20.0, 0.2)
    world.add_joint((belt, belt.position), (box, 0.9 * box.position), 1.0)
    return world


def empty() -> World:
    """Return a world of nothing."""
    return World()


KINDS: tuple[Callable[[], World], ...] = (one_ball, soft_bodies, boxes, everything, single, papers, joined, empty)


@cache
def snapshots() -> tuple[Snapshot, ...]:
    """Return a snapshot of each kind after some steps, on one thread and on two; nobody may change them.

    All that stepping them takes is compiled then.
    """
    found = []
    for make in KINDS:
        world = make()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            world.step(1e-3, 50)
            world.threads = 2
            world.step(1e-3, 10)
        found.append(world.snapshot())
    return tuple(found)


def lived(world: World, rng: np.random.Generator) -> str | None:
    """Step a world that somebody else made, and ask it; return what went wrong, if not with an error of the core's."""
    world.threads = 2 if rng.random() < 0.1 else 1
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for allow in (False, True):
            try:
                world.step(float(rng.choice([1e-4, 1e-3])), 3, allow_unstable=allow)
            except SoftbodyError:
                continue
            wrong = next((name for name, array in world.state._asdict().items() if not np.isfinite(array).all()), "")
            if wrong:
                return f"taken, and after 3 steps {wrong} is not finite"
    kept = World()
    try:
        kept.restore(world.snapshot())
    except SoftbodyError:
        return None  # it has gone too far to be kept
    for body in range(kept.model.soft_count):
        SoftBody(kept, body).triangles.sum()
    return None
