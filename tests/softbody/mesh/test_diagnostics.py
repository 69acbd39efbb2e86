"""Does Mesh.check find what is doubtful, name it, and say nothing of good meshes?"""

import numpy as np
import pytest

import softbody
from softbody import Mesh, MeshError

CUBE = softbody.box()


def both(*meshes):
    """Return one mesh of several."""
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.triangles + start for mesh, start in zip(meshes, starts)]),
    )


class InsideOut:
    """The arrays of a mesh whose triangles face inwards, which is none on its own."""

    def __init__(self, mesh):
        self.vertices, self.triangles = mesh.vertices, mesh.triangles[:, ::-1]


def pinched():
    """Two tetrahedra that share a vertex."""
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1)], float)
    triangles = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3), (0, 4, 5), (0, 6, 4), (4, 6, 5), (5, 6, 0)]
    return Mesh(corners, triangles)


def with_pillow():
    """A cube and two triangles on each other, closed but flat."""
    points = np.concatenate([CUBE.vertices, [(5, 0, 0), (6, 0, 0), (5, 1, 0)]])
    return Mesh(points, np.concatenate([CUBE.triangles, [(8, 9, 10), (10, 9, 8)]]))


# What is found, and where, of each.
DOUBTFUL = {
    "two cubes apart": (both(CUBE, CUBE.moved((3, 0, 0))), {"several shells": [0, 12]}),
    "a cavity": (both(CUBE.scaled(2.0), InsideOut(CUBE)), {"several shells": [0, 12]}),
    "a cube in a cube": (both(CUBE.scaled(2.0), CUBE), {"several shells": [0, 12], "nested": [12]}),
    "an island in a cavity": (
        both(CUBE.scaled(3.0), InsideOut(CUBE.scaled(2.0)), CUBE),
        {"several shells": [0, 12, 24]},
    ),
    "the same cube twice": (
        both(CUBE, CUBE),
        {
            "several shells": [0, 12],
            "coincident triangles": [[k, k + 12] for k in range(12)],
            "touching vertices": list(range(16)),
        },
    ),
    "pinched": (pinched(), {"several shells": [0, 4], "pinched vertices": [0]}),
    "flat": (
        with_pillow(),
        {"several shells": [0, 12], "flat shell": [12], "coincident triangles": [[12, 13]]},
    ),
}


@pytest.mark.parametrize(("mesh", "expected"), DOUBTFUL.values(), ids=DOUBTFUL.keys())
def test_what_is_doubtful_is_found_by_name_and_place(mesh, expected):
    assert {finding.kind: finding.where.tolist() for finding in mesh.check()} == expected


def test_cubes_that_overlap_meet_and_nobody_says_which_is_within():
    found = {finding.kind: finding for finding in both(CUBE, CUBE.moved((0.5, 0.1, 0.2))).check()}
    assert found.keys() == {"several shells", "self-intersections"}
    pairs = found["self-intersections"].where
    assert (pairs[:, 0] < 12).all()
    assert (pairs[:, 1] >= 12).all()


def test_thin_triangles_and_unequal_edges_are_found():
    long = softbody.box((2000.0, 1.0, 1.0))
    found = {finding.kind: finding.where for finding in long.check()}
    assert found.keys() == {"thin triangles", "unequal edges"}
    assert len(found["thin triangles"]) == 8
    length = np.linalg.norm(np.diff(long.vertices[found["unequal edges"]], axis=1)[:, 0], axis=1)
    assert length == pytest.approx([1.0, 2000.0], rel=1e-3)


@pytest.mark.parametrize("mesh", [softbody.tetrahedron(), softbody.icosphere(3), softbody.torus(), CUBE])
def test_of_a_good_mesh_nothing_is_said(mesh):
    assert mesh.check() == []


def test_a_finding_says_what_and_how_to_cure_it_in_one_line():
    for mesh, _ in DOUBTFUL.values():
        for finding in mesh.check():
            assert str(finding) == f"{finding.kind}: {finding.what}; {finding.cure}"
            assert "\n" not in str(finding)
            assert finding.kind in softbody.Finding.__doc__


def test_a_shell_that_is_inside_out_is_refused_unless_it_bounds_a_cavity():
    aside = CUBE.moved((5.0, 0.0, 0.0))
    with pytest.raises(MeshError, match=r"shell of triangle 12, 12 triangles, is inside out \(volume -1 m³\).*reverse"):
        both(CUBE.scaled(2.0), InsideOut(aside))
    with pytest.raises(MeshError, match="shell of triangle 24"):  # where there is a cavity already
        both(CUBE.scaled(3.0), InsideOut(CUBE.scaled(2.0)), InsideOut(CUBE))


def test_a_foam_has_its_volume_and_nothing_but_shells():
    rng = np.random.default_rng(0)
    grid = np.stack(np.meshgrid(*3 * [np.arange(-1, 2)]), axis=-1).reshape(-1, 3)
    bubbles = [InsideOut(softbody.octahedron(0.3).moved(spot + 0.1 * rng.normal(size=3))) for spot in grid]
    foam = both(softbody.box((4.0, 4.0, 4.0)), *bubbles)
    assert foam.volume == pytest.approx(64.0 - 27 * 4 / 3 * 0.3**3, rel=1e-12)
    assert [finding.kind for finding in foam.check()] == ["several shells"]
