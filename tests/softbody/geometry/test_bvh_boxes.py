"""Are the triangles that a tree lists those whose boxes meet a box that is asked, for each of eight boxes?"""

import numpy as np
import pytest

import softbody
from softbody.geometry.bvh import build_bvh, search_space
from softbody.geometry.bvh_boxes import ask_box, ask_nothing, list_near, sort_listed

MESHES = {
    "of one leaf": softbody.box(),
    "of two levels": softbody.icosphere(1),
    "of four levels": softbody.icosphere(4),
}


def asked(tree, boxes):
    """Return {triangle: which of the boxes its own meets}, sorted by triangle."""
    search = search_space(tree)
    ask_nothing(search)
    for lane, (low, high) in boxes.items():
        ask_box(search, lane, tuple(low), tuple(high), tree)
    count = list_near(tree, search)
    sort_listed(search, count)
    listed = search.listed[:count].tolist()
    assert listed == sorted(set(listed))
    return {t: {lane for lane in range(8) if search.meets[k] >> lane & 1} for k, t in enumerate(listed)}


@pytest.mark.parametrize("name", MESHES)
def test_each_box_meets_what_it_meets_alone(name):
    rng = np.random.default_rng(1)
    mesh = MESHES[name]
    tree, corners = build_bvh(mesh.vertices, mesh.triangles), mesh.vertices[mesh.triangles]
    for _ in range(30):
        lanes = rng.permutation(8)[: rng.integers(1, 9)]
        boxes = {}
        for lane in lanes:
            middle, half = rng.uniform(-1.2, 1.2, 3), rng.uniform(0.0, 0.3, 3)
            boxes[lane] = middle - half, middle + half
        found = asked(tree, boxes)
        for lane, (low, high) in boxes.items():
            meets = ((corners.min(axis=1) <= high) & (corners.max(axis=1) >= low)).all(axis=1)
            listed = np.isin(np.arange(len(corners)), [t for t, which in found.items() if lane in which])
            near = ((corners.min(axis=1) <= high + 1e-6) & (corners.max(axis=1) >= low - 1e-6)).all(axis=1)
            assert (meets <= listed).all(), "one that meets is missing"
            assert (listed <= near).all(), "one that is away is listed"
        assert all(which <= set(boxes) for which in found.values())


def test_what_is_not_finite_meets_nothing():
    mesh = softbody.icosphere(1)
    tree = build_bvh(mesh.vertices, mesh.triangles)
    everything = (np.full(3, -9.0), np.full(3, 9.0))
    assert len(asked(tree, {3: everything})) == len(mesh.triangles)
    assert asked(tree, {}) == {}
    for spoiled in (np.nan, np.inf, -np.inf):
        low = np.array([-9.0, spoiled, -9.0])
        assert asked(tree, {0: (low, everything[1])}) == {}
