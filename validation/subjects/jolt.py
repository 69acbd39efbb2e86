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
from validation.subject import NO_BOXES, Boxes, GasBody, Motion, SoftMotion, SoftScene, swells_again

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
    return _moved(scene, step, steps, every, effort.iterations(5))


def gas_volume(body: GasBody) -> float:
    """Return the volume at rest."""
    still = SoftScene((body,), (np.zeros_like(body.vertices),), NO_BOXES, drag=body.frequency)

    def settled(samples: int) -> float:
        return float(np.median(_volumes(still, samples, steps=int(REST / (2.0 * np.pi) * samples))[-20:]))

    return _extrapolated(settled)


def gas_period(body: GasBody, swing: float) -> float:
    """Return the time of a breath."""
    i, j = body.edges.T
    rest = np.linalg.norm(body.vertices[i] - body.vertices[j], axis=1)
    swollen = equilibrium_scale(body.gas, body.stiffness * rest @ rest) * body.vertices
    swelling = SoftScene((body._replace(vertices=swollen),), (swing * body.frequency * swollen,), NO_BOXES)

    def breath(samples: int) -> float:
        volumes = _volumes(swelling, samples, steps=2 * samples, rest=rest)
        above = iter(volumes - volumes[:samples].mean())
        return 2.0 * np.pi / body.frequency / samples * swells_again(lambda: next(above), samples)

    return _extrapolated(breath)


def _extrapolated(answer: Callable[[int], float]) -> float:
    coarse, fine = (answer(round(SAMPLES * effort.finer() * samples)) for samples in (1.0, 2.0))
    return 2.0 * fine - coarse


def _volumes(scene: SoftScene, samples: int, steps: int, **rest: np.ndarray) -> np.ndarray:
    """Return the volume (steps,) of the only body after each step, of which so many are a breath."""
    (body,) = scene.bodies
    step = 2.0 * np.pi / body.frequency / samples
    corners = _moved(scene, step, steps, 1, effort.iterations(1), **rest).position[0][:, body.triangles]
    a, b, c = corners.transpose(2, 0, 1, 3)
    return np.asarray((a * np.cross(b, c)).sum(axis=(1, 2)) / 6.0)


def _moved(scene: SoftScene, step: float, steps: int, every: int, substeps: int, **rest: np.ndarray) -> SoftMotion:
    """Let bodies move among boxes; `rest` (e,) are rest lengths of the edges of an only body, if not as it lies."""
    rows = scene.boxes._asdict()
    numbers = {name: float(rows.pop(name)) for name in ("gravity", "friction", "restitution")}
    numbers |= {"step": step, "steps": steps, "every": every, "iterations": effort.iterations(100) / 100}
    numbers |= {"substeps": substeps, "drag": scene.drag}
    bodies = scene.bodies
    ends = {"particles": "vertices", "edge_start": "edges", "triangle_start": "triangles"}
    for start, name in ends.items():
        rows[start] = np.cumsum([0, *(len(getattr(body, name)) for body in bodies)])
        rows[name] = np.concatenate([getattr(body, name) for body in bodies])
    rows["vertex_velocity"] = np.concatenate(scene.velocity)
    for column, name in (("soft_mass", "mass"), ("stiffness", "stiffness"), ("gas", "gas")):
        rows[column] = np.array([getattr(body, name) for body in bodies])
    told = engine("jolt").ask("move_soft", numbers, **rows, **rest)
    cuts = np.cumsum([len(body.vertices) for body in bodies])[:-1]
    position, velocity = (tuple(np.split(told.pop(name), cuts, axis=1)) for name in ("vertices", "vertex_velocity"))
    return SoftMotion(position, velocity, Motion(**told))
