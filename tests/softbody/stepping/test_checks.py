"""Is a world stopped before it goes wrong, or where it does, and is the culprit named?"""

import re
import warnings

import numpy as np
import pytest

import softbody
from softbody import MassRatioWarning, OverlapWarning, OverloadWarning, ParameterError, SimulationError, World
from softbody.model.settings import INTEGRATORS
from softbody.stepping.checks import STABLE_FOR
from tests.same_bits import same_bits

pytestmark = pytest.mark.interpreted

BALL = softbody.icosphere(1)
SOLID = softbody.octahedron()

integrators = pytest.mark.parametrize("integrator", INTEGRATORS)


@integrators
def test_a_step_above_the_stable_one_is_refused_with_the_number_to_use(integrator):
    world = World(integrator=integrator)
    world.add_soft_body(SOLID, 1.0, 10.0, 1.0)
    stable = world.stable_time_step()
    before = world.state.copy()
    with pytest.raises(ParameterError, match=rf"a stable time step here is {stable:.6g} s .* or substeps=3, or say"):
        world.step(2.5 * stable)
    assert same_bits(world.state, before)
    world.step(2.5 * stable, substeps=3)
    world.step(1.1 * stable, allow_unstable=True)
    assert world.steps == 2


def test_more_gas_makes_the_stable_step_shorter_at_once():
    world = World()
    body = world.add_soft_body(SOLID, 1.0, 10.0, 1.0)
    h = world.stable_time_step()
    world.step(h)
    body.gas = 1000.0
    with pytest.raises(ParameterError, match="stable"):
        world.step(h)


@pytest.mark.parametrize("often", [2, 1000])
def test_springs_changed_again_and_again_between_steps_are_looked_at(often):
    """The guard knows the model that it has seen, and not only where in memory that one was: another may lie there."""
    world = World()
    body = world.add_soft_body(SOLID, 1.0, 10.0, 1.0)
    h = 0.9 * world.stable_time_step()
    world.step(h)
    place = id(world.model)
    body.set_springs(stiffness=11.0)
    for _ in range(1, often):
        body.set_springs(stiffness=10_000.0)
        if id(world.model) == place:
            break
    before = world.state_hash()
    with pytest.raises(ParameterError, match="a stable time step here is"):
        world.step(h)
    assert world.state_hash() == before


def test_an_estimate_of_the_stable_step_is_made_anew_after_some_steps_and_for_another_integrator():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(SOLID, 1.0, 10.0, 1.0)
    h = 0.9 * world.stable_time_step()
    world.step(h, STABLE_FOR)
    body.positions[:] *= 0.1  # its gas is a thousand times stiffer
    with pytest.raises(ParameterError, match="stable"):
        world.step(h)
    world = World(integrator="rk4")
    world.add_soft_body(SOLID, 1.0, 10.0, 1.0)
    h = 0.9 * world.stable_time_step()
    world.step(h)
    world.integrator = "symplectic_euler"
    with pytest.raises(ParameterError, match=r"stable .* with symplectic_euler"):
        world.step(h)


@integrators
def test_too_long_a_time_step_stops_at_the_last_good_step(integrator):
    """… which is the very state that the steps before it lead to."""

    def jolted():
        world = World(gravity=(0.0, 0.0, 0.0), integrator=integrator)
        world.add_soft_body(BALL, 1.0, 100.0, 5.0)
        world.state.particle_velocity[:] = np.random.default_rng(1).normal(0.0, 0.1, (42, 3))
        return world

    world = jolted()
    stable = world.stable_time_step()
    with pytest.raises(SimulationError, match=r"soft body 0 (diverged|collapsed).* step \d+; a stable time") as caught:
        world.step(3.0 * stable, 10000, allow_unstable=True)
    error = caught.value
    assert (error.step, error.body) == (world.steps, "soft body 0")
    assert 0 < error.step < 10000
    assert error.stable_time_step == world.stable_time_step() < 3.0 * stable
    assert all(np.isfinite(array).all() for array in world.state)
    again = jolted()
    again.step(3.0 * stable, error.step, allow_unstable=True)
    assert same_bits(world.state, again.state)


