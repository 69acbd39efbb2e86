"""Do bodies move the same alone and together, in one go and in many, and is the one that fails named?"""

import numba
import numpy as np
import pytest

import softbody
from softbody import ParameterError, SimulationError, SoftBody, World
from softbody.dynamics.soft_bodies import (
    COLLAPSED,
    DIVERGED,
    LARGE,
    LOOK,
    even_cut,
    find_fault,
    motion_of,
    move_in_place,
    move_soft_bodies,
)
from softbody.dynamics.vertex_rings import BLOCK, build_rings
from softbody.model.arrays import soft_bodies_of
from softbody.model.settings import INTEGRATORS
from softbody.stepping.step import run_alone

SOLID = softbody.octahedron()

several = pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="there is one thread here")

integrators = pytest.mark.parametrize("integrator", INTEGRATORS)


RINGS = build_rings(6, SOLID.edges, SOLID.triangles, np.ones(12), np.ones(12))


@pytest.fixture
def rows():
    """An octahedron at rest, by index: positions, then velocities, (6, 8), of which the last two are twins."""
    return np.concatenate([SOLID.vertices[RINGS.particle].T, np.zeros((3, 8))])


def test_a_body_at_rest_is_without_fault(rows):
    assert find_fault(RINGS, 0, rows, 0.01, 1.0, 0.0) == 0


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("row", range(3, 6))
def test_a_velocity_that_is_not_finite_is_a_fault(rows, row, value):
    rows[row, 2] = value
    assert find_fault(RINGS, 0, rows, 0.01, 1.0, 0.0) == DIVERGED


@pytest.mark.parametrize("volume", [np.nan, np.inf, -np.inf])
def test_a_volume_that_is_not_finite_is_a_fault(rows, volume):
    assert find_fault(RINGS, 0, rows, 0.01, volume, 0.0) == DIVERGED


def test_a_particle_that_would_cross_its_body_in_one_step_is_a_fault(rows):
    """Extent 2 m, step 0.01 s: 200 m/s from the mean velocity, of which the particle itself takes a sixth."""
    limit = 200.0 * 6 / 5
    rows[5, 1] = 0.99 * limit
    assert find_fault(RINGS, 0, rows, 0.01, 1.0, 0.0) == 0
    rows[5, 1] = 1.01 * limit
    assert find_fault(RINGS, 0, rows, 0.01, 1.0, 0.0) == DIVERGED


@pytest.mark.parametrize(("volume", "least"), [(0.0, 0.0), (-1.0, 0.0), (0.1, 0.2)])
def test_a_body_without_enough_volume_has_collapsed(rows, volume, least):
    assert find_fault(RINGS, 0, rows, 0.01, volume, least) == COLLAPSED


def shaken(seeds, integrator="rk4_velocity"):
    """A world of balls, each shaken by its own seed."""
    world = World(gravity=(0.0, 0.0, 0.0), integrator=integrator)
    for seed in seeds:
        body = world.add_soft_body(softbody.icosphere(1), 1.0, 100.0, 5.0, position=(3.0 * seed, 0.0, 0.0))
        body.velocities[:] = np.random.default_rng(seed).normal(0.0, 0.5, (42, 3))
    return world


