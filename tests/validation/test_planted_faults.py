"""Every claim can fail: damage the core under it, and it turns red.

Each fault is one edit to a copy of the core. The claims named with it are judged on the damaged copy by the real
command, in a process of their own, and must fail; on the sound core they hold (`make report`).
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from validation.check import all_checks

ROOT = Path(__file__).parents[2]


class Fault(NamedTuple):
    """One edit: the first `right` in `file` becomes `wrong`, and the claims in `red` must fail."""

    file: str
    right: str
    wrong: str
    red: tuple[str, ...]


FAULTS = {
    "volume off by 1e-12": Fault(
        "geometry/polyhedron.py",
        "return six_volumes / 6.0",
        "return six_volumes / 6.0 * (1.0 + 1e-12)",
        (
            "volume.closed_forms",
            "volume.volume_of_meshes",
            "volume.volume_does_not_depend_on_the_origin",
            "pressure.ideal_gas_law",
        ),
    ),
    "volume summed about the origin": Fault(
        "geometry/polyhedron.py",
        "origin = load(vertices, triangles[0, 0])",
        "origin = (0.0, 0.0, 0.0)",
        ("volume.volume_far_away",),
    ),
    "area off by 1e-12": Fault(
        "geometry/triangle.py",
        "return norm(area_vector(a, b, c))",
        "return norm(area_vector(a, b, c)) * (1.0 + 1e-12)",
        ("volume.area_of_meshes",),
    ),
    "centroid off by 1e-10": Fault(
        "geometry/polyhedron.py", "0.25 / six_volumes", "0.2500000001 / six_volumes", ("volume.centroid_of_meshes",)
    ),
    "inertia off by 1e-9": Fault(
        "geometry/polyhedron.py",
        "mass / (20.0 * six_volumes)",
        "mass / (20.00000001 * six_volumes)",
        ("volume.inertia_of_meshes",),
    ),
    "inertia of a box with two axes exchanged": Fault(
        "geometry/box.py",
        "(y2 + z2, x2 + z2, x2 + y2)",
        "(x2 + z2, y2 + z2, x2 + y2)",
        ("volume.inertia_of_boxes", "impulse.one_impact_by_bullet"),
    ),
    "pressure force off by 1e-9": Fault(
        "dynamics/pressure.py",
        "pressure / 3.0",
        "pressure / 3.0 * (1.0 + 1e-9)",
        (
            "pressure.virial_identity",
            "pressure.equilibrium_scale",
            "pressure.force_is_gradient_of_volume",
            "integrators.breathing_motion",
        ),
    ),
    "spring force over the rest length": Fault(
        "dynamics/springs.py",
        "(length - rest_length[e]) / length",
        "(length - rest_length[e]) / rest_length[e]",
        ("pressure.shape_at_rest", "integrators.observed_order"),
    ),
    "springs pull one end harder by 1e-9": Fault(
        "dynamics/springs.py",
        "scale(-1.0, pull)",
        "scale(-1.000000001, pull)",
        ("pressure.no_net_force_or_torque", "integrators.momentum"),
    ),
    "a wrong weight in the paper's integrator": Fault(
        "dynamics/integrators.py",
        "weight = 1.0 if stage == 3 else 2.0",
        "weight = 1.000000001 if stage == 3 else 1.9999999995",
        ("integrators.amplification", "integrators.damping"),
    ),
    "gravity off by 1e-9": Fault(
        "dynamics/soft.py", "+ model.gravity[c]", "+ model.gravity[c] * (1.0 + 1e-9)", ("integrators.free_fall",)
    ),
    "boxes moved by the velocity of the step's start, to a millionth": Fault(
        "dynamics/rigid.py",
        "state.box_position[i, c] += h * state.box_velocity[i, c]",
        "state.box_position[i, c] += h * (state.box_velocity[i, c] - 1e-6 * h * model.gravity[c])",
        ("rigid.thrown_box",),
    ),
    "a turn of first order": Fault(
        "quaternion.py",
        "s = sin(0.5 * angle) / angle\n    return cos(0.5 * angle), s",
        "s = 0.5\n    return 1.0, s",
        ("rigid.spinning_box",),
    ),
    "speed gained off by 1e-9": Fault(
        "dynamics/integrators.py",
        "next_velocity[i, c] = velocity[i, c] + h / 6.0 * total[i, c]",
        "next_velocity[i, c] = velocity[i, c] + h / 6.000000001 * total[i, c]",
        ("integrators.speed_of_a_fall",),
    ),
    "the last of fifteen axes left out": Fault(
        "collision/sat.py", "6 if paper_axes else 15", "6 if paper_axes else 14", ("sat.random_pairs", "sat.depth")
    ),
    "one box of three percent less reach": Fault(
        "collision/sat.py",
        "- reach_a - reach_b",
        "- reach_a - 0.97 * reach_b",
        ("sat.paper_axes_never_miss", "sat.invariance"),
    ),
    "boxes grown by 1e-12": Fault(
        "collision/sat.py",
        "- reach_a - reach_b",
        "- reach_a - reach_b - 1e-12",
        ("sat.near_touching_pairs",),
    ),
    "a ray that counts a vertex on its path for both edges": Fault(
        "geometry/polyhedron.py",
        "(a[1] <= p[1]) == (b[1] <= p[1])",
        "(a[1] < p[1]) == (b[1] <= p[1])",
        ("containment.stacked_copies",),
    ),
    "a ray that misses steep triangles": Fault(
        "geometry/polyhedron.py",
        "    if p[2] < min(a[2], b[2], c[2]):",
        "    if abs(cross(sub(b, a), sub(c, a))[2]) < 1e-3:\n        return False\n"
        "    if p[2] < min(a[2], b[2], c[2]):",
        ("containment.random_points_by_trimesh", "containment.random_points_by_winding_number"),
    ),
    "a tolerance of 1e-12 m³ in the ray": Fault(
        "geometry/polyhedron.py",
        "(dot(sub(a, p), n) > 0.0) == (n[2] > 0.0)",
        "(dot(sub(a, p), n) > 1e-12) == (n[2] > 0.0)",
        ("containment.points_near_the_surface",),
    ),
    "a convex test that forgives a hundredth": Fault(
        "geometry/polyhedron.py", "face >= 0 and depth >= 0.0", "face >= 0 and depth >= -0.01", ("containment.convex",)
    ),
    "two corners of a tetrahedron exchanged": Fault(
        "geometry/tetrahedron.py",
        "tetrahedron_volume(a, b, p, d) / whole",
        "tetrahedron_volume(b, a, p, d) / whole",
        ("containment.tetrahedra",),
    ),
    "flat triangles contain points": Fault(
        "geometry/triangle.py", "if dot(n, n) == 0.0:", "if dot(n, n) < 0.0:", ("containment.triangles",)
    ),
    "restitution off by 1e-9": Fault(
        "collision/impulse.py",
        "-(1.0 + restitution)",
        "-(1.000000001 + restitution)",
        ("impulse.one_impact_by_bullet", "impulse.one_impact_by_closed_form", "impulse.restitution_and_energy"),
    ),
    "the second body feels 1e-9 less": Fault(
        "collision/impulse.py",
        "scale(-j, normal)",
        "scale(-j * (1.0 - 1e-9), normal)",
        ("impulse.impact_conserves_momentum",),
    ),
    "points that touch without their spin": Fault(
        "collision/impulse.py",
        "return add(load(bodies.velocity, body), cross(load(bodies.angular_velocity, body), arm))",
        "return load(bodies.velocity, body)",
        ("impulse.spinning_boxes",),
    ),
    "another order in the denominator": Fault(
        "collision/impulse.py",
        "dot(direction, cross(spin, arm))",
        "dot(direction, cross(arm, spin))",
        ("impulse.denominator",),
    ),
    "an inertia that does not turn with the body": Fault(
        "quaternion.py",
        "return rotate(q, multiply(diagonal, rotate_inverse(q, a)))",
        "return multiply(diagonal, a)",
        ("impulse.turned_inertia",),
    ),
}


def verdicts_on(folder: Path, claims: tuple[str, ...]) -> dict[str, str]:
    """Judge claims on the core that lies in `folder`; return their verdicts."""
    command = [sys.executable, "-m", "validation", "--level", "quick", "--no-timings", "--jobs", "1", "--out", "out"]
    for claim in claims:
        command += ["-k", claim]
    # The working folder comes first on the path: the core is the copy there, everything else the repository's.
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=600)
    assert done.returncode == 1, done.stderr
    report = json.loads((folder / "out" / "report.json").read_text(encoding="utf-8"))
    return {claim["id"]: claim["verdict"] for claim in report["claims"] if claim["id"] in claims}


@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_turns_its_claims_red(name: str, tmp_path: Path) -> None:
    fault = FAULTS[name]
    copy = tmp_path / "softbody"
    shutil.copytree(ROOT / "softbody", copy, ignore=shutil.ignore_patterns("__pycache__"))
    source = (copy / fault.file).read_text(encoding="utf-8")
    assert fault.right in source, f"{fault.file} no longer holds {fault.right!r}: plant the fault elsewhere"
    (copy / fault.file).write_text(source.replace(fault.right, fault.wrong, 1), encoding="utf-8")
    assert verdicts_on(tmp_path, fault.red) == dict.fromkeys(fault.red, "fails")


def test_every_claim_has_a_planted_fault() -> None:
    covered = {claim for fault in FAULTS.values() for claim in fault.red}
    assert covered == set(all_checks())