def test_the_error_names_the_body_that_diverged_not_its_neighbour():
    world = World(gravity=(0.0, 0.0, 0.0))
    world.add_soft_body(SOLID, 1.0, 1.0, 0.1)
    stiff = world.add_soft_body(SOLID, 1.0, 1e6, 0.1, position=(5.0, 0.0, 0.0))
    stiff.velocities[0] += 0.01
    with pytest.raises(SimulationError, match="soft body 1") as caught:
        world.step(0.05, 1000, allow_unstable=True)
    assert caught.value.body == "soft body 1"


def test_a_body_crushed_flat_by_its_load_collapses_by_name():
    world = World(gravity=(0.0, 0.0, -100.0))
    world.add_ground()
    world.add_soft_body(SOLID, 1.0, 1.0, 0.0, position=(0.0, 0.0, 1.0))
    with pytest.raises(SimulationError, match=r"soft body 0 collapsed .* raise gas or stiffness") as caught:
        world.step(1e-3, 10000)
    assert caught.value.body == "soft body 0"
    assert caught.value.step == world.steps > 0
    assert np.isfinite(world.state.particle_position).all()
    assert world.time == pytest.approx(world.steps * 1e-3)


def test_a_body_in_fast_flight_has_not_diverged():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(SOLID, 1.0, 10.0, 1.0, velocity=(1e6, 0.0, 0.0))
    world.step(1e-3, 100)
    assert body.centre[0] == pytest.approx(1e5, rel=1e-9)


def test_particles_that_are_not_finite_are_found_before_the_first_step():
    world = World()
    body = world.add_soft_body(SOLID, 1.0, 1.0, 1.0)
    body.positions[3] = np.nan
    with pytest.raises(ParameterError, match="position of particle 3 of soft body 0 is not finite"):
        world.step(1e-3, 10)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda w, b, box: b.velocities.__setitem__((3, 1), np.nan), "velocity of particle 3 of soft body 0 is not"),
        (lambda w, b, box: b.external_force.__setitem__((2, 0), np.inf), "external_force of particle 2 of soft body 0"),
        (lambda w, b, box: w.controls.box_force.__setitem__((1, 2), np.nan), "force of box 1 is not finite"),
        (lambda w, b, box: box.velocity.__setitem__(0, np.nan), "velocity of box 1 is not finite"),
    ],
)
def test_numbers_that_are_not_finite_are_named_before_a_step_is_taken(spoil, message):
    world = World()
    body = world.add_soft_body(softbody.tetrahedron(), 1.0, 50.0, 5.0)
    body.external_force = (0.0, 0.0, 1.0)
    world.add_box((1.0, 1.0, 1.0), 1.0, (5.0, 0.0, 0.0))
    box = world.add_box((1.0, 1.0, 1.0), 1.0, (9.0, 0.0, 0.0))
    spoil(world, body, box)
    before = world.state_hash()
    with pytest.raises(ParameterError, match=message):
        world.step(1e-3)
    assert world.state_hash() == before


def test_bodies_that_start_deep_inside_each_other_are_named():
    world = World(gravity=(0.0, 0.0, 0.0))
    ball = softbody.icosphere(2)
    world.add_soft_body(ball, 1.0, 50.0, 5.0)
    world.add_soft_body(ball, 1.0, 50.0, 5.0, (1.5, 0.0, 0.0))
    with pytest.warns(OverlapWarning, match=r"soft body 0 and soft body 1 start 0\.\d+ m inside each other"):
        world.step(1e-3, 3)
    world.step(1e-3, 3)  # once is enough
    world = World(gravity=(0.0, 0.0, 0.0))
    world.add_soft_body(ball, 1.0, 50.0, 5.0)
    world.step(1e-3, 3)
    world.add_box((0.3, 0.3, 0.3), 1.0, (-0.7, 0.0, 0.0))
    with pytest.warns(OverlapWarning, match=r"soft body 0 and box 0 start 0\.\d+ m inside each other"):
        world.step(1e-3)


