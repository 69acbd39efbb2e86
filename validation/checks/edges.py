"""How deep is an edge of a soft body in a box, and which way is out?"""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from softbody.collision import edge_box
from validation.cases import random_orientations
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "soft bodies that collide"


@check(
    family=FAMILY,
    claim="How deep an edge goes through a box, the shortest way out, and where the two touch when it has gone that"
    " way, or, if that was beyond the box, where it comes in: edges through sides, faces and the middle, and aside.",
    section="beyond the paper",
    piece="softbody.collision.edge_box.edge_in_box",
    reference="the nearest facet of their Minkowski difference, by Qhull; the surface of the box",
    kind="third-party library",
    engines=("scipy",),
    unit="of the size, of a unit vector",
    tolerance=2e-13,
    because="Qhull's normals of facets with corners that lie close: 7.1e-15 at worst of three seeds at full",
    detects="a direction that is not tried, a depth along a vector that is no unit, a place on the wrong side",
    faults=(
        Fault("one axis twice", edge_box.edge_in_box, "half[1] * abs(across_[1])", "half[1] * abs(across[0])"),
        Fault("the nearer side of the box", edge_box.edge_in_box, "normal_[2] > 0.0", "normal[2] < 0.0"),
        Fault(
            "lengths that are squares",
            edge_box.edge_in_box,
            "dot(cross(sub(corner, a), direction), across_) / (length_ * length_)",
            "dot(cross(sub(corner, a), direction), across) / length",
        ),
        Fault(
            "the face that is farther off",
            edge_box.edge_in_box,
            "1.0 if up_ < down_ else -1.0",
            "1.0 if up > down else -1.0",
        ),
    ),
)
def edges_in_a_box(run: Run) -> Comparison:
    rng, corners = run.fresh_rng(), np.stack(np.meshgrid(*[(-0.5, 0.5)] * 3), axis=-1).reshape(-1, 3)
    measured, expected, kinds = [], [], []
    for _ in range(run.count(150, 1_500, 15_000)):
        size, place, q = rng.uniform(0.2, 3.0, 3), rng.normal(0.0, 3.0, 3), random_orientations(rng, 1)[0]
        turn = Rotation.from_quat(q, scalar_first=True)
        through = rng.uniform(-0.5, 0.5, 3) * size
        way = rng.normal(size=3) * size
        ends = np.array([through - rng.random() * way, through + rng.random() * way]) + rng.normal(0.0, 0.1, 3) * size
        hull = ConvexHull((corners * size - ends[:, None]).reshape(-1, 3), qhull_options="Qt")
        ways = hull.equations[np.unique(hull.equations.round(7), axis=0, return_index=True)[1]]
        depths = np.sort(-ways[:, 3])
        unit = size.max() + np.abs(place).max()
        if abs(depths[0]) < 1e-9 or depths[1] - depths[0] < 1e-9:
            continue  # they just touch; or two ways out are as short
        p, end = turn.apply(ends) + place
        depth, normal, where = edge_box.edge_in_box(tuple(p), tuple(end), tuple(size), tuple(place), tuple(q))
        if depths[0] < 0.0 or depth <= 0.0:  # apart, or so it is said
            measured.append([np.maximum(depth, 0.0) / unit, 0.0, 0.0, 0.0, 0.0])
            expected.append([np.maximum(depths[0], 0.0) / unit, 0.0, 0.0, 0.0, 0.0])
            kinds.append("apart")
            continue
        out = ways[np.argmin(-ways[:, 3]), :3]
        through_face = np.abs(out).max() > 1.0 - 1e-9
        from_surface = (
            np.inf
        )  # of where they touch once it has gone, or, if that was beyond the box, of where it comes in
        for gone in (depth, 0.0):
            beyond = np.abs(turn.inv().apply(p + where * (end - p) + gone * np.array(normal) - place)) - 0.5 * size
            from_surface = np.minimum(from_surface, np.abs(beyond).min() + np.maximum(beyond, 0.0).sum())
        measured.append([depth / unit, *normal, from_surface / unit])
        expected.append([depths[0] / unit, *turn.apply(out), 0.0])
        kinds.append("through a face" if through_face else "across a side")
    return Comparison(np.array(measured), np.array(expected), groups=kinds)
