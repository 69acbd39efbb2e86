"""Time to the first step of a new process, and memory per particle."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile

import softbody
from softbody.dynamics.soft_bodies import motion_of
from validation.record import Figure

# What a process of its own does: import the core, make a world, take one step.
FIRST_STEP = """
import json, time
start = time.perf_counter()
import softbody
imported = time.perf_counter()
world = softbody.World(threads={threads})
world.add_ground()
for k in range({balls}):
    world.add_soft_body(softbody.icosphere(3), 1.0, 200.0, 30.0, position=(0.0, 0.0, 1.0 + 2.1 * k))
for k in range({boxes}):
    world.add_box((1.0, 1.0, 1.0), 1.0, position=(5.0, 0.0, 0.5 + 1.1 * k))
world.step(1e-4)
print(json.dumps([imported - start, time.perf_counter() - imported]))
"""
STARTS = 5
# What is compiled from nothing, at level full: balls, boxes and threads, and how long it may take [s].
COLD = {
    "one ball": (1, 0, 1, 5.0),
    "one ball, on two threads": (1, 0, 2, 10.0),
    "balls and boxes, all that may touch": (2, 2, 1, 15.0),
    "the same on two threads": (2, 2, 2, 20.0),
}


def measure_startup(level: str) -> list[Figure]:
    """Return the times of imports and first steps [s], and memory [bytes]; from empty caches at level full only."""
    _first_step({})
    imports, steps = zip(*(_first_step({}) for _ in range(STARTS)))
    figures = [
        Figure("import of softbody, of which Numba is most", statistics.median(imports), "s"),
        Figure("first step of a soft body after that, machine code from the disk cache", statistics.median(steps), "s"),
    ]
    if level == "full":
        for what, (balls, boxes, threads, most) in COLD.items():
            if threads > (os.cpu_count() or 1):
                continue
            with tempfile.TemporaryDirectory() as empty:
                seconds = _first_step({"NUMBA_CACHE_DIR": empty}, balls, boxes, threads)[1]
            figures.append(Figure(f"first step with nothing compiled yet: {what}", seconds, "s", most))
    for precision in ("double", "single"):
        memory = bytes_per_particle(precision)
        what = f"memory of a soft body of 10 242 particles, {precision} precision"
        figures.append(Figure(what, memory, "bytes each", 500.0))
    return figures


def _first_step(environment: dict[str, str], balls: int = 1, boxes: int = 0, threads: int = 1) -> list[float]:
    """Return [import, first step] in seconds of a new process, for a world of so many bodies."""
    command = [sys.executable, "-c", FIRST_STEP.format(balls=balls, boxes=boxes, threads=threads)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=os.environ | environment)
    times: list[float] = json.loads(done.stdout)
    return times


def bytes_per_particle(precision: str) -> float:
    """Return what all arrays of a world of one soft body take, over its particles, memory for a run included."""
    world = softbody.World(precision=precision)
    world.add_soft_body(softbody.icosphere(5), 1.0, 200.0, 30.0)
    memory = motion_of(world.model.soft_particle_start, world.store.rings).memory
    parts = world.model, world.controls, world.store.rings, world.state, memory
    taken = sum(array.nbytes for part in parts for array in part if hasattr(array, "nbytes"))
    return taken / len(world.state.particle_position)