def carrying(mass, times, kind):
    """Let a box of `mass` [kg] on the ground carry a body of so many times its mass for a step."""
    world = World()
    world.add_ground()
    world.add_box((1.0, 1.0, 0.2), mass, (0.0, 0.0, 0.1))
    if kind == "soft body":
        world.add_soft_body(softbody.box((0.5, 0.5, 0.5), 2), mass * times, 300.0, 20.0, (0.0, 0.0, 0.4499))
    else:
        world.add_box((0.5, 0.5, 0.5), mass * times, (0.0, 0.0, 0.45))
    world.step(1e-3)


@pytest.mark.parametrize(("kind", "most"), [("soft body", 1e4), ("box", 1e6)])
def test_a_box_that_carries_too_much_is_named_with_its_load(kind, most):
    name = f"box 0 carries {'soft body 0' if kind == 'soft body' else 'box 1'}, {1.1 * most:.3g} times its own mass"
    with pytest.warns(MassRatioWarning, match=re.escape(name)):
        carrying(1e-3, 1.1 * most, kind)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        carrying(1e-3, 0.9 * most, kind)


def test_what_lies_on_a_heavier_body_or_only_beside_it_is_not_warned_of():
    world = World()
    world.add_ground()
    world.add_soft_body(softbody.box((1.0, 1.0, 0.5), 2), 1.0, 300.0, 20.0, (0.0, 0.0, 0.25))
    world.add_box((0.2, 0.2, 0.2), 1e-6, (0.0, 0.0, 0.5999))
    world.add_box((0.2, 0.2, 0.2), 1e-6, (0.5999, 0.0, 0.25))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        world.step(1e-4)


def test_nine_tenths_of_the_stable_step_are_always_taken_whatever_has_moved():
    """An estimate from before would refuse: as the gas expands, ever longer steps are stable."""
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(SOLID, 1.0, 10.0, 5.0)
    body.positions[:] *= 0.15
    first = world.stable_time_step()
    for _ in range(60):
        world.step(0.9 * world.stable_time_step())
    assert world.stable_time_step() > 2.0 * first


def test_particles_that_somebody_moves_between_steps_are_looked_at():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(SOLID, 1.0, 10.0, 1.0)
    h = 0.9 * world.stable_time_step()
    world.step(h)
    body.positions[:] *= 0.1
    with pytest.raises(ParameterError, match="a stable time step here is"):
        world.step(h)
    body.positions[:] *= 10.0
    world.step(h)
    assert world.steps == 2


@pytest.mark.parametrize("gas", [0.0, 1.0])
def test_a_flat_body_has_no_stable_step_and_is_named(gas):
    world = World()
    world.add_soft_body(SOLID, 1.0, 10.0, gas)
    flat = world.add_soft_body(SOLID, 1.0, 10.0, gas, (5.0, 0.0, 0.0))
    flat.positions[:, 2] = 0.0
    for ask in (world.stable_time_step, lambda: world.step(1e-3)):
        with pytest.raises(ParameterError, match=r"no time step is stable: soft body 1 is flat and has no volume"):
            ask()
    with pytest.raises(SimulationError, match=r"soft body 1 .* in step 0") as caught:
        world.step(1e-3, allow_unstable=True)
    assert (caught.value.stable_time_step, world.steps) == (0.0, 0)


def test_a_body_too_light_for_its_springs_has_no_stable_step_and_is_named():
    world = World()
    world.add_soft_body(SOLID, 1e-300, 1e100, 1.0)
    with pytest.raises(ParameterError, match=r"no time step is stable: soft body 0 is too light for its springs"):
        world.step(1e-3)


