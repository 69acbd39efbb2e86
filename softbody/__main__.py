"""Compiles the core ahead of its first use: `python -m softbody warmup`."""

from __future__ import annotations

import sys
import warnings
from time import perf_counter

import softbody


def warm_up() -> None:
    """Run a small world with every kind of body, so that all its machine code lies in Numba's disk cache."""
    world = softbody.World()
    world.add_ground()
    world.add_soft_body(softbody.icosahedron(0.5), mass=1.0, stiffness=50.0, gas=1.0, position=(0.0, 0.0, 1.0))
    world.equilibrium(1e-3)
    for height in (0.5, 1.4):
        world.add_box((1.0, 1.0, 1.0), mass=1.0, position=(5.0, 0.0, height))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of contacts that are missing
        world.step(1e-4)
    world.energy()
    world.linear_momentum()
    world.angular_momentum()


def main() -> int:
    """Return 0, or 2 for wrong usage."""
    if sys.argv[1:] != ["warmup"]:
        print("usage: python -m softbody warmup", file=sys.stderr)
        return 2
    start = perf_counter()
    warm_up()
    print(f"machine code is ready ({perf_counter() - start:.1f} s)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
