"""Rigid boxes between contacts: they fall and they turn."""

from __future__ import annotations

import numpy as np

from softbody import World
from softbody.dynamics import rigid_boxes
from softbody.linalg import quaternion
from validation.answers import Answers
from validation.cases import random_orientations, rotation_matrix
from validation.check import Comparison, Misprint, Run, check
from validation.fault import Fault

FAMILY = "rigid boxes"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process
PIECE = "softbody.dynamics.rigid_boxes.advance_boxes"


@check(
    section="5.2",
    piece=PIECE,
    reference="closed form of the scheme",
    unit="of the way",
    kind="closed form",
    least=5,
    tolerance=1e-13,
    because="up to 1 000 additions to a position, each rounded at 1e-16 of it",
    faults=(
        Fault(
            "boxes moved by the velocity of the step's start, to a millionth",
            rigid_boxes.advance_boxes,
            "h_ * state_.box_velocity[i_, c_]"
            " → h_ * (state_.box_velocity[i_, c_] + (9.81e-6 * h_ if c_ == 2 else 0.0))",
        ),
    ),
    erratum=Misprint("E10", "x' = x + a t", "x' = x + v' t"),
)
def thrown_box(run: Run) -> Comparison:
    """A thrown box flies the parabola of Euler–Cromer.

    That is farther along g than the exact one by g h t / 2.
    """
    from references import printed

    rng, answers, misprinted = run.fresh_rng(), Answers(), []
    for _ in range(run.count(5, 30, 300)):
        gravity, start, speed = rng.normal(size=3), rng.normal(size=3), rng.normal(size=3)
        h, steps = rng.uniform(1e-3, 1e-2), int(rng.integers(1, 1000))
        world = World(gravity=gravity)
        box = world.add_box((1.0, 0.6, 0.3), 2.0, start, velocity=speed)
        world.step(h, steps)
        t = h * steps
        way = np.linalg.norm(start) + np.linalg.norm(speed) * t + 0.5 * np.linalg.norm(gravity) * t * t
        answers.add(box.position.copy(), start + speed * t + 0.5 * gravity * t * (t + h), float(way))
        position, velocity = start, speed
        for _ in range(steps):
            position, velocity = printed.moved_by_acceleration(position, velocity, gravity, h)
        misprinted.append(position)
    return answers.comparison(printed=np.array(misprinted))


@check(
    section="5.2",
    piece=PIECE,
    reference="Rodrigues' formula for the whole turn at once",
    unit="of the rotation matrix",
    kind="closed form",
    least=5,
    tolerance=1e-13,
    because="up to 1 000 products of quaternions, each rounded at 1e-16, and an angle of up to 50 rad",
    faults=(
        Fault(
            "a turn of first order",
            quaternion.from_rotation_vector,
            "s_ = sin(0.5 * angle_) / angle_\nreturn cos(0.5 * angle_), x_, y_, z_ → s_ = 0.5\nreturn 1.0, x_, y_, z_",
        ),
    ),
)
def spinning_box(run: Run) -> Comparison:
    """A box spinning at ω turns by |ω| t, whatever the steps."""
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(5, 50, 500)):
        start, spin = random_orientations(rng, 1)[0], 2.0 * rng.normal(size=3)
        h, steps = rng.uniform(1e-3, 1e-2), int(rng.integers(1, 1000))
        world = World(gravity=(0.0, 0.0, 0.0))
        box = world.add_box((1.0, 0.6, 0.3), 2.0, orientation=start, angular_velocity=spin)
        world.step(h, steps)
        wanted = turned_by(spin * h * steps) @ rotation_matrix(start)
        answers.add(rotation_matrix(box.orientation).ravel(), wanted.ravel())
    return answers.comparison()


def turned_by(rotation: np.ndarray) -> np.ndarray:
    """Return the matrix of the turn by |rotation| [rad] about it (Rodrigues 1840)."""
    angle = np.linalg.norm(rotation)
    x, y, z = rotation / angle
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k
