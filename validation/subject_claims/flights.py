"""Boxes that nothing touches: how they fall, tumble and flip."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import ellipk

from validation.cases import random_orientations, rotation_matrix
from validation.check import Comparison, Run
from validation.subject import asks
from validation.subject_claims.boxes import NEWTON, STILL, Answer, G, boxes, momenta

FAMILY = "free flight"


@asks(
    "move_boxes",
    roundings=1000 * 2,
    reference=NEWTON,
    unit="of g t²/2",
    tolerance=1.001e-3,
    because="Euler's steps: t² becomes t (t ± h), t = 1000 h",
)
def parabola(run: Run, move: Answer) -> Comparison:
    """The centre of a box that is thrown and spins follows a parabola."""
    rng, measured, expected, scale = run.fresh_rng(), [], [], []
    for start in random_orientations(rng, run.count(6, 30, 300)):
        step, velocity = rng.uniform(1e-3, 5e-3), 3.0 * rng.normal(size=3)
        end = move(
            boxes(((1.0, 0.6, 0.3), 2.0, np.zeros(3), start, velocity, 3.0 * rng.normal(size=3)), gravity=G),
            step,
            1000,
            1000,
        )
        time = 1000.0 * step
        measured.append(end.position[-1, 0])
        expected.append(time * velocity - [0.0, 0.0, 0.5 * G * time**2])
        scale.append(0.5 * G * time**2)
    return Comparison(np.array(measured), np.array(expected), np.array(scale))


@asks(
    "move_boxes",
    roundings=6_000 * 4,
    reference="invariant: kinetic energy",
    kind="invariant",
    unit="of the energy before",
    tolerance=1e-3,
    because="a step of second order turns a box wrongly by (ω h)²/12 a radian at most, to and fro: ω h < 0.07",
)
def tumble_long(run: Run, move: Answer) -> Comparison:
    """A free box of three inertias tumbles for 100 s and keeps its energy."""
    rng, measured = run.fresh_rng(), []
    for start in random_orientations(rng, run.count(6, 20, 100)):
        size, spin = np.array([1.0, 0.6, 0.3]) * rng.uniform(0.8, 1.2, 3), rng.normal(size=3)
        spin *= rng.uniform(1.0, 4.0) / np.linalg.norm(spin)
        free = boxes((size, 1.0, np.zeros(3), start, np.zeros(3), spin))
        end = move(free, 1.0 / 60.0, 6_000, 500)
        before = momenta(free.orientation, free.velocity, free.spin, free.position, free)[6]
        frames = zip(end.orientation, end.velocity, end.spin, end.position)
        now = [momenta(*frame, free)[6] for frame in frames]
        measured.append(np.array(now) / before)
    return Comparison(np.array(measured), np.ones((len(measured), 12)), 12.0**0.5)


@asks(
    "move_boxes",
    roundings=4_000 * 4,
    reference="closed form: Euler's equations by Jacobi's elliptic functions",
    unit="of the time",
    tolerance=1e-3,
    because="a step of second order: (ω h)² = 1.6e-4, and as much of the logarithm in the closed form",
)
def flip(run: Run, move: Answer) -> Comparison:
    """A box that spins about its middle axis flips in its time.

    From flip to flip, by Jacobi 2 K(m) / λ, for 10 to 30 % of spin about another axis.
    """
    rng, measured, expected = run.fresh_rng(), [], []
    for _ in range(run.count(6, 20, 100)):
        size = np.array([1.0, 0.6, 0.25]) * rng.uniform(0.9, 1.1, 3)
        low, middle, high = (size @ size - size**2) / 12.0
        rate, off = 5.0, rng.uniform(0.1, 0.3)
        spin = rate * np.array([off, 1.0, 0.0])
        energy2, momentum2 = low * spin[0] ** 2 + middle * rate**2, (low * spin[0]) ** 2 + (middle * rate) ** 2
        grows, wanes = momentum2 - low * energy2, high * energy2 - momentum2
        period = np.nan
        if momentum2 < middle * energy2:  # about the long axis: the roles of the two others change
            square = (middle - low) * wanes / (low * middle * high)
            period = 2.0 * ellipk((high - middle) * grows / ((middle - low) * wanes)) / np.sqrt(square)
        else:
            square = (high - middle) * grows / (low * middle * high)
            period = 2.0 * ellipk((middle - low) * wanes / ((high - middle) * grows)) / np.sqrt(square)
        steps = int(2.6 * period / 0.02) * 8
        way = move(boxes((size, 1.0, np.zeros(3), STILL, np.zeros(3), spin)), 2.5e-3, steps, 8)
        about = [(rotation_matrix(q).T @ w)[1] for q, w in zip(way.orientation[:, 0], way.spin[:, 0])]
        times = CubicSpline(0.02 * np.arange(len(about)), about).roots(extrapolate=False)
        measured.append(times[1] - times[0] if len(times) > 1 else 0.0)
        expected.append(period)
    return Comparison(np.array(measured), np.array(expected), np.array(expected))
