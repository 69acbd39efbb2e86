"""Worlds that are stepped to see whether the core still computes the same bits.

They are of all kinds: every scene, and what settings, precisions, threads, joints and sleep make other ways through the
core.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import softbody
from softbody import World, scenes

FILES = Path(__file__).parent / "files"

SMALL = {"subdivisions": 2, "bodies": 3, "boxes": 6}  # arguments of scenes, where they have such
FALL = 4.0  # [m/s] at which everything comes down at first, so that it meets within few steps
SLEEP: dict[str, Any] = {"sleep_speed": 2.0, "sleep_after": 0.02}  # so fast that some fall asleep within few steps


class Case(NamedTuple):
    """A world to build, and how it is stepped."""

    build: Callable[[], World]
    h: float = 1e-3  # [s] of a step
    steps: int = 400
    threads: int = 1  # that it asks for


def may_abort(build: Callable[..., World], **given: Any) -> World:
    """Return the world of a scene in which all that can move comes down at FALL."""
    world = build(**given)
    world.state.particle_velocity[:, 2] = -FALL
    for box in world.boxes:
        if box.mass is not None:
            box.velocity = box.velocity - (0.0, 0.0, FALL)
    return world


def scene(name: str, kind: Callable[..., World] = World, **settings: Any) -> World:
    """Return a scene, small, in a world of a kind and of some settings."""
    build = getattr(scenes, name).build
    given = {key: value for key, value in SMALL.items() if key in inspect.signature(build).parameters}
    return may_abort(build, **given, world=kind(**settings))


def ball(**settings: Any) -> World:
    """Return one free ball that turns and breathes."""
    world = World(**settings)
    made = world.add_soft_body(softbody.icosphere(2, 0.5), 1.0, 100.0, 25.0, (0.0, 0.0, 1.0), drag=0.1)
    made.velocities = np.cross((1.0, 2.0, 3.0), made.positions)
    return world


def balls_on_ground(**settings: Any) -> World:
    """Return three soft bodies, one of them held, that meet each other and the ground."""
    world = World(**settings)
    world.add_ground(0.0, 0.2, 0.6)
    world.add_soft_body(softbody.icosphere(2, 0.5), 1.0, 100.0, 15.0, (0.0, 0.0, 0.55), restitution=0.3)
    world.add_soft_body(softbody.torus(0.5, 0.2, 16, 8), 0.8, 120.0, 8.0, (0.1, 0.2, 1.35), (0.5, 0.0, 0.0))
    world.add_soft_body(softbody.icosphere(1, 0.4), 0.5, 90.0, 8.0, (0.9, 0.0, 0.45), fixed=(0, 3, 5), friction=0.9)
    return may_abort(lambda: world)


def joined(**settings: Any) -> World:
    """Return bodies joined to each other and the world, a box that is led, and forces that act."""
    world = World(**settings)
    world.add_ground()
    hung = world.add_soft_body(softbody.icosphere(1, 0.4), 0.7, 80.0, 8.0, (0.0, 0.0, 1.5), name="hung")
    lower = world.add_box((0.6, 0.5, 0.3), 2.0, (0.0, 0.0, 0.15))
    crate = world.add_box((0.3, 0.3, 0.3), 1.0, (1.0, 0.0, 0.6), (0.8, 0.0, 0.6, 0.0), name="crate")
    rail = world.add_box((0.4, 0.4, 0.2), None, (-1.0, 0.0, 0.2))
    rail.move_to((-0.4, 0.0, 0.3), (0.8, 0.0, 0.0, 0.6), seconds=0.2)
    world.add_joint((hung, 0), (0.0, 0.0, 2.5), 60.0, 0.5, 0.5)
    world.add_joint((hung, (0.3, 0.1, 1.3)), (crate, crate.position + (0.1, 0.1, 0.0)), 30.0, 0.3)
    world.add_joint((crate, crate.position), (lower, (0.3, 0.2, 0.3)), 50.0, 0.2, 0.6, name="cord")
    hung.external_force = (0.01, 0.0, 0.0)
    crate.apply_force((0.0, 0.5, 0.0), crate.position + (0.1, 0.0, 0.0))
    return world


def relaxed() -> World:
    """Return a ball at rest on two of its particles."""
    world = World()
    world.add_soft_body(softbody.icosphere(1, 0.5), 0.3, 100.0, 10.0, fixed=(0, 1))
    world.equilibrium(1e-9)
    return world


def by_frames() -> World:
    """Return a tray that has chosen its own steps for some frames."""
    world = may_abort(scenes.tray.build, bodies=2)
    world.run(0.1)
    return world


def cases() -> dict[str, Case]:
    """Return all worlds, by name."""
    found = {f"scene {name}": Case(partial(scene, name), 5e-4, 600) for name in scenes.__all__}
    for precision, threads, substeps in product(("double", "single"), (1, 2), (1, 2)):
        how: dict[str, Any] = {"precision": precision, "threads": threads, "substeps": substeps}
        called = f"{precision}, {threads} threads, {substeps} substeps"
        found[f"tray: {called}"] = Case(partial(scene, "tray", **how), 2e-3, 200, threads)
        if threads == 1 or precision == "single":  # every other way is compiled for some tens of seconds
            found[f"balls on ground: {called}"] = Case(partial(balls_on_ground, **how), threads=threads)
        if threads == 1:
            found[f"ball alone: {called}"] = Case(partial(ball, **how))
    for integrator in ("rk4", "rk4_velocity"):
        found[f"tray: {integrator}"] = Case(partial(scene, "tray", integrator=integrator))
        found[f"balls on ground: {integrator}"] = Case(partial(balls_on_ground, integrator=integrator))
        found[f"ball alone: {integrator}"] = Case(partial(ball, integrator=integrator))
        found[f"joined: {integrator}"] = Case(partial(joined, integrator=integrator))
    for name in ("tray", "box_pile", "box_stack", "sphere_on_torus", "boxes_on_torus"):
        found[f"{name}: sleep"] = Case(partial(scene, name, **SLEEP), 1e-3, 800)
    for name in ("tray", "box_pile", "box_stack", "sphere_on_torus", "torus_stack"):
        found[f"{name}: paper"] = Case(partial(scene, name, World.paper), 5e-4, 600)
    found["box_pile"] = Case(partial(scene, "box_pile"), 1.0 / 240.0, 300)
    found["box_pile: gyroscopic, single"] = Case(partial(scene, "box_pile", gyroscopic=True, contact="single"))
    found["joined"] = Case(joined)
    found["joined: sleep"] = Case(partial(joined, **SLEEP))
    found["relaxed"] = Case(relaxed)
    found["by frames"] = Case(by_frames)
    for path in sorted(FILES.glob("*/world.npz")):
        found[f"golden file of format {path.parent.name}"] = Case(partial(World.load, path), 1e-3, 100)
    return found
