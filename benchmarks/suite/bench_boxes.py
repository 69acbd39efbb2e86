"""Cost of boxes: a step of a pile, and the contact of a pair. Bullet and FCL alongside, one thread."""

from __future__ import annotations

import functools
from collections.abc import Callable

import fcl
import numpy as np
from scipy.spatial import cKDTree

from benchmarks.goals import Goal
from benchmarks.suite import Benchmark, Row
from benchmarks.worlds import putting_back
from references.pybullet_world import BulletWorld
from softbody import World
from softbody.collision.boxes.manifold import box_pairs_manifolds
from softbody.collision.boxes.sat_boxes import PlacedBoxes
from softbody.collision.broad_phase import near_pairs, near_pairs_exhaustive

STEP = 1.0 / 240.0
PAGE = "standard", 6  # the level from which on the page has it, and where
SETTLE = 120  # steps before the clock starts: by then the lower layers have landed
PAIRS = 2_000


def pile(count: int) -> tuple[World, BulletWorld]:
    """Return the same boxes in both engines, above the ground in layers; both may stop iterating early."""
    rng = np.random.default_rng(count)
    world = World()
    bullet = BulletWorld(STEP, world.store.settings.iterations, residual=1e-7)
    world.add_ground()
    bullet.add_ground()
    side = max(2, round((count / 3.0) ** (1.0 / 3.0)))
    for i in range(count):
        place = np.array([1.2 * (i % side), 1.2 * (i // side % side), 0.6 + 1.05 * (i // side**2)])
        place[:2] += rng.uniform(-0.1, 0.1, 2)
        q = np.array([1.0, *(0.05 * rng.normal(size=3))])
        q /= np.linalg.norm(q)
        world.add_box((0.8, 0.8, 0.8), 1.0, place, q)
        bullet.add_box((0.8, 0.8, 0.8), 1.0, place, q)
    world.step(STEP, SETTLE)
    bullet.step(SETTLE)
    return world, bullet


@Benchmark(
    Row("A time step of a pile of boxes", "boxes", "box and step"),
    sizes={"quick": (10, 100), "standard": (10, 100, 1_000), "full": (10, 100, 1_000, 10_000)},
    usual=(100,),
    goals=(Goal("pybullet", 1.5),),
)
def bench_pile(race, count: int) -> None:
    """A step of a pile of boxes."""
    world, bullet = pile(count)
    steps = max(1, 2_000 // count)
    units = count * steps
    peers = {"pybullet": (lambda: bullet.step(steps), units)}
    put_back, landed = putting_back(world), bullet.save()

    def restore() -> None:
        put_back()
        bullet.restore(landed)

    call = functools.partial(world.step, STEP, steps)
    race(call, units, size=count, peers=peers, restore=restore, answer=lambda: world.state)
    bullet.close()


@Benchmark(
    Row("The pairs of boxes that are near each other", "boxes", "box", own=("all pairs",)),
    sizes={"quick": (100, 1_000), "standard": (100, 1_000, 10_000), "full": (100, 1_000, 10_000, 100_000)},
)
def bench_near_pairs(race, count: int) -> None:
    """The broad phase: equal spheres, as dense as a pile; the cost of one must not grow with their number."""
    side = count ** (1.0 / 3.0)
    centre = np.random.default_rng(count).uniform(0.0, side, (count, 3))
    radius, movable = np.full(count, 0.6), np.ones(count, bool)
    peers = {"SciPy's k-d tree": (lambda: cKDTree(centre).query_pairs(1.2, output_type="ndarray"), count)}
    if count <= 10_000:
        peers["all pairs"] = (lambda: near_pairs_exhaustive(centre, radius, movable), count)
    race(lambda: near_pairs(centre, radius, movable), count, size=count, peers=peers)


def pairs_of_boxes() -> tuple[np.ndarray, ...]:
    """Return sizes, positions and orientations of a and b: random poses, two in three of which overlap."""
    rng = np.random.default_rng(1)
    size_a, size_b = rng.uniform(0.4, 2.0, (2, PAIRS, 3))
    q_a, q_b = rng.normal(size=(2, PAIRS, 4))
    q_a /= np.linalg.norm(q_a, axis=1, keepdims=True)
    q_b /= np.linalg.norm(q_b, axis=1, keepdims=True)
    x_a = rng.uniform(-1.0, 1.0, (PAIRS, 3))
    reach = 0.5 * (np.linalg.norm(size_a, axis=1) + np.linalg.norm(size_b, axis=1))
    direction = rng.normal(size=(PAIRS, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return size_a, x_a, q_a, size_b, x_a + (rng.uniform(0.0, 1.2, PAIRS) * reach)[:, None] * direction, q_b


def fcl_calls(pairs: tuple[np.ndarray, ...]) -> Callable[[], None]:
    """Return a call that asks FCL for the contacts of all pairs, its objects made beforehand."""
    objects = [
        [fcl.CollisionObject(fcl.Box(*s), fcl.Transform(q, x)) for s, x, q in zip(*pairs[k : k + 3])] for k in (0, 3)
    ]
    request = fcl.CollisionRequest(num_max_contacts=8, enable_contact=True)

    def call() -> None:
        for a, b in zip(*objects):
            fcl.collide(a, b, request, fcl.CollisionResult())

    return call


@Benchmark(Row("The contact points of two boxes", "pairs", "pair"), usual=True, goals=(Goal("python-fcl", 12.0),))
def bench_contacts_of_pairs(race) -> None:
    """Separating axes and clipped contact points of many pairs in one call; FCL pair by pair, as its binding wants."""
    pairs = pairs_of_boxes()
    a, b = PlacedBoxes(*pairs[:3]), PlacedBoxes(*pairs[3:])
    race(lambda: box_pairs_manifolds(a, b), PAIRS, size=PAIRS, peers={"python-fcl": (fcl_calls(pairs), PAIRS)})
