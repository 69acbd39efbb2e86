"""Claims that `Mesh.check` finds all that is doubtful in shells built to be doubtful, and nothing else."""

from __future__ import annotations

import numpy as np

from softbody import Finding, Mesh, icosphere, tetrahedron
from softbody.geometry import connected
from softbody.mesh import diagnostics
from validation.answers import Answers
from validation.cases import rotated
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "what users set and ask"

KINDS = (
    "several shells",
    "nested",
    "flat shell",
    "coincident triangles",
    "self-intersections",
    "pinched vertices",
    "touching vertices",
    "thin triangles",
    "unequal edges",
)
OUTER, INNER, ISLAND, SOLID = icosphere(1, 1.0), icosphere(1, 0.4), icosphere(1, 0.15), tetrahedron(0.3)
PYRAMID = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])  # over a base that is seen from below
HARDLY = 1e-6  # by which what is found, or is not, is beyond its limit


class Shells:
    """Shells side by side, and what is doubtful in them by construction."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.vertices = np.empty((0, 3))
        self.triangles = np.empty((0, 3), np.int64)
        self.of = np.empty(0, np.int64)  # shell of each triangle
        self.doubtful: dict[str, list[tuple[int, ...]]] = {kind: [] for kind in KINDS}  # shells, triangles, vertices
        self._cells = iter(5.0 * rng.permutation(np.stack(np.meshgrid(*[range(3)] * 3), axis=-1).reshape(-1, 3)))

    def place(self) -> np.ndarray:
        """Return a place (3,) [m] with room for a ball of radius 1, where nothing is yet."""
        return next(self._cells)

    def add(self, vertices: np.ndarray, triangles: np.ndarray) -> int:
        """Add a shell and return its number; corners below 0 are vertices that are there, from the last on."""
        self.triangles = np.concatenate([self.triangles, triangles + len(self.vertices)])
        self.vertices = np.concatenate([self.vertices, vertices])
        number = int(self.of[-1]) + 1 if len(self.of) else 0
        self.of = np.append(self.of, np.full(len(triangles), number))
        return number

    def add_mesh(self, mesh: Mesh, place: np.ndarray, inwards: bool = False) -> int:
        """Add a mesh that faces outwards, or inwards, as a shell."""
        return self.add(mesh.vertices + place, mesh.triangles[:, ::-1] if inwards else mesh.triangles)


def _built(rng: np.random.Generator) -> Shells:
    """Return shells of which, by chance, some are doubtful in one way or another."""
    made = Shells(rng)
    made.add(OUTER.vertices * (1.0 + 0.02 * rng.random((len(OUTER.vertices), 1))) + made.place(), OUTER.triangles)
    chances = rng.random(8) < 0.6
    if chances[0]:  # a cavity, and a body in it: there is nothing to doubt
        place = made.place()
        made.add_mesh(rotated(OUTER, rng), place)
        made.add_mesh(rotated(INNER, rng), place + rng.uniform(-0.2, 0.2, 3), inwards=True)
        made.add_mesh(rotated(ISLAND, rng), made.vertices[-len(INNER.vertices) :].mean(axis=0))
    if chances[1]:
        place = made.place()
        made.add_mesh(rotated(OUTER, rng), place)
        made.doubtful["nested"].append((made.add_mesh(rotated(INNER, rng), place + rng.uniform(-0.2, 0.2, 3)),))
    if chances[7]:  # a spike, of which most is in a larger solid, and its tip goes out through one triangle of that
        solid, place = Mesh(3.0 * SOLID.vertices + 0.05 * rng.normal(size=(4, 3)), SOLID.triangles), made.place()
        made.add_mesh(solid, place)
        pierced = len(made.triangles) - 4 + int(rng.integers(4))
        a, b, c = made.vertices[made.triangles[pierced]]
        middle, out = (a + b + c) / 3.0, np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
        base = [middle - 0.2 * out + 0.1 * (corner - middle) for corner in (a, b, c)]
        made.add(np.array([*base, middle + 0.1 * out]), PYRAMID)
        made.doubtful["self-intersections"] += [(pierced, len(made.triangles) - k) for k in (1, 2, 3)]
    if chances[2]:
        flat = made.add(made.place() + rng.normal(size=(3, 3)), np.array([(0, 1, 2), (0, 2, 1)]))
        made.doubtful["flat shell"].append((flat,))
        made.doubtful["coincident triangles"].append((len(made.triangles) - 2, len(made.triangles) - 1))
    for joined in (True, False):
        if chances[3 + joined]:  # two solids, of which one is the other's mirror image about a vertex
            made.add_mesh(rotated(SOLID, rng), made.place())
            corner, image = len(made.vertices) - 4, 2.0 * made.vertices[-4] - made.vertices[-4:]
            numbers = np.array([-4, 0, 1, 2]) if joined else np.arange(4)
            made.add(image[1:] if joined else image, numbers[SOLID.triangles[:, ::-1]])
            kind = "pinched vertices" if joined else "touching vertices"
            made.doubtful[kind] += [(corner,)] if joined else [(corner,), (corner + 4,)]
    if chances[5]:
        height = diagnostics.THIN * (1.0 + rng.choice([HARDLY, -HARDLY]))
        corners = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.4, height, 0.0), (0.5, 0.3, 0.8)])
        made.add(corners + made.place(), PYRAMID)
        if height < diagnostics.THIN:
            made.doubtful["thin triangles"].append((len(made.triangles) - 4,))
    if chances[6]:
        ends = made.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        lengths = np.linalg.norm(made.vertices[ends[:, 0]] - made.vertices[ends[:, 1]], axis=1)
        long = lengths.max() / diagnostics.UNEQUAL
        small = long * (1.0 + rng.choice([HARDLY, -HARDLY]))
        corners = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.1, 0.0), (0.0, 0.0, 1.2)])
        place = made.place()
        made.add(small * corners + place, PYRAMID)
        if small < long:
            shortest = len(made.vertices) - 4, len(made.vertices) - 3
            made.doubtful["unequal edges"] += [shortest, tuple(int(end) for end in ends[lengths.argmax()])]
    made.doubtful["several shells"] = [(shell,) for shell in np.unique(made.of)] if made.of[-1] > 0 else []
    return made


Findings = dict[str, set[tuple[int, ...]]]


def _mixed(made: Shells, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, Findings]:
    """Return a mesh, with vertices and triangles in another order, and what is to be found in it."""
    vertices, triangles = rng.permutation(len(made.vertices)), rng.permutation(len(made.triangles))
    vertex, triangle = np.argsort(vertices), np.argsort(triangles)  # new numbers of old ones
    faces = [np.roll(face, rng.integers(3)) for face in vertex[made.triangles[triangles]]]
    first = [int(triangle[made.of == shell].min()) for shell in range(made.of[-1] + 1)]
    numbers = {kind: np.array(first) for kind in KINDS[:3]}
    numbers |= dict.fromkeys(("coincident triangles", "thin triangles", "self-intersections"), triangle)
    found = {
        kind: {tuple(sorted(int(numbers.get(kind, vertex)[each]) for each in row)) for row in rows}
        for kind, rows in made.doubtful.items()
    }
    return made.vertices[vertices], np.array(faces), found


def _found(vertices: np.ndarray, triangles: np.ndarray) -> list[Finding]:
    """Return what is doubtful in a mesh; if that cannot be told, nothing is."""
    try:
        return Mesh(vertices, triangles).check()
    except Exception:
        return []


@check(
    section="beyond the paper",
    piece="softbody.Mesh.check, softbody.Finding",
    reference="how they were put together",
    kind="specification",
    faults=(
        Fault(
            "cavities taken for shells within",
            diagnostics._about_shells,
            "(volume_[clear_] > 0.0) & is_cavity_ → is_cavity",
        ),
        Fault(
            "fans of vertices by their triangles alone",
            connected.fans,
            "(edges // count_ + 1) % 3 → (edges // count_ + 2) % 3",
        ),
        Fault("triangles thin by their shortest edge", diagnostics._about_shapes, "np.max → np.min"),
    ),
)
def built_to_be_doubtful(run: Run) -> Comparison:
    """`Mesh.check` finds all that is doubtful in shells, and nothing else.

    Shells are side by side, within each other, flat, through each other, and joined by a vertex or touching there. A
    triangle is hardly too thin, or an edge hardly too short.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(40, 100, 1_000)):
        vertices, triangles, expected = _mixed(_built(rng), rng)
        told: Findings = {kind: set() for kind in KINDS}
        for finding in _found(vertices, triangles):
            rows = finding.where.reshape(len(finding.where), -1)
            told[finding.kind] = {tuple(sorted(int(number) for number in row)) for row in rows}
        for kind in KINDS:
            answers.add(told[kind] == expected[kind], True, kind=kind)
    return answers.comparison()
