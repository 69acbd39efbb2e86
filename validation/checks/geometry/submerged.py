"""Claims that the part of a mesh below a level is cut off exactly."""

from __future__ import annotations

import numpy as np

import softbody
from softbody.geometry import submerged
from validation.answers import Answers
from validation.check import Comparison, Run, check
from validation.checks.geometry.cases import longest_side, random_meshes
from validation.fault import Fault

FAMILY = "volume, centroid, inertia"


@check(
    section="7",
    piece="softbody.geometry.submerged.submerged_part",
    reference="CGAL's exact half-space, by libigl; Manifold's own cut, volume and lid; sums over what they leave",
    engines=("igl", "manifold3d"),
    unit="of the size, and how far away it is",
    tolerance=1e-14,
    because="rounding of some 1 300 terms on all sides: 6.2e-15 at worst of three seeds, of areas by six sizes²; the "
    "two judges differ by 2e-16 in volumes",
    faults=(
        Fault("triangles that are cut in half", submerged._cut_off, "a_ / (a_ - b_), a_ / (a_ - c_) → 0.5, 0.5"),
        Fault("the wet corner where the dry one is", submerged.wet_part, "at_ > 0.0 → at_ < 0.0"),
        Fault("weights of the corner before", submerged.wet_part, "(3 - lone_) % 3 → (4 - lone) % 3"),
        Fault("a depth that is one", submerged._whole, "(total_ + a_, t_, u_) → (total_, total_, total_)"),
        Fault("half of the squares", submerged._cut_off, "part_ * a_ * a_ / 6.0 → part * a * a / 12.0"),
        Fault("a surface that is wet all over", submerged._cut_off, "scale(part_ / 3.0, t_) → scale(1.0 / 3.0, t_)"),
    ),
)
def cut_at_a_level(run: Run) -> Comparison:
    """What is below a level is cut off exactly.

    Volume, its moments, and the wet area, of meshes of every kind. The level is anywhere, and where it touches: through
    a vertex, and along faces.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 6, 60)):
        for kind, mesh in random_meshes(1, rng):
            z, size = mesh.vertices[:, 2], longest_side(mesh.vertices)
            for where, level in {
                "anywhere": rng.uniform(z.min(), z.max()),
                "through a vertex": float(rng.choice(z)),
                "all of it": z.max() + 0.1 * size,
            }.items():
                _compare(answers, mesh, level, f"{kind}, {where}")
        for level in (-0.5, -0.25, 0.0, 0.25, 0.5):
            _compare(answers, softbody.box((1.0, 1.0, 1.0), 4), level, "along faces", has_area=False)
    return answers.comparison()


def _compare(answers: Answers, mesh: softbody.Mesh, level: float, kind: str, has_area: bool = True) -> None:
    """Compare what is below a level with each judge; faces in it are wet or not as one likes."""
    from references import floating, manifold3d

    size, judged = longest_side(mesh.vertices), floating.wet(mesh.vertices, mesh.triangles, level)
    other = manifold3d.below(mesh.vertices, mesh.triangles, level)
    found = submerged.submerged_part(mesh.vertices, mesh.triangles, level)
    far = max(size, np.abs(mesh.vertices).max())
    scales = size * far * np.array([6.0, size, *4 * [size * size]])
    ours = [found.wet_area * has_area, found.volume, *found.moment, found.depth]
    asked = {"level, size, farthest": [level, size, far]}
    for by, area, volume, moment in (
        ("CGAL", judged.area, judged.volume, judged.volume * judged.centre),
        ("Manifold", other.area, other.volume, other.moment),
    ):
        theirs = np.array([area * has_area, volume, *moment, level * volume - moment[2]])
        answers.add(ours / scales, theirs / scales, 1.0, f"{kind}, {by}", **asked)
