"""How long until the first step of a new process, and how much memory does a particle take?"""

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

# What a process of its own does: import the core, make a soft body, take one step.
FIRST_STEP = """
import json, time
start = time.perf_counter()
import softbody
imported = time.perf_counter()
world = softbody.World()
world.add_soft_body(softbody.icosphere(3), 1.0, 200.0, 30.0)
world.step(1e-4)
print(json.dumps([imported - start, time.perf_counter() - imported]))
"""
STARTS = 5


def measure_startup(level: str) -> list[Figure]:
    """Return the times of imports and first steps [s], from an empty cache at level full only, and memory [bytes]."""
    _first_step({})
    imports, steps = zip(*(_first_step({}) for _ in range(STARTS)))
    figures = [
        Figure("import of softbody, of which Numba is most", statistics.median(imports), "s"),
        Figure("first step of a soft body after that, machine code from the disk cache", statistics.median(steps), "s"),
    ]
    if level == "full":
        with tempfile.TemporaryDirectory() as empty:
            figures.append(
                Figure("the same with nothing compiled yet", _first_step({"NUMBA_CACHE_DIR": empty})[1], "s")
            )
    for precision in ("double", "single"):
        memory = bytes_per_particle(precision)
        figures.append(
            Figure(f"memory of a soft body of 10 242 particles, {precision} precision", memory, "bytes each")
        )
    return figures


def _first_step(environment: dict[str, str]) -> list[float]:
    """Return [import, first step] in seconds of a new process."""
    command = [sys.executable, "-c", FIRST_STEP]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=os.environ | environment)
    times: list[float] = json.loads(done.stdout)
    return times


def bytes_per_particle(precision: str) -> float:
    """Return what all arrays of a world of one soft body take, over its particles, memory for a run included."""
    world = softbody.World(precision=precision)
    world.add_soft_body(softbody.icosphere(5), 1.0, 200.0, 30.0)
    memory = motion_of(world.model.soft_particle_start, world.rings).memory
    parts = world.model, world.controls, world.rings, world.state, memory
    taken = sum(array.nbytes for part in parts for array in part if hasattr(array, "nbytes"))
    return taken / len(world.state.particle_position)
