"""Cost of a body that holds itself, beside the same one that goes through itself: far from itself, and on itself."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import softbody
from benchmarks.goals import Goal
from benchmarks.race import Peer
from benchmarks.suite import Benchmark, Row
from benchmarks.worlds import putting_back
from softbody import Mesh, World

PAGE = "standard", 4  # the level from which on the page has it, and where: after whole scenes
WITHOUT = "the same without self_contact"
BALL = "A time step with self_contact: a ball that bounces"
RING = "A time step with self_contact: a ring that lands"
LIMP = "A time step with self_contact: a ball that has collapsed on to itself"
FINENESS = 1, 2  # 642 or 648 particles; four times as many
PARTICLE_STEPS = 100_000  # of a round
SLACK = 0.5  # of the stable step


def mesh_of(shape: str, fine: int) -> Mesh:
    """Return what is moved, of a metre or so."""
    return softbody.torus(0.6, 0.22, 36 * fine, 18 * fine) if shape == RING else softbody.icosphere(2 + fine, 0.5)


def held(shape: str, fine: int, self_contact: bool) -> tuple[World, float]:
    """Return a world of one body, at the instant that counts, and its step [s]."""
    stiffness, gas = (20.0, 0.5) if shape == LIMP else (400.0, 60.0)
    world = World()
    world.add_ground(restitution=0.8)
    world.add_soft_body(
        mesh_of(shape, fine), 1.0, stiffness, gas, (0.0, 0.0, 0.55), restitution=0.8, self_contact=self_contact
    )
    step = SLACK * world.stable_time_step()
    world.run(1.0 if shape == LIMP else 0.1, step)
    return world, step


def moving(world: World, step: float, steps: int) -> Callable[[], None]:
    """Return a call that moves a world by some steps, from where it is now."""
    back = putting_back(world)

    def call() -> None:
        back()
        world.step(step, steps, allow_unstable=True)

    return call


@Benchmark(
    Row("A time step with self_contact: *", "particles", "particle and step", own=(WITHOUT,)),
    sizes={"quick": tuple(product((BALL, RING, LIMP), FINENESS))},
    usual=(f"{BALL}-1", f"{LIMP}-1"),
    goals=(
        Goal(WITHOUT, 1 / 1.05, table=BALL),
        Goal(WITHOUT, 1 / 1.3, table=RING),
        Goal(WITHOUT, 1 / 10.0, table=LIMP),
    ),
)
def bench_self_contact(race, shape: str, fine: int) -> None:
    """A step of a body that holds itself; that it has none of it, or all of it, is what a user may meet."""
    world, step = held(shape, fine, True)
    particles = len(world.state.particle_position)
    steps = max(10, PARTICLE_STEPS // particles // (5 if shape == LIMP else 1))

    def rivals() -> dict[str, Peer]:
        bare, _ = held(shape, fine, False)
        return {WITHOUT: (moving(bare, step, steps), particles * steps)}

    race(
        moving(world, step, steps),
        particles * steps,
        table=shape,
        size=particles,
        peers=rivals,
        answer=lambda: world.state,
    )
