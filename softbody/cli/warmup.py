"""Compiles the core ahead of its first use, by small worlds of each kind, side by side."""

from __future__ import annotations

import multiprocessing
import os
import warnings
from concurrent.futures import ProcessPoolExecutor

import softbody

# Soft bodies and boxes of the worlds that kernels are compiled for: what a world has none of is not compiled. The kind
# that takes longest comes first.
KINDS = ((1, 2), (2, 0), (0, 2), (1, 0))


def warm_up() -> None:
    """Fill Numba's disk cache with the machine code of all kinds of worlds, each in a process of its own."""
    workers = min(len(KINDS), os.cpu_count() or 1)
    with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")) as processes:
        list(processes.map(run_small_world, KINDS))


def run_small_world(kind: tuple[int, int]) -> None:
    """Take one step of a world of so many soft bodies and boxes."""
    soft, boxes = kind
    world = softbody.World()
    world.add_ground()
    for k in range(soft):
        world.add_soft_body(softbody.icosahedron(0.5), mass=1.0, stiffness=50.0, gas=1.0, position=(0.0, 0.0, 1.0 + k))
    for k in range(boxes):
        world.add_box((1.0, 1.0, 1.0), mass=1.0, position=(5.0, 0.0, 0.5 + 0.9 * k))
    if soft and boxes:  # what is the same for all kinds
        world.equilibrium(1e-3)
        world.energy()
        world.linear_momentum()
        world.angular_momentum()
        world.picture(size=(8, 6))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of contacts that are missing
        world.step(1e-4)
