"""Jolt's boxes and soft bodies with gas, by way of Node (single precision).

Its gas pushes where a particle was, and its springs pull where it will be: what spins about its middle loses h a of its
spin a second, with h the length of an iteration and a the push of the gas, over mass and radius. It slows down the more
the longer its steps are, and no setting changes that.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from references.analytic import equilibrium_scale
from validation import effort
from validation.foreign import engine
from validation.subject import Boxes, GasBody, Motion, SoftMotion, SoftScene, swells_again

SETTINGS = {  # what was chosen against the defaults, and why
    "no damping, no sleeping, no speed limits": "boxes would stop by themselves, or fly no faster than 500 m/s",
    "no least speed of restitution (1 m/s)": "slow impacts are asked about as well",
    "gyroscopic forces on": "a body that turns freely is asked whether it keeps its angular momentum",
    "motion quality LinearCast": "fast boxes are asked whether they go through each other",
    "convex radius of boxes 0 (0.05 m)": "boxes are asked about, and corners that are not round",
    "gas: 100 and 200 steps of a breath, of one iteration (5), extrapolated": (
        "its iterations are shorter steps; its error is of first order, and below 1/400 single precision adds more"
    ),
    "gas at rest: half the critical damping, to 60 rad of its breathing": "what swings is not at rest",
}
CANNOT = {  # question → why it has no answer
    "boxes_overlap": "its adapter does not ask it so far",
    "points_in_mesh": "its adapter does not ask it so far",
}
PRECISION = "single"

SAMPLES = 100  # of a breath
REST = 60.0  # [rad] of breathing


def move_boxes(boxes: Boxes, step: float, steps: int, every: int) -> Motion:
    """Let boxes move."""
    rows = boxes._asdict()
    numbers = {name: float(rows.pop(name)) for name in ("gravity", "friction", "restitution")}
    numbers |= {"step": step, "steps": steps, "every": every, "iterations": effort.iterations(100) / 100}
    return Motion(**engine("jolt").ask("move_boxes", numbers, **rows))


def move_soft(scene: SoftScene, step: float, steps: int, every: int) -> SoftMotion:
    """Let bodies with gas move among boxes."""
    rows = scene.boxes._asdict()
    numbers = {name: float(rows.pop(name)) for name in ("gravity", "friction", "restitution")}
    numbers |= {"step": step, "steps": steps, "every": every, "iterations": effort.iterations(100) / 100}
    numbers |= {"substeps": effort.iterations(5), "drag": scene.drag}
    bodies = scene.bodies
    ends = {"particles": "vertices", "edge_start": "edges", "triangle_start": "triangles"}
    for start, name in ends.items():
        rows[start] = np.cumsum([0, *(len(getattr(body, name)) for body in bodies)])
        rows[name] = np.concatenate([getattr(body, name) for body in bodies])
    rows["vertex_velocity"] = np.concatenate(scene.velocity)
    for column, name in (("soft_mass", "mass"), ("stiffness", "stiffness"), ("gas", "gas")):
        rows[column] = np.array([getattr(body, name) for body in bodies])
    told = engine("jolt").ask("move_soft", numbers, **rows)
    cuts = np.cumsum([len(body.vertices) for body in bodies])[:-1]
    position, velocity = (tuple(np.split(told.pop(name), cuts, axis=1)) for name in ("vertices", "vertex_velocity"))
    return SoftMotion(position, velocity, Motion(**told))


def gas_volume(body: GasBody) -> float:
    """Return the volume at rest."""

    def settled(samples: int) -> float:
        volumes = _volumes(body, samples, steps=int(REST / (2.0 * np.pi) * samples), damping=body.frequency)
        return float(np.median(volumes[-20:]))

    return _extrapolated(settled)


def gas_period(body: GasBody, swing: float) -> float:
    """Return the time of a breath."""
    i, j = body.edges.T
    rest = np.linalg.norm(body.vertices[i] - body.vertices[j], axis=1)
    swollen = body._replace(vertices=equilibrium_scale(body.gas, body.stiffness * rest @ rest) * body.vertices)

    def breath(samples: int) -> float:
        volumes = _volumes(swollen, samples, steps=2 * samples, rate=swing * body.frequency, rest=rest)
        above = iter(volumes - volumes[:samples].mean())
        return 2.0 * np.pi / body.frequency / samples * swells_again(lambda: next(above), samples)

    return _extrapolated(breath)


def _extrapolated(answer: Callable[[int], float]) -> float:
    coarse, fine = (answer(round(SAMPLES * effort.finer() * samples)) for samples in (1.0, 2.0))
    return 2.0 * fine - coarse


def _volumes(
    body: GasBody, samples: int, steps: int, damping: float = 0.0, rate: float = 0.0, **rest: np.ndarray
) -> np.ndarray:
    numbers = {"stiffness": body.stiffness, "gas": body.gas, "mass": body.mass, "damping": damping, "rate": rate}
    numbers |= {"step": 2.0 * np.pi / body.frequency / samples, "steps": steps, "iterations": effort.iterations(1)}
    shape = {"vertices": body.vertices, "edges": body.edges, "triangles": body.triangles}
    return engine("jolt").ask("volumes", numbers, **shape, **rest)["volume"]
