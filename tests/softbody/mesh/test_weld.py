"""Do triangles that share no vertices become the mesh that they are of, and no other?"""

import numpy as np
import pytest

import softbody
from softbody import Mesh, MeshError, ParameterError

BALL = softbody.icosphere(2)
SOUP = BALL.vertices[BALL.triangles]


def test_a_soup_without_its_vertices_merged_is_told_so():
    loose = SOUP.reshape(-1, 3), np.arange(SOUP.size // 3).reshape(-1, 3)
    with pytest.raises(
        MeshError, match=r"798 of 960 vertices are at the place of another one: merge vertices, by Mesh"
    ):
        Mesh(*loose)
    assert len(Mesh.from_soup(*loose).vertices) == 162


@pytest.mark.parametrize("corners", [SOUP, SOUP.reshape(-1, 3), SOUP.tolist(), SOUP.astype(np.float32)])
def test_corners_alone_are_a_soup(corners):
    mesh = Mesh.from_soup(corners)
    assert mesh.vertices.shape == BALL.vertices.shape
    assert mesh.vertices[mesh.triangles] == pytest.approx(SOUP, rel=1e-6)


def test_vertices_are_numbered_as_they_come_and_unused_ones_are_left_out():
    vertices = np.concatenate([[(9.0, 9.0, 9.0)], BALL.vertices, BALL.vertices])
    triangles = np.concatenate([BALL.triangles[:7] + 1, BALL.triangles[7:] + 163])
    mesh = Mesh.from_soup(vertices, triangles)
    assert (mesh.vertices == BALL.vertices).all()
    assert (mesh.triangles == BALL.triangles).all()


def test_minus_zero_is_zero():
    corners = softbody.octahedron().vertices[softbody.octahedron().triangles]
    corners[::2] = np.where(corners[::2] == 0.0, -0.0, corners[::2])
    assert len(Mesh.from_soup(corners).vertices) == 6


def test_a_tolerance_merges_what_is_near_and_only_that():
    noise = np.random.default_rng(0).uniform(-1e-6, 1e-6, SOUP.shape)
    with pytest.raises(MeshError, match=r"met by 1 triangle"):
        Mesh.from_soup(SOUP + noise)
    mesh = Mesh.from_soup(SOUP + noise, tolerance=4e-6)
    assert len(mesh.vertices) == 162
    assert mesh.volume == pytest.approx(BALL.volume, rel=1e-5)
    first = SOUP + noise
    assert mesh.vertices[0].tolist() in first.reshape(-1, 3).tolist()  # one of those that were there


def test_what_is_exactly_a_tolerance_apart_is_merged_and_chains_are():
    cube = softbody.box()
    triangles = cube.triangles
    moved = np.concatenate([cube.vertices, cube.vertices + [0.125, 0.0, 0.0], cube.vertices + [0.25, 0.0, 0.0]])
    chained = triangles + 8 * (np.arange(12) % 3)[:, None]
    assert (Mesh.from_soup(moved, chained, tolerance=0.125).vertices[:, 1:] == cube.vertices[:, 1:]).all()
    with pytest.raises(MeshError, match="met by 1"):
        Mesh.from_soup(moved, chained, tolerance=0.1249)


def test_merging_is_that_of_every_pair_looked_at():
    rng = np.random.default_rng(3)
    cells = np.repeat(softbody.octahedron(0.1).vertices[softbody.octahedron().triangles][None], 60, axis=0)
    corners = (cells + 0.4 * rng.integers(0, 5, (60, 1, 1, 3))).reshape(-1, 3) + rng.uniform(0.0, 0.01, (60 * 24, 3))
    from softbody.mesh.weld import first_at_place, first_within

    ours = first_within(corners, first_at_place(corners), 0.012)
    near = np.linalg.norm(corners[:, None] - corners, axis=2) <= 0.012
    while True:
        wider = near @ near
        if (wider == near).all():
            break
        near = wider
    assert (ours == np.argmax(near, axis=1)).all()


def test_triangles_that_shrink_to_a_line_are_left_out():
    cube = softbody.box()
    i, j, k = (int(c) for c in cube.triangles[0])
    other = next(t for t in range(1, 12) if {i, j} <= set(cube.triangles[t].tolist()))
    top = next(v for v in cube.triangles[other].tolist() if v not in (i, j))
    middle = 0.5 * (cube.vertices[i] + cube.vertices[j])
    rest = np.delete(cube.triangles, [0, other], axis=0)
    # The edge is split twice, at nearly the same place: between lie two triangles without area.
    split = [(i, 8, k), (8, 9, k), (9, j, k), (j, 9, top), (9, 8, top), (8, i, top)]
    mesh = Mesh.from_soup(np.vstack([cube.vertices, middle, middle]), np.vstack([rest, split]))
    assert (len(mesh.vertices), len(mesh.triangles)) == (9, 14)
    assert mesh.volume == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("wrong", "error", "message"),
    [
        (lambda: Mesh.from_soup(np.zeros((4, 3))), MeshError, r"corners have shape \(4, 3\); give \(t, 3, 3\)"),
        (lambda: Mesh.from_soup(np.zeros((4, 4, 3))), MeshError, r"corners have shape \(4, 4, 3\)"),
        (lambda: Mesh.from_soup(3), MeshError, r"corners have shape \(\)"),
        (lambda: Mesh.from_soup([]), MeshError, r"corners have shape"),
        (lambda: Mesh.from_soup(np.zeros((0, 3, 3))), MeshError, "the mesh is empty"),
        (lambda: Mesh.from_soup([[1.0], [1.0, 2.0]]), MeshError, "corners are not numbers in triples"),
        (lambda: Mesh.from_soup([[[10**400] * 3] * 3]), MeshError, "vertices are not numbers"),
        (lambda: Mesh.from_soup("soup"), MeshError, r"corners have shape"),
        (lambda: Mesh.from_soup(SOUP * np.nan), MeshError, "vertex 0 is at .*: not finite"),
        (lambda: Mesh.from_soup(SOUP, tolerance=-1.0), ParameterError, "tolerance is -1"),
        (lambda: Mesh.from_soup(SOUP, tolerance=np.nan), ParameterError, "tolerance is nan"),
        (lambda: Mesh.from_soup(SOUP, tolerance=3.0), MeshError, "no triangle is left where vertices within 3 m"),
        (lambda: Mesh.from_soup(BALL.vertices, BALL.triangles + 1), MeshError, "vertices run from 0 to 161"),
    ],
)
def test_what_is_no_soup_is_refused_by_name(wrong, error, message):
    with pytest.raises(error, match=message):
        wrong()