def test_the_last_good_state_is_a_bounded_one_and_the_step_that_is_named_helps():
    world = World(integrator="rk4_velocity")  # by symplectic Euler it collapses at once
    world.add_soft_body(softbody.icosphere(2, 0.5), 1.0, 200.0, 30.0)
    with pytest.raises(
        SimulationError, match=r"soft body 0 diverged in step \d+; a stable time step here is"
    ) as caught:
        world.run(2.0, 0.05, allow_unstable=True)
    assert np.ptp(world.state.particle_position, axis=0).max() < 1e4
    world.step(0.9 * caught.value.stable_time_step, 100)
    assert world.steps == caught.value.step + 100


def two_boxes():
    world = World()
    world.add_box((1.0, 1.0, 1.0), 1.0)
    return world, world.add_box((1.0, 1.0, 1.0), 1.0, (5.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda box: box.orientation.__setitem__(slice(4), 0.0), "orientation of box 1 is .* no unit quaternion"),
        (
            lambda box: box.angular_velocity.__setitem__(0, 1e160),
            r"angular_velocity of box 1 is 1e\+160 rad/s, too fast",
        ),
        (lambda box: box.velocity.__setitem__(0, 1e160), r"velocity of box 1 is 1e\+160 m/s, which a step of 0.001 s"),
        (lambda box: box.position.__setitem__(0, 1e30), "position of box 1 is .* its size is lost in rounding"),
    ],
)
def test_a_box_that_nothing_can_be_computed_of_is_refused_by_name(spoil, message):
    world, box = two_boxes()
    spoil(box)
    before = world.state_hash()
    with pytest.raises(ParameterError, match=message):
        world.step(1e-3, 10)
    assert (world.state_hash(), world.steps) == (before, 0)


@pytest.mark.compiled  # a box that is nowhere has a cell for compiled code only
def test_a_box_that_a_long_step_throws_out_of_all_numbers_is_found_and_a_step_that_helps_is_named():
    world, _ = two_boxes()
    before = world.state_hash()
    with pytest.raises(
        SimulationError, match=r"box 0 diverged in step 0; a stable time step here is 0\.\d+ s"
    ) as caught:
        world.step(1e200)
    assert (world.state_hash(), caught.value.body) == (before, "box 0")
    world.step(caught.value.stable_time_step)
    with pytest.raises(ParameterError, match=r"velocity of box 0 is .* take a shorter time step, such as"):
        world.step(1e200)
    assert world.steps == 1


def test_a_box_that_its_torque_spins_up_is_found_after_some_steps():
    world = World()
    world.add_box((1.0, 1.0, 1.0), 1.0).apply_torque((0.0, 0.0, 1e9))
    with pytest.raises(SimulationError, match="box 0 diverged in step"):
        world.step(1e-3, 1_000)
    assert np.isfinite(world.state.box_angular_velocity).all()
    assert 0 < world.steps < 1_000


@pytest.mark.compiled
def test_after_a_fault_a_world_goes_on_as_one_that_has_made_as_many_steps():
    """What the solver remembers of the contacts of boxes is that of the last good step, too."""

    def heap():
        world = World()
        world.add_ground()
        for k in range(3):
            world.add_box((1.0, 1.0, 0.5), 1.0, (0.05 * k, 0.0, 0.25 + 0.51 * k))
        weak = world.add_soft_body(SOLID, 1.0, 1.0, 0.0, (9.0, 0.0, 2.0))
        weak.external_force = (0.0, 0.0, -3.0)
        return world

    failing, good = heap(), heap()
    with pytest.raises(SimulationError, match="soft body 0 collapsed"):
        failing.step(1e-3, 10_000)
    good.step(1e-3, failing.steps)
    for world in (failing, good):
        softbody.SoftBody(world, 0).gas = 10.0
        world.step(1e-4, 20)
    assert failing.time == good.time
    assert failing.state_hash() == good.state_hash()


