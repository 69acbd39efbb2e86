"""What would a validation run leave behind? A made-up record, as odd as a real one may become."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from validation.record import (
    FAILS,
    HOLDS,
    NOT_RUN,
    Arbitration,
    Behaviour,
    Case,
    ClaimRecord,
    Distribution,
    Erratum,
    Goal,
    Group,
    Report,
    Setting,
    Standing,
    Timing,
)

FAMILIES = {
    "Volume and mass": ("volume", "softbody.geometry.polyhedron", "trimesh", ("trimesh",)),
    "Springs and gas": ("springs", "softbody.dynamics.reference_forces", "finite differences of the energy", ()),
    "Integrators": ("integrators", "softbody.dynamics.integrators", "SciPy DOP853", ("scipy",)),
    "Rigid motion": ("rigid", "softbody.dynamics.rigid_boxes", "PyBullet", ("pybullet",)),
    "Box against box": ("sat", "softbody.collision.boxes.sat_boxes", "FCL", ("fcl",)),
    "Point in a body": ("inside", "softbody.geometry.polyhedron", "exact arithmetic", ()),
    "Impulses": ("impulse", "softbody.collision.impulse", "conservation laws", ()),
}
SENTENCES = (
    "The volume of a closed mesh is that of the tetrahedra under its faces, wherever the origin lies",
    "Forces are minus the gradient of the energy",
    "A freely spinning box keeps its angular momentum over ten thousand steps",
    "Depth and normal of two overlapping boxes are those of an independent engine",
    "Bodies part with the relative velocity that the restitution asks for",
)
MISPRINTS = {
    25: ("E10", "x' = x + a t", "x' = x + v' t"),
    9: ("E2", "v01 from linear velocities only", "v + ω × r of both bodies"),
    17: ("E11", "SAT with face normals only", "face normals and edge × edge"),
    3: ("E20", "parity counts every hit", "shared edges and vertices once (half-open rule)"),
}


def distribution_of(errors: np.ndarray) -> Distribution:
    """Return what the record holds of some errors."""
    positive = np.log10(errors[errors > 0])
    quantiles = {q: float(np.quantile(errors, float(q))) for q in ("0", "0.5", "0.9", "0.99", "1")}
    if len(positive) == 0:
        return Distribution(quantiles, len(errors), [], [])
    counts, edges = np.histogram(positive, np.linspace(positive.min() - 0.05, positive.max() + 0.05, 41))
    return Distribution(quantiles, int((errors == 0).sum()), edges.tolist(), counts.tolist())


def make_claim(
    i: int, errors: np.ndarray, /, tolerance: float | None = 1e-12, unit: str = "relative", **changes: object
) -> ClaimRecord:
    """Return the record of a claim with such errors; `changes` overrule its fields."""
    family, (name, piece, reference, engines) = list(FAMILIES.items())[i % len(FAMILIES)]
    value = float(errors.sum() if unit == "disagreements" else errors.max())
    thirds = [part for part in np.array_split(errors, 3) if len(part)]
    labels = ("icosphere 642", "torus 1 : 0.4, moved by (5, 5, 5)", "rods 1 : 1 : 20")
    worst = [part.sum() if unit == "disagreements" else part.max() for part in thirds]
    fields: dict = {
        "id": f"{name}.{('closed_forms', 'random_bodies', 'long_runs', 'degenerate_cases')[i % 4]}_{i}",
        "family": family,
        "claim": SENTENCES[i % len(SENTENCES)],
        "section": ("5.1", "§4.2, §10.8", "3")[i % 3],
        "piece": piece,
        "reference": reference,
        "engines": list(engines),
        "unit": unit,
        "value": value,
        "tolerance": tolerance,
        "because": "the rounding of a sum of 1280 terms, and a factor of 10",
        "detail": "Of a solid with 1280 faces; those that are flat are left out.",
        "faults": [f"a sign wrong in face {i}", 'a body " & <later>'] if i % 4 else [],
        "n": len(errors),
        "seed": 20080101,
        "verdict": HOLDS if value <= (tolerance or 0.0) else FAILS,
        "why": None
        if value <= (tolerance or 0.0)
        else f"{(errors > (tolerance or 0.0)).sum()} of {len(errors)} exceed the tolerance",
        "seconds": 0.37 * (i + 1),
        "errors": distribution_of(errors),
        "groups": [
            Group(label, len(part), float(np.median(part)), float(np.quantile(part, 0.99)), float(w))
            for label, part, w in zip(labels, thirds, worst)
        ],
        "notes": ["skipped 12 pairs that touch without overlapping: the reference calls them either way"][: i % 2],
    }
    return ClaimRecord(**(fields | changes))


def make_report(n: int = 40) -> Report:
    """Return a report of n claims: most hold, some fail, were not run, count, or correct the paper."""
    random = np.random.default_rng(7)
    claims = []
    for i in range(n):
        size = int(random.choice([60, 2_000, 20_000]))
        errors = 10.0 ** random.normal(random.uniform(-16.5, -14), random.uniform(0.2, 0.7), size)
        if i % 3 == 0:
            errors[random.random(size) < 0.2] = 0.0
        if i % 9 == 4:
            claims.append(
                make_claim(i, (random.random(size) < (0.01 if i == 13 else 0)).astype(float), 0.0, "disagreements")
            )
        elif i in (10, 24, 38):
            missing = {"value": None, "n": 0, "errors": None, "groups": [], "verdict": NOT_RUN, "seconds": 0.0}
            claims.append(make_claim(i, errors, **missing, why="pybullet is not installed"))
        elif i == 20:
            claims.append(make_claim(i, errors * 3e4, 1e-12, "m/s"))
        elif i == 8:
            claims.append(make_claim(i, np.zeros(500), 0.0, "bits"))
        else:
            claims.append(
                make_claim(i, errors, 10.0 ** random.integers(-12, -8), random.choice(["relative", "m", "rad"]))
            )
        if i in MISPRINTS and claims[-1].errors:
            claims[-1].erratum = Erratum(*MISPRINTS[i], 2.4, 0.031, 0.107)
    wrong = Case(7, 1.0, 1.0, [True], [False], "next to edges", {"point": [0.1, 0.2, 0.30000000000000004]}, 1)
    claims[4].arbitrations = [
        Arbitration(
            "exact arithmetic", 12, 0.0, [Standing("softbody", 60, 0, 0.0), Standing("FCL", 60, 12, 1.0, wrong)]
        )
    ]
    claims.sort(key=lambda claim: list(FAMILIES).index(claim.family))
    sizes = (642, 2562, 10242, 40962, 163842)
    timings = [
        Timing(table, name, size, "things", "thing and step", cost, cost * 0.9, cost * 1.2, 40, *ratios)
        for table in ("A step", "A query")
        for k, size in enumerate(sizes)
        for name, cost, ratios in (
            ("ours", 14.0 * (1 + k / 3), ()),
            ("theirs", 39.0 * (1 + k / 3), (2.79, 2.5, 3.01)),
        )
    ]
    return Report(
        level="standard",
        seed=20080101,
        created="2025-11-21T06:44:10+00:00",
        seconds=151.4,
        softbody_version="0.1.0",
        revision="ab754e8c0ffe+",
        environment={"Python": "CPython 3.11.9", "system": "Linux x86_64", "processor": "AMD EPYC 9654", "cores": "2"},
        engines={"numpy": "2.1.0", "numba": "0.60.0", "pybullet": None, "fcl": "0.7.0.8", "trimesh": "4.4.1"},
        claims=claims,
        settings=[Setting("fcl", "no contacts", "with them it misses what just touches")],
        timings=[*timings, Timing("A scene", "ours", 648, "particles", "simulated second", 1.6e8, 1.5e8, 1.7e8, 40)],
        goals=[
            Goal("A step", "ours against theirs, to 10 242 things", 2.0, True, "met", 2.8, 2.5, 3.1, "642 things"),
            Goal("A step", "ours against others", 30.0, True, "missed", 21.0, 20.0, 22.0, "2 562 things"),
            Goal("A step", "growth of ours", 1.1, False, "met", 1.05, None, None, "642 to 163 842 things"),
            Goal("A scene", "ours against the clock", 8.0, True, "too close to call", 8.1, 7.9, 8.3, "648 particles"),
            Goal("A query", "ours against somebody else", 10.0, True, "not measured"),
        ],
        behaviours=[
            Behaviour("2: rolling torus", "defaults", 3.0, 0.0, 0.0001, 0.007, 1.0, 12.0),
            Behaviour("2: rolling torus", "the paper's own", 3.0, 0.021, 0.094, 1.0, 0.8, 14.0),
        ],
    )


@pytest.fixture
def report() -> Report:
    """A report of 40 claims of every kind."""
    return make_report()


@pytest.fixture
def report_of() -> Callable[[int], Report]:
    """Make a report of so many claims."""
    return make_report


@pytest.fixture
def claim_of() -> Callable[..., ClaimRecord]:
    """Make a claim of given errors."""
    return make_claim