@pytest.mark.filterwarnings("ignore:soft bodies collide")
@integrators
def test_bodies_move_alone_as_they_do_together_to_the_same_bits(integrator):
    together = shaken([0, 1, 2], integrator)
    together.step(1e-3, 77)
    for seed in range(3):
        alone = shaken([seed], integrator)
        alone.step(1e-3, 77)
        rows = slice(42 * seed, 42 * (seed + 1))
        assert alone.state.particle_position.tolist() == together.state.particle_position[rows].tolist()


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize("spoiled", [None, 1])
def test_a_step_in_place_is_that_of_a_run_and_so_is_what_stops_it(precision, spoiled):
    ends, answers = [], []
    for move in (lambda *how: move_soft_bodies(*how, 1e-3, 1), lambda *how: move_in_place(*how, 1e-3, False)):
        world = World(precision=precision)
        for seed in range(3):
            ball = world.add_soft_body(softbody.icosphere(1), 1.0 + seed, 100.0, 5.0, position=(3.0 * seed, 0.0, 0.0))
            ball.velocities[:] = np.random.default_rng(seed).normal(0.0, 0.5, (42, 3))
        if spoiled is not None:
            world.state.particle_velocity[42 * spoiled + 3, 2] = np.inf
        motion = motion_of(world.model.soft_particle_start, world.store.rings)
        answers.append(move(soft_bodies_of(world.model, world.controls, world.state), motion, world.store.settings))
        ends.append([world.state.particle_position.tolist(), world.state.particle_velocity.tolist()])
    assert answers[0] == answers[1] == ((1, 0, -1) if spoiled is None else (0, DIVERGED, 1))
    if spoiled is None:  # else whoever asks has to put the bodies back
        assert ends[0] == ends[1]


@integrators
def test_a_run_in_parts_gives_the_same_bits(integrator):
    whole, parts = shaken([4], integrator), shaken([4], integrator)
    whole.step(1e-3, 2 * LOOK + 3)
    for steps in (1, 2, LOOK, LOOK):
        parts.step(1e-3, steps)
    assert whole.state.particle_position.tolist() == parts.state.particle_position.tolist()
    assert whole.state.particle_velocity.tolist() == parts.state.particle_velocity.tolist()


@integrators
def test_a_step_in_parts_is_as_many_steps(integrator):
    steps, parts = shaken([4], integrator), shaken([4], integrator)
    steps.step(1e-3, 30)
    parts.step(3e-3, 10, substeps=3)
    assert steps.state.particle_position.tolist() == parts.state.particle_position.tolist()
    assert parts.time == pytest.approx(steps.time)
    assert parts.steps == 10


@pytest.mark.filterwarnings("ignore:soft bodies collide")
@pytest.mark.parametrize("ground", [False, True])
@pytest.mark.parametrize("substeps", [1, 3])
def test_the_state_after_a_failure_is_that_of_the_last_good_step(ground, substeps):
    """The second body fails, with a step far too long; the first would not, but stops with it."""

    def world():
        world = World(gravity=(0.0, 0.0, 0.0))
        if ground:
            world.add_ground(-100.0)
        world.add_soft_body(SOLID, 1.0, 1.0, 0.1)
        stiff = world.add_soft_body(SOLID, 1.0, 100.0, 0.1, position=(5.0, 0.0, 0.0))
        stiff.velocities[0] = (0.0, 1e-9, 0.0)
        return world

    failing, good = world(), world()
    h = 1.5 * substeps * failing.stable_time_step()
    with pytest.raises(SimulationError, match=r"soft body 1 (diverged|collapsed).* in step") as error:
        failing.step(h, 10_000, substeps=substeps, allow_unstable=True)
    assert 1 < error.value.step < 10_000
    good.step(h, error.value.step, substeps=substeps, allow_unstable=True)
    assert good.state.particle_position.tolist() == failing.state.particle_position.tolist()
    with pytest.raises(SimulationError):
        good.step(h, 20, substeps=substeps, allow_unstable=True)


def three_balls(threads, precision="double"):
    world = World(gravity=(0.0, 0.0, 0.0), threads=threads, precision=precision)
    for x in (0.0, 2.5, 5.0):
        world.add_soft_body(softbody.icosphere(1), 1.0, 100.0, 5.0, position=(x, 0.0, 0.0))
    return world


def moved(world, h, steps):
    """Move the bodies of a world that do not meet, without contacts, which take long to compile for threads."""
    motion = motion_of(world.model.soft_particle_start, world.store.rings, world.threads)
    return run_alone(world.model, world.controls, world.state, motion, world.store.settings, h, steps)