def test_the_step_that_helps_helps_all_bodies():
    world = World(gravity=(0.0, 0.0, 0.0))
    world.add_soft_body(softbody.octahedron(), 1.0, 1e4, 1.0)
    world.add_box(
        (1e-3, 1e-3, 1e-3), 1.0, (5.0, 0.0, 0.0), velocity=(100.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, 1e4)
    )
    with pytest.raises(SimulationError) as caught:
        world.step(0.5, 100, allow_unstable=True)
    assert caught.value.body == "soft body 0"
    assert 0.0 < caught.value.stable_time_step <= 1e-5


@pytest.mark.filterwarnings("ignore::softbody.OverlapWarning")
def test_a_particle_that_a_contact_throws_farther_than_its_body_may_be_long_is_found_in_that_step():
    """A body of a billion metres and one of four: what rounds the large one is as large as the small one."""
    world = World()
    place, velocity = (0.0, 0.0, 0.7068), (-0.0034, -0.644, -1.054)
    small = world.add_soft_body(softbody.icosphere(1).scaled(2.126), 0.00589, 64.4, 29.9, place, velocity)
    huge, velocity = softbody.box((1.0, 0.5, 2.0), 2).scaled(2.16777344e9), (1.266, 0.6927, 1.61)
    world.add_soft_body(huge, 6.13e152, 142.0, 0.0, (0.0, 0.0, 2.045), velocity, damping=3.7e7)
    before = small.positions.copy()
    with pytest.raises(SimulationError, match="soft body 0 diverged in step 0") as caught:
        world.step(0.9 * world.stable_time_step())
    assert caught.value.body == "soft body 0"
    np.testing.assert_array_equal(small.positions, before)


def jaws_on_a_box(step):
    """A rigid box between jaws of a fifth of its size, of which each closes by `step` of its thickness in a step."""
    world = World(gravity=(0.0, 0.0, 0.0))
    world.add_box((0.1, 0.1, 0.1), 1.0)
    for side in (-1.0, 1.0):
        world.add_box((0.02, 0.2, 0.2), None, (side * 0.06, 0.0, 0.0), velocity=(-side * step * 0.02, 0.0, 0.0))
    return world


def test_what_is_pressed_is_named_once_at_the_first_step_and_a_step_that_goes_through_is_undone():
    world = jaws_on_a_box(0.02)
    with pytest.warns(OverloadWarning, match=r"box \d and box \d are pressed 0\.\d+ m .* N since step \d+: 2[5-9]% of"):
        world.step(1.0, 14, allow_unstable=True)
    hashes = [world.state_hash()]

    def go_on():
        while world.steps < 40:
            world.step(1.0, allow_unstable=True)
            hashes.append(world.state_hash())

    with warnings.catch_warnings():
        warnings.simplefilter("error", OverloadWarning)
        with pytest.raises(SimulationError, match=r"are pressed 0\.01\d* m .*: more than 50%"):
            go_on()
    assert (world.steps, world.state_hash()) == (13 + len(hashes), hashes[-1])


def test_what_starts_inside_is_neither_told_nor_stopped():
    world = jaws_on_a_box(0.02)
    for jaw, side in zip(world.boxes[1:], (-1.0, 1.0)):
        jaw.position = (side * 0.053, 0.0, 0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error", OverloadWarning)
        world.step(1.0, 12, allow_unstable=True)


def test_what_starts_inside_goes_on_where_steps_are_taken_in_parts():
    world = jaws_on_a_box(0.02)
    for jaw, side in zip(world.boxes[1:], (-1.0, 1.0)):
        jaw.position = (side * 0.057, 0.0, 0.0)
    world.add_box((20.0, 0.1, 0.1), None, (0.0, 0.0, 30.0))
    world.add_soft_body(SOLID, 1.0, 0.0, 0.0, (3.0, 0.0, 33.0), (-0.08, 0.0, 0.0))  # along the box, and never on it
    world.step(1.0, 8, allow_unstable=True)  # past the middle in the fifth
    assert world.store.clock.part[0] < 1.0
