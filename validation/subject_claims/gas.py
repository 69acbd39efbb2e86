"""Bodies of springs with gas inside, at rest and breathing."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import softbody
from references import analytic
from validation.check import Comparison, Run
from validation.subject import GasBody, asks

FAMILY = "bodies with gas"
Answer = Callable  # the function of the subject that is asked


SOLIDS = {name: getattr(softbody, name)() for name in ("tetrahedron", "octahedron", "icosahedron")}


def inflated(run: Run, count: int) -> list[tuple[str, GasBody, float]]:
    """Return (kind, body, rest) of regular solids that gas stretches by 5 to 50 %; rest: the scale then."""
    rng, found = run.fresh_rng(), []
    for _ in range(count):
        for kind, unit in SOLIDS.items():
            mesh = unit.scaled(10.0 ** rng.uniform(-1.0, 1.0))
            stiffness, mass, scale = (
                10.0 ** rng.uniform(0.0, 4.0),
                10.0 ** rng.uniform(-1.0, 1.0),
                rng.uniform(1.05, 1.5),
            )
            i, j = mesh.edges.T
            rest_squared = float(stiffness * ((mesh.vertices[i] - mesh.vertices[j]) ** 2).sum())
            gas = (scale**2 - scale) * rest_squared / 3.0
            inertia = mass / len(mesh.vertices) * float((mesh.vertices**2).sum())
            frequency = float(analytic.breathing_frequency(gas, rest_squared, inertia))
            parts = mesh.vertices, mesh.edges, mesh.triangles
            found.append((kind, GasBody(*parts, stiffness, gas, mass, frequency), scale))
    return found


@asks(
    "gas_volume",
    roundings=1_000,
    reference="closed form",
    unit="of the volume",
    tolerance=5e-5,
    because="that of the same claim about Bullet and the core; the core is at 1e-12",
)
def rest(run: Run, volume: Answer) -> Comparison:
    """A regular solid with springs and gas comes to rest at λ³ of its volume, λ² − λ = 3nRT / k Σ l0²."""
    measured, expected, kinds = [], [], []
    for kind, body, scale in inflated(run, run.count(2, 10, 100)):
        size = float(np.linalg.norm(body.vertices[0]))
        measured.append(volume(body))
        expected.append(analytic.regular_solid_volume(kind, size * scale))
        kinds.append(kind)
    return Comparison(measured, expected, np.array(expected), kinds)


@asks(
    "gas_period",
    roundings=1_000,
    reference="closed form of small oscillations; they are of 1 % of the size",
    tolerance=2.5e-4,
    because="that of the same claim about Bullet and the core; 1e-4 of it is that the swing is not small",
)
def breathe(run: Run, period: Answer) -> Comparison:
    """A regular solid with springs and gas breathes with the period of its closed form."""
    measured, expected, kinds = [], [], []
    for kind, body, _ in inflated(run, run.count(2, 10, 100)):
        measured.append(period(body, 0.01))
        expected.append(2.0 * np.pi / body.frequency)
        kinds.append(kind)
    return Comparison(measured, expected, np.array(expected), kinds)