@several
def test_threads_share_out_small_bodies_and_leave_every_bit():
    one, two = (three_balls(threads) for threads in (1, 2))
    for world in (one, two):
        moved(world, 1e-3, 50)
    assert one.state_hash() == two.state_hash()


@several
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_threads_share_out_one_large_body_and_leave_every_bit(integrator):
    hashes = set()
    for threads in (1, 2):
        world = World(threads=threads, integrator=integrator)
        body = world.add_soft_body(
            softbody.torus(1.0, 0.4, 130, 70), 1.0, 100.0, 5.0, damping=1e-4, drag=0.1, fixed=[5, 900]
        )
        body.external_force = np.linspace(-1e-3, 1e-3, 27_300).reshape(-1, 3)
        assert len(body.positions) > LARGE
        world.step(1e-4, 3)
        hashes.add(world.state_hash())
    assert len(hashes) == 1


def test_shares_of_a_body_are_about_even_and_miss_no_block():
    mesh = softbody.icosphere(5)
    rings = build_rings(len(mesh.vertices), mesh.edges, mesh.triangles, *np.ones((2, len(mesh.edges))))
    for shares in (1, 2, 3, 16):
        cut = even_cut(rings, 0, shares)
        assert cut[0] == 0
        assert cut[-1] == len(rings.block)
        first = np.append(rings.block[:, 0], rings.start[1])[cut]
        assert np.diff(first) == pytest.approx(rings.start[1] / shares, abs=BLOCK)


@several
def test_on_threads_the_body_that_fails_first_stops_all():
    failing, good = three_balls(2), three_balls(1)
    for world in (failing, good):
        SoftBody(world, 1).set_springs(stiffness=1e4)
    h = 2.0 * failing.stable_time_step()
    done, fault, body = moved(failing, h, 10_000)
    assert fault
    assert body == 1
    assert moved(good, h, done) == (done, 0, -1)
    assert good.state_hash() == failing.state_hash()


def test_single_precision_is_near_double_and_not_equal():
    double, single = (World(precision=precision) for precision in ("double", "single"))
    for world in (double, single):
        world.add_soft_body(softbody.icosphere(2), 1.0, 100.0, 5.0)
        world.step(1e-3, 200)
    apart = np.abs(double.state.particle_position - single.state.particle_position).max()
    assert 1e-9 < apart < 1e-5


def test_a_run_in_single_precision_in_parts_gives_the_same_bits():
    whole, parts = (World(precision="single") for _ in range(2))
    for world in (whole, parts):
        world.add_soft_body(softbody.icosphere(1), 1.0, 100.0, 5.0)
    whole.step(1e-3, 20)
    parts.step(1e-3, 7)
    resumed = World()
    resumed.restore(parts.snapshot())
    resumed.step(1e-3, 13)
    assert resumed.precision == "single"
    assert resumed.state_hash() == whole.state_hash()


def test_precision_and_threads_that_do_not_exist_are_refused():
    with pytest.raises(ParameterError, match="precision is 'half'; choose one of double, single"):
        World(precision="half")
    for threads in (0, 1.5, "two"):
        with pytest.raises(ParameterError, match=r"threads is .*; give a whole number ≥ 1"):
            World(threads=threads)
    most = numba.config.NUMBA_NUM_THREADS
    with pytest.raises(ParameterError, match=f"threads is {most + 1}, and there are {most} here"):
        World(threads=most + 1)


def test_a_leaking_body_is_reported_when_it_has_deflated():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(softbody.icosphere(1), 1.0, 50.0, 20.0, rest_length=0.3, deflated_below=0.5)

    def leak():
        for _ in range(200):
            body.gas *= 0.9
            world.step(1e-3, 50)

    with pytest.raises(SimulationError, match=r"soft body 0 collapsed \(deflated to 1\.") as error:
        leak()
    assert body.volume > 0.5 * softbody.icosphere(1).volume
    assert error.value.body == "soft body 0"
