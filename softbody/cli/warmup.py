"""Compiles the core ahead of its first use, by small worlds of each kind, side by side."""

from __future__ import annotations

import multiprocessing
import os
import warnings
from concurrent.futures import ProcessPoolExecutor, as_completed
from itertools import product
from typing import NamedTuple

import numpy as np

import softbody
from softbody.cli.progress import reporter
from softbody.geometry import MeshQuery
from softbody.stepping.skins import next_look


class Kind(NamedTuple):
    """A kind of world: what a world has none of is not compiled for it."""

    soft: int
    boxes: int
    joint: bool = False
    may_sleep: bool = False
    threads: int = 1
    precision: str = "double"
    self_contact: bool = False
    liquid: bool = False


MIXED, BALLS, BOXES, BALL = (1, 2), (2, 0), (0, 2), (1, 0)
FLAT = 0.05  # of its height, to which a ring is pressed
ALL = tuple(product((False, True), (False, True), (2, 1)))  # joint, may_sleep, threads
# What takes longest comes first: it is what the others are waited for. Boxes are moved on one thread.
KINDS = (
    *(Kind(*MIXED, joint=joint, may_sleep=sleeps, threads=threads) for joint, sleeps, threads in ALL),
    *(Kind(*BALLS, joint=joint, may_sleep=sleeps, threads=threads) for joint, sleeps, threads in ALL),
    *(Kind(*bodies, precision="single") for bodies in (MIXED, BALLS)),
    *(Kind(*bodies, self_contact=True) for bodies in (MIXED, BALL)),
    *(Kind(*BOXES, joint=joint, may_sleep=sleeps) for joint, sleeps, threads in ALL if threads == 1),
    *(Kind(*BALL, threads=threads, liquid=True) for threads in (2, 1)),
    *(Kind(*BALL, joint=joint, may_sleep=sleeps, threads=threads) for joint, sleeps, threads in ALL),
    Kind(*BALL, precision="single"),
)


def warm_up() -> None:
    """Fill Numba's disk cache with the machine code of all kinds of worlds, each in a process of its own."""
    workers = min(len(KINDS), os.cpu_count() or 1)
    with (
        ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")) as processes,
        reporter(len(KINDS), 0, "kind of world") as report,
    ):
        for done, each in enumerate(as_completed([processes.submit(run_small_world, kind) for kind in KINDS]), 1):
            each.result()
            report(done)


def run_small_world(kind: Kind) -> None:
    """Take some steps of a world of a kind; of one with soft bodies and boxes, do all else that is compiled."""
    world = softbody.World(threads=kind.threads, precision=kind.precision, sleep_speed=1e-3 if kind.may_sleep else 0.0)
    world.add_ground()
    mesh = softbody.torus(0.4, 0.2, 6, 5)
    bodies: list[softbody.SoftBody | softbody.Box] = []
    for k in range(kind.soft):
        place, holds = (0.0, 0.0, 1.0 + k), kind.self_contact
        bodies.append(world.add_soft_body(mesh, mass=1.0, stiffness=50.0, gas=1.0, position=place, self_contact=holds))
    if kind.liquid:
        float_in_a_pool(world)
    for k in range(kind.boxes):
        bodies.append(world.add_box((1.0, 1.0, 1.0), mass=1.0, position=(5.0, 0.0, 0.5 + 0.9 * k)))
    if kind.joint:
        world.add_joint((bodies[0], (0.0, 0.0, 1.0)), (0.0, 0.0, 2.0), stiffness=1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of contacts that are missing
        world.step(1e-4, steps=next_look(0) if kind.soft else 1)  # when it is looked whether a ring meets itself
        if kind.self_contact:
            lie_on_itself(world)
        if kind == Kind(*MIXED):
            use_the_rest(world)


def float_in_a_pool(world: softbody.World) -> None:
    """Pour liquids around the first body and into it, and ask for all that is told of them."""
    body = world.soft_bodies[0]
    world.add_liquid(1000.0, 1.0)
    body.liquid_density = 500.0
    assert np.isfinite([body.submerged_volume, *body.buoyancy(), world.energies().liquid]).all()


def lie_on_itself(world: softbody.World) -> None:
    """Take a step with the first body so flat that it may touch itself: by other kernels than one that may not."""
    body = world.soft_bodies[0]
    flat = body.positions.copy()
    flat[:, 2] = flat[:, 2].mean() + FLAT * (flat[:, 2] - flat[:, 2].mean())
    body.positions = flat
    world.step(1e-4)


def use_the_rest(world: softbody.World) -> None:
    """Use once what is the same for all kinds of worlds, and what needs none."""
    body = world.soft_bodies[0]
    for value in (body.volume, body.pressure, body.strain):
        assert np.isfinite(value).all()
    world.picture(size=(8, 6))
    world.energies()
    world.linear_momentum()
    world.angular_momentum()
    world.equilibrium(1e-3)
    one, other = body.cut(body.centre, (1.0, 0.0, 0.0))
    whole = world.join(one, other, within=1e-6)
    whole.set_springs(tear_at=1.01)
    whole.positions = whole.centre + 1.05 * (whole.positions - whole.centre)
    world.step(1e-9, 2)
    assert whole.is_torn
    mesh = softbody.icosphere(2)
    mesh.check()
    query = MeshQuery(mesh)
    query.move(mesh.vertices + 0.1)
    for count in (10, 10_000):  # many points are looked up in a grid
        query.contains(np.zeros((count, 3)))
    query.signed_distance(np.zeros((10, 3)))
