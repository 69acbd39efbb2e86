"""Are the pairs of triangles that meet those that one sees, and those of libigl with CGAL on real meshes?"""

from pathlib import Path

import numpy as np
import pytest

import softbody
from softbody.geometry.self_intersections import segment_meets_triangle, self_intersections
from tests.softbody.geometry.shapes import turned

ONE = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])

OTHERS = {  # corners of another triangle, and whether it has a point of ONE
    "through its middle": ([(0.2, 0.2, -1.0), (0.2, 0.2, 1.0), (3.0, 3.0, 0.0)], True),
    "an edge passes by": ([(0.6, 0.6, -1.0), (0.6, 0.6, 1.0), (3.0, 3.0, 0.0)], False),
    "a corner on its face": ([(0.2, 0.2, 0.0), (0.2, 0.2, 1.0), (3.0, 3.0, 1.0)], True),
    "a corner just above": ([(0.2, 0.2, 1e-50), (0.2, 0.2, 1.0), (3.0, 3.0, 1.0)], False),
    "a corner on its edge": ([(0.5, 0.5, 0.0), (0.6, 0.6, 1.0), (3.0, 3.0, 1.0)], True),
    "a corner beside its edge": ([(0.5, 0.5 + 1e-15, 0.0), (0.6, 0.6, 1.0), (3.0, 3.0, 1.0)], False),
    "edges cross": ([(0.5, -1.0, 0.0), (0.5, 1.0, 0.0), (0.5, 0.0, 1.0)], True),
    "in its plane, within": ([(0.1, 0.1, 0.0), (0.2, 0.1, 0.0), (0.1, 0.2, 0.0)], True),
    "in its plane, around": ([(-1.0, -1.0, 0.0), (9.0, -1.0, 0.0), (-1.0, 9.0, 0.0)], True),
    "in its plane, across": ([(-1.0, 0.3, 0.0), (2.0, 0.3, 0.0), (2.0, 0.4, 0.0)], True),
    "in its plane, beside": ([(1.1, 0.0, 0.0), (2.0, 0.0, 0.0), (2.0, 1.0, 0.0)], False),
    "in its plane, along an edge": ([(0.2, 0.0, 0.0), (0.8, 0.0, 0.0), (0.5, -1.0, 0.0)], True),
    "parallel": ([(0.0, 0.0, 1e-9), (1.0, 0.0, 1e-9), (0.0, 1.0, 1e-9)], False),
    "from a corner of it, away": ([(0.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, -1.0, 1.0)], False),
    "from a corner of it, through it": ([(0.0, 0.0, 0.0), (0.3, 0.3, 1.0), (0.3, 0.3, -1.0)], True),
    "from a corner of it, within": ([(0.0, 0.0, 0.0), (0.2, 0.1, 0.0), (0.1, 0.2, 0.0)], True),
    "from a corner of it, touching one edge": ([(0.0, 0.0, 0.0), (0.2, 0.0, 0.0), (0.2, -0.2, 1.0)], True),
    "over an edge of it, flat": ([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 1.0, 0.0)], False),
    "over an edge of it, folded": ([(0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.3, 0.3, 0.0)], True),
    "over an edge of it, nearly folded": ([(0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.3, 0.3, 1e-50)], False),
}


def pairs_of(corners):
    """Return the pairs that meet, and those that coincide, of triangles (t, 3, 3) whose equal corners are one."""
    points, numbers = np.unique(np.reshape(corners, (-1, 3)), axis=0, return_inverse=True)
    found = self_intersections(points, numbers.reshape(-1, 3), np.arange(len(points)))
    return tuple(pairs.tolist() for pairs in found)


@pytest.mark.parametrize(("other", "meet"), OTHERS.values(), ids=OTHERS.keys())
def test_two_triangles_meet_beyond_what_they_share_or_do_not(other, meet):
    expected = ([[0, 1]] if meet else [], [])
    for turn in range(3):
        one, two = np.roll(ONE, turn, axis=0), np.roll(other, -turn, axis=0)
        for axes in ([0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2]):
            assert pairs_of([one[:, axes], two[:, axes]]) == expected
            assert pairs_of([two[::-1][:, axes], one[:, axes]]) == expected


