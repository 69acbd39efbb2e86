"""Claims about soft bodies that go through themselves."""

from __future__ import annotations

import re
import warnings
from contextlib import suppress

import numpy as np

import softbody
from softbody import Mesh, SelfIntersectionWarning, SimulationError, World
from softbody.geometry import unfolded
from softbody.stepping import runner, skins
from validation.answers import Answers
from validation.cases import MESH_KINDS, edge_lengths, random_mesh
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "soft bodies"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

LOOKS = (128, 512)  # the steps after which `World.step` says that it looks, of those that are taken here
SAYS = re.compile(r"soft body (\d)[^:]* goes through itself: (\d+) pairs of its triangles meet after step (\d+)")
OTHERS = re.compile(r"soft body (\d) \((\d+) pairs\)")


@check(
    section="beyond the paper",
    piece="softbody.World.step",
    reference="libigl's remesh_self_intersections, with CGAL's exact predicates, of a twin that stops at each look",
    engines=("igl",),
    unit="disagreements",
    faults=(
        Fault("every body is seen whole", skins.Skins._meeting, "is_star_shaped(vertices, triangles) → True"),
        Fault("the tree stays as it was", skins.Skins._meeting, "refit_bvh(skin.tree, vertices) → pass"),
        Fault("looked at late", skins.next_look, "each > steps → each > 2 * steps + 300"),
        Fault("nobody looks", runner.Runner.advance, "store.steps == look → store.steps < look"),
        Fault("said once more", skins.Skins.look, "self._clean.pop(body) → self._clean[body]"),
    ),
)
def going_through_itself_is_said(run: Run) -> Comparison:
    """A soft body that goes through itself is named.

    Balls, rings and bricks of little gas and much, two in a world, some under a plate: which of them, after which step,
    and how many pairs of its triangles meet then. Of others nothing is said, and of none twice. Some collapse later.
    """
    from references import igl

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(8, 24, 150)):
        seed = int(rng.integers(2**32))
        world, twin = _world_of_limp_bodies(seed), _world_of_limp_bodies(seed)
        h = 0.5 * world.stable_time_step()
        expected: dict[int, tuple[int, ...]] = {}
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            _step(world, h, LOOKS[-1] + 1)
        told = [str(each.message) for each in caught if each.category is SelfIntersectionWarning]
        said = [row for text in told for row in _understood(text)]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for look in LOOKS:
                _step(twin, h, look - twin.steps)
                for k, body in enumerate(twin.soft_bodies if twin.steps == look else ()):
                    pairs = len(igl.self_intersections(body.positions, body.triangles))
                    if pairs:
                        expected.setdefault(k, (k, look, pairs))
        for k in range(len(world.soft_bodies)):
            kind = f"{'under a plate' if world.boxes else 'alone'}: {'through itself' if k in expected else 'whole'}"
            ours, judged = [row for row in said if row[0] == k], [expected[k]] if k in expected else []
            answers.add(ours == judged, True, kind=kind)
    return answers.comparison()


def _understood(text: str) -> list[tuple[int, ...]]:
    """Return body, step and pairs (k, 3) that a warning names."""
    first = SAYS.search(text)
    if first is None:
        return []
    body, pairs, step = map(int, first.groups())
    return [(body, step, pairs), *((int(k), step, int(pairs)) for k, pairs in OTHERS.findall(text))]


def _step(world: World, h: float, steps: int) -> None:
    """Take steps of `h` [s], up to where a body has collapsed."""
    with suppress(SimulationError):
        world.step(h, steps)


def _world_of_limp_bodies(seed: int) -> World:
    """Return two soft bodies beside each other on the ground, of any gas, half the time under a plate."""
    rng = np.random.default_rng(seed)
    world = World()
    world.add_ground()
    has_plate = rng.random() < 0.5
    for k in range(2):
        ring = softbody.torus(0.4, 0.15, 18, 10)
        mesh = [ring, ring, softbody.icosphere(2, 0.4), softbody.box((0.8, 0.6, 0.4), 4)][int(rng.integers(4))]
        height = 0.05 - mesh.vertices[:, 2].min()
        gas, stiffness = 10.0 ** rng.uniform(-1.0, 2.0), 10.0 ** rng.uniform(1.0, 2.5)
        place, velocity = (2.0 * k, 0.0, height), (0.0, rng.uniform(-4.0, 4.0), 0.0)
        world.add_soft_body(mesh, 1.0, stiffness, gas, place, velocity)
        if has_plate:
            world.add_box((1.5, 1.5, 0.2), mass=10.0 ** rng.uniform(0.0, 1.5), position=(2.0 * k, 0.0, height + 0.7))
    return world


