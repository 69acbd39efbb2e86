"""Work–precision of the integrators: how near to the true motion each gets for how much time.

A soft sphere that shakes for half a second, by itself; and a whole scene, a ball that turns, falls and bounces off the
ground, as soft and as stiff as they come, both undamped. The truth is SciPy's in both.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from itertools import product

import numpy as np
from scipy.spatial.transform import Rotation

import softbody
from benchmarks.suite import Benchmark, Row
from references import ground, scipy
from softbody.model.settings import INTEGRATORS

PAGE = "standard", 2  # the level from which on the page has it, and where
RADIUS, GAS = 0.5, 30.0  # [m], [J]
STIFFNESS, SECONDS = 200.0, 0.5  # of the sphere that shakes [N/m], [s]
STEPS = (150, 300, 600, 1_200, 2_400, 4_800)

# Of the ball that bounces: for how long [s], how fast it comes [m/s], and from how high [m]; and for each stiffness
# [N/m] the fewest steps, in which it is just stable.
BOUNCE_SECONDS, SPEED, HEIGHT, GRAVITY = 0.25, 2.0, 0.6, 9.81
FEWEST = {1e3: 112, 1e4: 352, 1e5: 1_120, 1e6: 3_520}
PARTS = (1, 2, 4, 8, 16)

OURS, *OTHERS = INTEGRATORS

Start = tuple[softbody.Mesh, np.ndarray, np.ndarray]  # a body, its velocities, and where it truly is in the end
Ending = tuple[Callable[[], np.ndarray], float]  # a call, and how far from the truth it ends


def springs_of(mesh: softbody.Mesh, stiffness: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the edges of a mesh, their lengths [m] and their stiffness [N/m]."""
    lengths = np.linalg.norm(mesh.vertices[mesh.edges[:, 1]] - mesh.vertices[mesh.edges[:, 0]], axis=1)
    return mesh.edges, lengths, np.full(len(lengths), stiffness)


@functools.cache
def shaken() -> Start:
    """Return a sphere of 162 particles of 1 kg in all, their velocities, and where they truly are in the end."""
    mesh = softbody.icosphere(2, radius=RADIUS)
    velocity = np.random.default_rng(0).normal(0.0, 0.3, mesh.vertices.shape)
    body = *springs_of(mesh, STIFFNESS), mesh.triangles, GAS, 1.0 / len(mesh.vertices)
    end, _ = scipy.motion(mesh.vertices, velocity, *body, SECONDS)
    return mesh, velocity, end


@functools.cache
def bounced(stiffness: float) -> Start:
    """Return a ball of 42 particles of 1 kg in all, their velocities, and where they truly are in the end."""
    ball = softbody.icosphere(1, radius=RADIUS)
    turned = Rotation.from_rotvec((0.3, 0.7, 0.2)).apply(ball.vertices.copy())
    mesh = softbody.Mesh(turned + (0.0, 0.0, HEIGHT), ball.triangles)
    velocity = np.cross((0.0, 2.0, 1.0), turned) - (0.0, 0.0, SPEED)
    springs, mass = springs_of(mesh, stiffness), 1.0 / len(turned)
    end, _ = ground.bounce(mesh.vertices, velocity, springs, mesh.triangles, GAS, mass, GRAVITY, BOUNCE_SECONDS)
    return mesh, velocity, end


def moving(world: softbody.World, start: Start, stiffness: float, step: float, steps: int) -> Ending:
    """Return a call that takes the body through its time, and how far from the truth it ends [of its radius]."""
    mesh, velocity, end = start
    body = world.add_soft_body(mesh, 1.0, stiffness, GAS, friction=0.0, damping=0.0)

    def call() -> np.ndarray:
        body.positions[:], body.velocities[:] = mesh.vertices, velocity
        world.step(step, steps, allow_unstable=True)
        return body.positions

    return call, float(np.linalg.norm(call() - end, axis=1).max()) / RADIUS


@Benchmark(
    Row("Work and precision of the integrators", "steps", "particle and simulated second", OURS, OTHERS),
    sizes={"quick": STEPS},
)
def bench_work_precision(race, steps: int) -> None:
    """The same time in more and more steps."""
    weightless = {name: softbody.World(gravity=(0.0, 0.0, 0.0), integrator=name) for name in INTEGRATORS}
    calls = {name: moving(world, shaken(), STIFFNESS, SECONDS / steps, steps) for name, world in weightless.items()}
    compare(race, calls, len(shaken()[0].vertices) * SECONDS, steps)


@Benchmark(
    Row("Work and precision: a ball of springs of * N/m bounces", "steps", "simulated second", OURS, OTHERS),
    sizes={"quick": tuple(product(FEWEST, PARTS))},
)
def bench_bounce(race, stiffness: float, parts: int) -> None:
    """The same bounce in more and more steps."""
    steps, calls = parts * FEWEST[stiffness], {}
    for name in INTEGRATORS:
        world = softbody.World(gravity=(0.0, 0.0, -GRAVITY), integrator=name)
        world.add_ground(friction=0.0)
        calls[name] = moving(world, bounced(stiffness), stiffness, BOUNCE_SECONDS / steps, steps)
    table = f"Work and precision: a ball of springs of {stiffness:g} N/m bounces"
    compare(race, calls, BOUNCE_SECONDS, steps, table=table)


def compare(race, calls: dict[str, Ending], units: float, steps: int, **table: str) -> None:
    """Time the calls in turns; their errors stand beside them."""
    peers = {name: (calls[name][0], units) for name in OTHERS}
    errors = {name: error for name, (_, error) in calls.items()}
    race(calls[OURS][0], units, size=steps, peers=peers, errors=errors, **table)