def test_triangles_of_the_same_corners_coincide_whichever_way_round():
    assert pairs_of([ONE, np.roll(ONE, 1, axis=0)]) == ([], [[0, 1]])
    assert pairs_of([ONE, ONE[::-1], ONE + 5.0]) == ([], [[0, 1]])


def test_a_segment_meets_a_triangle_at_its_own_end_but_not_before_it():
    triangle = tuple(tuple(corner) for corner in ONE.tolist())
    assert segment_meets_triangle((0.2, 0.2, 1.0), (0.2, 0.2, 0.0), triangle)
    assert not segment_meets_triangle((0.2, 0.2, 1.0), (0.2, 0.2, 1e-50), triangle)


def test_a_good_mesh_does_not_meet_itself_wherever_it_is():
    for mesh in (softbody.icosphere(2), softbody.torus(), softbody.box(segments=3)):
        for vertices in (mesh.vertices, turned(mesh.vertices), mesh.vertices + 1e6):
            meeting, coincident = self_intersections(vertices, mesh.triangles, np.arange(len(vertices)))
            assert len(meeting) == len(coincident) == 0


def test_all_of_many_pairs_are_found():
    """Of forty triangles, upright through one line, all meet: 780 pairs; of a hundred 4950, more than there is room."""
    for count in (40, 100):
        angle = np.pi * np.arange(count) / count
        ends = np.stack([np.cos(angle), np.sin(angle), 0.1 * angle], axis=1)
        corners = np.stack([ends, -ends, np.tile([0.0, 0.0, 2.0], (count, 1)) + 0.01 * ends], axis=1)
        meeting, _ = pairs_of(corners)
        assert len(meeting) == count * (count - 1) // 2
        assert meeting == sorted(meeting)


def test_soups_meet_where_libigl_says():
    igl = pytest.importorskip("references.igl")
    rng = np.random.default_rng(1)
    for trial in range(20):
        # Coordinates from a small grid: most of the pairs touch, or lie in one plane.
        points = rng.integers(0, 4, (30, 3)).astype(float) if trial % 2 else rng.normal(size=(30, 3))
        points = np.unique(points, axis=0)
        triangles = rng.integers(0, len(points), (40, 3))
        a, b, c = (points[triangles[:, k]] for k in range(3))
        triangles = triangles[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0.0]
        compare(igl, points, triangles)


@pytest.mark.parametrize("part", ["husky/meshes", "kiva_shelf/meshes", "laikago", "duck"])
def test_real_meshes_meet_themselves_where_libigl_says(part):
    igl = pytest.importorskip("references.igl")
    trimesh = pytest.importorskip("references.trimesh")
    data = Path(pytest.importorskip("pybullet_data").getDataPath())
    paths = sorted(path for path in data.glob(f"{part}*/**/*") if path.suffix in (".stl", ".obj"))
    paths += sorted(data.glob(f"{part}*.obj"))
    assert paths
    for path in [path for path in paths if path.stat().st_size < 2e6][:12]:
        vertices, triangles = trimesh.load_mesh(path)
        a, b, c = (vertices[triangles[:, k]] for k in range(3))
        compare(igl, vertices, triangles[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0.0])


def compare(igl, vertices, triangles):
    """See that pairs are those of libigl; of neighbours over an edge it has no say, and of coincident ones."""
    meeting, coincident = self_intersections(vertices, triangles, np.arange(len(vertices)))
    expected = {tuple(pair) for pair in igl.self_intersections(vertices, triangles).tolist()}
    ours = {tuple(pair) for pair in meeting.tolist()}
    assert expected <= ours | {tuple(pair) for pair in coincident.tolist()}
    for t, u in ours - expected:
        assert len(set(triangles[t]) & set(triangles[u])) == 2