@check(
    section="beyond the paper",
    piece="softbody.geometry.unfolded",
    reference="libigl's remesh_self_intersections, with CGAL's exact predicates; what is convex",
    engines=("igl",),
    unit="disagreements",
    faults=(
        Fault("some face away", unfolded.is_star_shaped, "dot(cross(a, b), c) > z_ → dot(cross(a, b), c) > -z_ * 1e9"),
        Fault("what is wrapped twice", unfolded.is_star_shaped, "_is_within(ahead, a, b) → False"),
        Fault("folds", unfolded.find_unfolded, "dot(cross(a, b), normal) > z_ → dot(cross(a, b), normal) > -z_ * 1e9"),
        Fault("fans that go round twice", unfolded.find_unfolded, "_is_between(way, a, b, normal) → False"),
    ),
)
def seen_whole_is_whole(run: Run) -> Comparison:
    """What is seen whole from its middle meets itself nowhere.

    And triangles around a vertex of which none is seen behind another, along the sum of their normals, meet in their
    common edges only. Meshes of all kinds, shaken, flattened to bags, and wrapped twice around their middle. Of a
    convex mesh both are found so.
    """
    from references import igl

    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(30, 200, 3_000)):
        kind = "wrapped twice" if trial % 7 == 0 else MESH_KINDS[trial % len(MESH_KINDS)]
        smooth = _wrapped_twice(rng) if kind == "wrapped twice" else random_mesh(kind, rng)
        vertices, triangles = _shaken(smooth, rng), smooth.triangles
        memory, is_unfolded = np.empty((2, *vertices.shape)), np.empty(len(vertices), bool)
        unfolded.find_unfolded(vertices, triangles, memory, is_unfolded)
        pairs = igl.self_intersections(vertices, triangles)
        wrong = [pair for pair in pairs.tolist() if is_unfolded[np.intersect1d(*triangles[pair])].any()]
        star = unfolded.is_star_shaped(vertices, triangles)
        answers.add(star and len(pairs) > 0, False, kind=f"{kind}: {'meets itself' if len(pairs) else 'whole'}")
        answers.add(len(wrong) > 0, False, kind=f"{kind}: around vertices")
    ball = softbody.icosphere(3)
    memory, is_unfolded = np.empty((2, *ball.vertices.shape)), np.empty(len(ball.vertices), bool)
    for _ in range(run.count(3, 10, 100)):
        vertices = ball.vertices * rng.uniform(0.1, 1.0, 3)
        unfolded.find_unfolded(vertices, ball.triangles, memory, is_unfolded)
        answers.add(unfolded.is_star_shaped(vertices, ball.triangles) and is_unfolded.all(), True, kind="convex")
    return answers.comparison()


def _shaken(mesh: Mesh, rng: np.random.Generator) -> np.ndarray:
    """Return the vertices of a mesh moved by up to some edges, some of them flattened."""
    edge = edge_lengths(mesh.vertices, mesh.edges).mean()
    moved = mesh.vertices + edge * 10.0 ** rng.uniform(-2.0, 0.0) * rng.normal(size=mesh.vertices.shape)
    return moved * ([1.0, 1.0, 10.0 ** rng.uniform(-3.0, 0.0)] if rng.random() < 0.5 else 1.0)


def _wrapped_twice(rng: np.random.Generator) -> Mesh:
    """Return a closed mesh of genus 0 whose rings go round the z axis twice, through each other."""
    rings, around = int(rng.integers(3, 8)), 2 * int(rng.integers(4, 10))
    down, turn = np.pi * np.arange(1, rings + 1) / (rings + 1), 4.0 * np.pi * np.arange(around) / around
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros(around)], axis=1)
    rows = [np.sin(theta) * ring + [0.0, 0.0, np.cos(theta)] for theta in down]
    vertices = np.concatenate([[[0.0, 0.0, 1.0]], *rows, [[0.0, 0.0, -1.0]]])
    vertices *= rng.uniform(0.9, 1.1, (len(vertices), 1))
    here, beside = np.arange(around), (np.arange(around) + 1) % around
    faces = [np.stack([0 * here, 1 + here, 1 + beside], axis=1)]
    for k in range(rings - 1):
        upper, lower = 1 + k * around, 1 + (k + 1) * around
        faces.append(np.stack([upper + here, lower + here, lower + beside], axis=1))
        faces.append(np.stack([upper + here, lower + beside, upper + beside], axis=1))
    last, end = 1 + (rings - 1) * around, len(vertices) - 1
    faces.append(np.stack([last + here, np.full(around, end), last + beside], axis=1))
    return Mesh(vertices, np.concatenate(faces))
