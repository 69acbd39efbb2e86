"""Does a world take what is right, refuse what is wrong by name, and move as physics says?"""

import numpy as np
import pytest

import softbody
from softbody import OverlapWarning, ParameterError, SimulationError, World
from softbody.dynamics.integrators import INTEGRATORS

G = 9.81
BALL = softbody.icosphere(1)
SOLID = softbody.octahedron()

integrators = pytest.mark.parametrize("integrator", INTEGRATORS)


def everything(integrator="rk4_velocity", axes="complete"):
    """A ball with gas that falls on the ground beside two boxes that collide."""
    world = World(integrator=integrator, axes=axes)
    world.add_ground(restitution=0.3)
    world.add_soft_body(BALL, 1.0, 200.0, 5.0, position=(5.0, 0.0, 1.2), velocity=(0.5, 0.0, -1.0))
    world.add_box((1.0, 1.0, 1.0), 2.0, (0.0, 0.0, 1.0), velocity=(1.0, 0.1, 0.0), angular_velocity=(0.1, 0.2, 0.3))
    world.add_box((1.0, 2.0, 1.0), 3.0, (1.4, 0.2, 1.1), velocity=(-1.0, 0.0, 0.0), restitution=0.5)
    return world


def same(a, b):
    return all((x == y).all() for x, y in zip(a, b))


# ---- what moves, moves as it must ----


def test_a_ball_dropped_on_the_ground_comes_to_rest_above_it_near_its_free_volume():
    world, free = World(), World(gravity=(0.0, 0.0, 0.0))
    world.add_ground(height=1.0)
    ball = world.add_soft_body(BALL, 1.0, 200.0, 5.0, position=(0.0, 0.0, 3.0))
    floating = free.add_soft_body(BALL, 1.0, 200.0, 5.0)
    world.step(0.0045, 10000)
    free.step(0.0045, 10000)
    assert np.abs(ball.velocities).max() < 1e-9
    assert ball.positions[:, 2].min() == 1.0
    assert 0.95 * floating.volume < ball.volume < floating.volume  # its weight squeezes it a little
    assert ball.pressure == pytest.approx(5.0 / ball.volume, rel=1e-15)


@pytest.mark.parametrize("size", [(1.0, 1.0, 1.0), (1.0, 2.0, 0.5), (0.2, 0.3, 1.0)])
@pytest.mark.parametrize("h", [1e-3, 1e-2])
def test_a_box_at_rest_on_the_ground_stays_where_it_is(size, h):
    world = World()
    world.add_ground()
    box = world.add_box(size, 2.0, position=(3.0, 4.0, size[2] / 2))
    world.step(h, 2000)
    # What sixteen rounds of impulses leave of g h: nothing but for the tower of 0.2 : 0.3 : 1.
    assert box.position == pytest.approx([3.0, 4.0, size[2] / 2], abs=2e-5)
    assert box.orientation == pytest.approx([1.0, 0.0, 0.0, 0.0], abs=2e-5)
    assert np.abs(box.velocity).max() < 2e-5


def test_a_small_box_stays_where_it_is_on_a_wide_plate():
    world = World()
    world.add_box((20.0, 20.0, 1.0), None, position=(0.0, 0.0, -0.5))
    box = world.add_box((1.0, 1.0, 1.0), 2.0, position=(5.0, 3.0, 0.5))
    world.step(1e-3, 2000)
    assert box.position == pytest.approx([5.0, 3.0, 0.5], abs=1e-4)
    assert np.abs(box.angular_velocity).max() < 1e-3


def test_a_box_dropped_flat_comes_to_rest_where_it_fell():
    world = World()
    world.add_ground(restitution=0.5)
    box = world.add_box((1.0, 1.0, 1.0), 2.0, position=(0.0, 0.0, 2.0))
    world.step(1e-3, 6000)
    assert box.position == pytest.approx([0.0, 0.0, 0.5], abs=1e-3)
    assert abs(box.orientation[0]) == pytest.approx(1.0, abs=1e-6)


@integrators
def test_the_centre_of_mass_falls_as_the_integrator_says(integrator):
    """RK4 is exact on a parabola; the other two move with the velocity at the end of the step."""
    h, n = 0.005, 200
    world = World(gravity=(0.0, 0.0, -G), integrator=integrator)
    body = world.add_soft_body(BALL, 1.0, 100.0, 3.0, position=(0.0, 0.0, 9.0), velocity=(1.0, 2.0, 3.0))
    world.step(h, n)
    t = n * h
    fall = 0.5 * G * t**2 if integrator == "rk4" else 0.5 * G * h**2 * n * (n + 1)
    assert body.centre == pytest.approx([t, 2.0 * t, 9.0 + 3.0 * t - fall], abs=1e-11)
    assert body.velocities.mean(axis=0) == pytest.approx([1.0, 2.0, 3.0 - G * t], abs=1e-11)


def test_a_box_falls_by_euler_cromer():
    h, n = 0.01, 100
    world = World(gravity=(0.0, 0.0, -G))
    box = world.add_box((1.0, 1.0, 1.0), 1.0, velocity=(1.0, 2.0, 3.0))
    world.step(h, n)
    assert box.position == pytest.approx([1.0, 2.0, 3.0 - 0.5 * G * h**2 * n * (n + 1)], abs=1e-12)


def test_boxes_that_collide_in_space_keep_their_momentum():
    world = World(gravity=(0.0, 0.0, 0.0))
    world.add_box((1.0, 1.0, 1.0), 2.0, (-1.0, 0.2, 0.1), velocity=(1.0, 0.0, 0.0), angular_velocity=(0.3, 0.2, 0.1))
    world.add_box((1.0, 2.0, 1.0), 5.0, (1.0, 0.0, 0.0), velocity=(-1.0, 0.0, 0.0), restitution=0.5)
    momentum, energy = world.linear_momentum(), world.energy()
    world.step(1e-3, 1500)
    assert world.linear_momentum() == pytest.approx(momentum, abs=1e-13)
    assert world.energy() < energy
    assert world.state.box_velocity[0, 0] < 0.0


def test_angular_momentum_of_boxes_in_a_collision_changes_only_by_the_separation():
    """Parting positions by a depth of h times the speed moves masses a little: less for a shorter step."""
    drifts = []
    for h in (1e-3, 1e-4):
        world = World(gravity=(0.0, 0.0, 0.0))
        world.add_box((1.0, 1.0, 1.0), 2.0, (-1.0, 0.2, 0.1), velocity=(1.0, 0.0, 0.0))
        world.add_box((1.0, 1.0, 1.0), 2.0, (1.0, 0.0, 0.0), velocity=(-1.0, 0.0, 0.0))
        before = world.angular_momentum()
        world.step(h, round(1.0 / h))
        assert world.state.box_velocity[0, 0] > -0.9  # they met
        drifts.append(np.linalg.norm(world.angular_momentum() - before))
    assert drifts[0] < 0.01
    assert drifts[1] < 0.01


def test_changing_the_gas_between_steps_inflates_the_body():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(SOLID, 1.0, 100.0, 1.0)
    world.step(0.005, 4000)
    thin = body.volume
    body.gas = 100.0
    world.step(0.005, 4000)
    assert body.gas == 100.0
    assert body.volume > 1.1 * thin


def test_an_inflated_regular_solid_settles_at_the_closed_form_scale():
    """λ² − λ = 3 nRT / (k Σ l0²): here 12 edges of √2, so λ = (1 + √3)/2 for nRT = k Σ l0² / 6."""
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(SOLID, 1.0, 50.0, 50.0 * 24.0 / 6.0)
    world.step(0.005, 6000)
    assert (body.volume / SOLID.volume) ** (1 / 3) == pytest.approx((1 + 3**0.5) / 2, rel=1e-9)


def test_a_body_crushed_flat_by_its_load_collapses_by_name():
    world = World(gravity=(0.0, 0.0, -100.0))
    world.add_ground()
    world.add_soft_body(SOLID, 1.0, 1.0, 0.0, position=(0.0, 0.0, 1.0))
    with pytest.raises(SimulationError, match=r"soft body 0 collapsed .* raise gas or stiffness") as caught:
        world.step(1e-3, 10000)
    assert caught.value.body == "soft body 0"
    assert caught.value.step == world.steps > 0
    assert np.isfinite(world.state.position).all()
    assert world.time == pytest.approx(world.steps * 1e-3)


# ---- the same bits ----


def test_two_worlds_stepped_alike_are_alike_to_the_bit():
    one, other = everything(), everything()
    for world in (one, other):
        world.step(1e-3, 500)
    assert same(one.state, other.state)
    assert not same(one.state, everything().state)


@integrators
def test_many_steps_at_once_are_as_many_single_steps_to_the_bit(integrator):
    at_once, singly = everything(integrator), everything(integrator)
    at_once.step(1e-3, 300)
    for _ in range(300):
        singly.step(1e-3)
    assert same(at_once.state, singly.state)
    assert at_once.steps == singly.steps == 300
    assert at_once.time == pytest.approx(singly.time, rel=1e-12)


def test_running_for_some_seconds_is_stepping_that_often():
    one, other = World(), World()
    for world in (one, other):
        world.add_soft_body(SOLID, 1.0, 10.0, 1.0)
    one.run(0.1, 1e-3)
    other.step(1e-3, 100)
    assert one.steps == 100
    assert same(one.state, other.state)


def test_no_steps_change_nothing():
    world = World()
    world.add_soft_body(SOLID, 1.0, 10.0, 1.0)
    before = world.state.copy()
    world.step(1e-3, 0)
    assert same(world.state, before)


def test_an_empty_world_can_be_stepped():
    world = World()
    world.step(1e-3, 5)
    assert (world.steps, world.time) == (5, 0.005)


# ---- bodies ----


def test_bodies_added_later_join_in_and_leave_the_earlier_ones_alone():
    world = World()
    first = world.add_soft_body(SOLID, 1.0, 10.0, 1.0, position=(0.0, 0.0, 5.0))
    world.step(1e-3, 100)
    moved = first.positions.copy()
    second = world.add_soft_body(BALL, 2.0, 20.0, 2.0, position=(9.0, 0.0, 5.0))
    box = world.add_box((1.0, 1.0, 1.0), 1.0, position=(-9.0, 0.0, 0.0))
    assert first.positions.tolist() == moved.tolist()
    assert second.positions == pytest.approx(BALL.vertices + [9.0, 0.0, 5.0])
    world.step(1e-3, 100)
    alone = World()
    twin = alone.add_soft_body(SOLID, 1.0, 10.0, 1.0, position=(0.0, 0.0, 5.0))
    alone.step(1e-3, 200)
    assert first.positions.tolist() == twin.positions.tolist()
    assert second.centre[2] < 5.0
    assert box.position[2] < 0.0
    assert (first.gas, second.gas) == (1.0, 2.0)


def test_a_soft_body_starts_at_rest_in_the_shape_of_its_mesh_where_it_was_put():
    world = World()
    body = world.add_soft_body(BALL, 3.0, 10.0, 6.0, position=(1.0, 2.0, 3.0), velocity=(4.0, 5.0, 6.0))
    assert body.centre == pytest.approx([1.0, 2.0, 3.0], abs=1e-14)
    assert body.velocities.tolist() == [[4.0, 5.0, 6.0]] * 42
    assert body.volume == pytest.approx(BALL.volume, rel=1e-13)
    assert body.pressure == pytest.approx(6.0 / BALL.volume, rel=1e-13)
    assert world.linear_momentum() == pytest.approx([12.0, 15.0, 18.0], rel=1e-13)
    lengths = np.linalg.norm(np.diff(BALL.vertices[BALL.edges], axis=1)[:, 0], axis=1)
    assert world.model.rest_length == pytest.approx(lengths, rel=1e-13)


def test_a_stiffness_for_each_edge_is_kept_in_the_order_of_the_edges():
    world = World()
    world.add_soft_body(SOLID, 1.0, np.arange(12.0), 0.0)
    assert world.model.stiffness.tolist() == list(range(12))
    assert world.model.edges.tolist() == SOLID.edges.tolist()


def test_a_world_does_not_share_memory_with_the_arrays_it_was_given():
    stiffness, position, gravity = np.ones(12), np.zeros(3), np.array([0.0, 0.0, -G])
    world = World(gravity=gravity)
    world.add_soft_body(SOLID, 1.0, stiffness, 0.0, position=position)
    stiffness[:], position[:], gravity[:] = 9.0, 9.0, 9.0
    world.state.position[:] += 1.0
    assert world.model.stiffness.tolist() == [1.0] * 12
    assert world.model.gravity.tolist() == [0.0, 0.0, -G]
    assert SOLID.vertices[0].tolist() == [1.0, 0.0, 0.0]


def test_a_box_shows_what_it_was_given():
    world = World()
    box = world.add_box((1.0, 2.0, 3.0), 12.0, (1.0, 2.0, 3.0), (0.6, 0.8, 0.0, 0.0), (4.0, 5.0, 6.0), (7.0, 8.0, 9.0))
    assert box.position.tolist() == [1.0, 2.0, 3.0]
    assert box.orientation == pytest.approx([0.6, 0.8, 0.0, 0.0], rel=1e-15)
    assert box.velocity.tolist() == [4.0, 5.0, 6.0]
    assert box.angular_velocity.tolist() == [7.0, 8.0, 9.0]
    assert 1.0 / world.model.box_inverse_inertia[0] == pytest.approx([13.0, 10.0, 5.0], rel=1e-15)


def test_a_quaternion_rounded_to_single_precision_is_taken_and_made_unit():
    world = World()
    box = world.add_box((1.0, 1.0, 1.0), 1.0, orientation=np.full(4, 0.5, np.float32) * np.float32(1 + 3e-7))
    assert np.linalg.norm(box.orientation) == pytest.approx(1.0, abs=1e-15)


def test_a_second_ground_replaces_the_first():
    world = World()
    world.add_ground(height=1.0)
    world.add_ground(height=-2.0, restitution=0.5, friction=0.1)
    model = world.model
    assert (model.ground_height, model.ground_restitution, model.ground_friction) == (-2.0, 0.5, 0.1)


def test_a_box_that_falls_on_a_soft_body_comes_to_rest_on_it():
    world = World()
    world.add_ground()
    ball = world.add_soft_body(BALL, 1.0, 400.0, 30.0, position=(0.0, 0.0, 1.0))
    box = world.add_box((3.0, 3.0, 0.2), 0.5, position=(0.0, 0.0, 2.4))
    world.run(3.0, 0.8 * world.stable_time_step())
    assert ball.positions[:, 2].max() <= box.position[2] - 0.1 + 0.02
    assert 1.0 < box.position[2] < 2.3
    assert np.abs(box.velocity).max() < 0.3


def test_two_soft_bodies_bounce_off_each_other_and_keep_their_momentum():
    world = World(gravity=(0.0, 0.0, 0.0))
    left = world.add_soft_body(BALL, 1.0, 200.0, 5.0, velocity=(1.0, 0.0, 0.0), restitution=0.5)
    right = world.add_soft_body(BALL, 3.0, 200.0, 5.0, position=(2.5, 0.1, 0.0), velocity=(-1.0, 0.0, 0.0))
    before = world.linear_momentum()
    world.run(2.0, 0.5 * world.stable_time_step())
    np.testing.assert_allclose(world.linear_momentum(), before, atol=1e-12)
    assert left.velocities.mean(axis=0)[0] < 0.0
    assert right.centre[0] - left.centre[0] > 1.8


def test_the_papers_axes_let_boxes_collide_that_do_not_touch():
    """Two cubes on edge, crosswise, 0.036 m apart: only the edge–edge axis sees the gap."""
    s, c = np.sin(np.pi / 8), np.cos(np.pi / 8)
    moved = {}
    for axes in ("complete", "paper"):
        world = World(gravity=(0.0, 0.0, 0.0), axes=axes)
        world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 1.45), (c, s, 0.0, 0.0), velocity=(0.0, 0.0, -1e-3))
        world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 0.0), (c, 0.0, s, 0.0))
        world.step(1e-3)
        moved[axes] = np.abs(world.state.box_position - [[0.0, 0.0, 1.45], [0.0, 0.0, 0.0]]).max()
    assert moved["complete"] < 1e-5
    assert moved["paper"] > 1e-3


# ---- what is refused ----

NAN, INF = float("nan"), float("inf")

SOFT = {"mesh": SOLID, "mass": 1.0, "stiffness": 10.0, "gas": 1.0}
BAD_SOFT = [
    ("mass", 0.0),
    ("mass", -1.0),
    ("mass", NAN),
    ("mass", INF),
    ("mass", None),
    ("mass", "heavy"),
    ("mass", 1j),
    ("mass", 10**400),
    ("stiffness", -1.0),
    ("stiffness", NAN),
    ("stiffness", INF),
    ("stiffness", np.ones(11)),
    ("stiffness", np.ones((12, 1))),
    ("stiffness", "stiff"),
    ("stiffness", [[1.0], [1.0, 2.0]]),
    ("gas", -1.0),
    ("gas", NAN),
    ("gas", INF),
    ("gas", None),
    ("position", (0.0, 0.0)),
    ("position", (0.0, 0.0, NAN)),
    ("position", "here"),
    ("position", (1e20, 0.0, 0.0)),
    ("velocity", (0.0, INF, 0.0)),
    ("velocity", 3.0),
    ("restitution", -0.1),
    ("restitution", 1.1),
    ("restitution", NAN),
    ("friction", -0.1),
    ("friction", NAN),
    ("friction", INF),
    ("mesh", (SOLID.vertices, SOLID.triangles)),
    ("mesh", None),
]
BOX = {"size": (1.0, 2.0, 3.0), "mass": 1.0}
BAD_BOX = [
    ("size", (1.0, 0.0, 1.0)),
    ("size", (1.0, -1.0, 1.0)),
    ("size", (1.0, NAN, 1.0)),
    ("size", (1.0, INF, 1.0)),
    ("size", (1.0, 1.0)),
    ("size", 1.0),
    ("mass", 0.0),
    ("mass", -1.0),
    ("mass", NAN),
    ("mass", "heavy"),
    ("position", (NAN, 0.0, 0.0)),
    ("orientation", (1.0, 1.0, 0.0, 0.0)),
    ("orientation", (0.0, 0.0, 0.0, 0.0)),
    ("orientation", (NAN, 0.0, 0.0, 0.0)),
    ("orientation", (1.0, 0.0, 0.0)),
    ("orientation", "up"),
    ("orientation", (1.00001, 0.0, 0.0, 0.0)),
    ("velocity", (NAN, 0.0, 0.0)),
    ("angular_velocity", (0.0, 0.0, INF)),
    ("restitution", 2.0),
    ("friction", -1.0),
]
BAD_GROUND = [("height", NAN), ("height", INF), ("restitution", -1.0), ("friction", NAN)]
BAD_STEP = [
    ("time_step", 0.0),
    ("time_step", -1e-3),
    ("time_step", NAN),
    ("time_step", INF),
    ("time_step", None),
    ("steps", -1),
    ("steps", 2.5),
    ("steps", NAN),
    ("steps", INF),
    ("steps", "many"),
    ("steps", 2**63),
]


@pytest.fixture
def filled():
    """A world with one of everything, and what it holds."""
    world = World()
    world.add_ground()
    world.add_soft_body(**SOFT)
    world.add_box(**BOX)
    return world, world.model, world.state, world.state.copy()


def assert_untouched(filled):
    world, model, state, copy = filled
    assert world.model is model
    assert world.state is state
    assert same(state, copy)
    assert (world.steps, world.time) == (0, 0.0)


@pytest.mark.parametrize(("name", "value"), BAD_SOFT)
def test_a_soft_body_is_refused_by_the_name_of_its_bad_parameter(filled, name, value):
    with pytest.raises(ParameterError, match=name):
        filled[0].add_soft_body(**{**SOFT, name: value})
    assert_untouched(filled)


@pytest.mark.parametrize("value", [-5.0, NAN, INF])
def test_a_bad_stiffness_of_one_edge_is_named_by_that_edge(filled, value):
    stiffness = np.ones(12)
    stiffness[7] = value
    with pytest.raises(ParameterError, match="stiffness of edge 7"):
        filled[0].add_soft_body(**{**SOFT, "stiffness": stiffness})
    assert_untouched(filled)


@pytest.mark.parametrize(("name", "value"), BAD_BOX)
def test_a_box_is_refused_by_the_name_of_its_bad_parameter(filled, name, value):
    with pytest.raises(ParameterError, match=name):
        filled[0].add_box(**{**BOX, name: value})
    assert_untouched(filled)


@pytest.mark.parametrize("motion", ["velocity", "angular_velocity"])
def test_a_static_box_cannot_move(filled, motion):
    with pytest.raises(ParameterError, match=r"static box .* cannot have a velocity"):
        filled[0].add_box((1.0, 1.0, 1.0), None, **{motion: (0.0, 0.0, 1.0)})
    assert_untouched(filled)


@pytest.mark.parametrize(("name", "value"), BAD_GROUND)
def test_a_ground_is_refused_by_the_name_of_its_bad_parameter(filled, name, value):
    with pytest.raises(ParameterError, match=name):
        filled[0].add_ground(**{name: value})
    assert_untouched(filled)


@pytest.mark.parametrize(("name", "value"), BAD_STEP)
def test_a_step_is_refused_by_the_name_of_its_bad_parameter(filled, name, value):
    with pytest.raises(ParameterError, match=name):
        filled[0].step(**{"time_step": 1e-3, name: value})
    assert_untouched(filled)


@pytest.mark.parametrize(("seconds", "time_step"), [(-1.0, 1e-3), (NAN, 1e-3), (1.0, 0.0), (1e300, 1e-3), (1e308, 0.1)])
def test_a_run_is_refused_by_the_name_of_its_bad_parameter(filled, seconds, time_step):
    with pytest.raises(ParameterError, match=r"seconds|time_step"):
        filled[0].run(seconds, time_step)
    assert_untouched(filled)


@pytest.mark.parametrize("value", [-1.0, NAN, INF, None])
def test_gas_cannot_be_changed_to_nonsense(filled, value):
    body = softbody.SoftBody(filled[0], 0)
    with pytest.raises(ParameterError, match="gas"):
        body.gas = value
    assert body.gas == 1.0


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("integrator", "euler"),
        ("integrator", None),
        ("integrator", []),
        ("axes", "all"),
        ("axes", []),
        ("gravity", 9.81),
        ("gravity", (0.0, 0.0, NAN)),
        ("gravity", None),
    ],
)
def test_a_world_is_refused_by_the_name_of_its_bad_parameter(name, value):
    with pytest.raises(ParameterError, match=name):
        World(**{name: value})


@integrators
def test_too_long_a_time_step_stops_at_the_last_good_step(integrator):
    """… which is the very state that the steps before it lead to."""

    def jolted():
        world = World(gravity=(0.0, 0.0, 0.0), integrator=integrator)
        world.add_soft_body(BALL, 1.0, 100.0, 5.0)
        world.state.velocity[:] = np.random.default_rng(1).normal(0.0, 0.1, (42, 3))
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
    assert same(world.state, again.state)


def test_the_error_names_the_body_that_diverged_not_its_neighbour():
    world = World(gravity=(0.0, 0.0, 0.0))
    world.add_soft_body(SOLID, 1.0, 1.0, 0.1)
    stiff = world.add_soft_body(SOLID, 1.0, 1e6, 0.1, position=(5.0, 0.0, 0.0))
    stiff.velocities[0] += 0.01
    with pytest.raises(SimulationError, match="soft body 1") as caught:
        world.step(0.05, 1000, allow_unstable=True)
    assert caught.value.body == "soft body 1"


def test_particles_that_are_not_finite_are_found_before_the_first_step():
    world = World()
    body = world.add_soft_body(SOLID, 1.0, 1.0, 1.0)
    body.positions[3] = np.nan
    with pytest.raises(ParameterError, match="position of particle 3 of soft body 0 is not finite"):
        world.step(1e-3, 10)


def test_a_body_in_fast_flight_has_not_diverged():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(SOLID, 1.0, 10.0, 1.0, velocity=(1e6, 0.0, 0.0))
    world.step(1e-3, 100)
    assert body.centre[0] == pytest.approx(1e5, rel=1e-9)


# ---- options of soft bodies, and what is refused ----


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"pinned": range(6)}, "every vertex is pinned"),
        ({"pinned": [6]}, "pinned vertex 6 does not exist"),
        ({"pinned": [-1]}, "pinned vertex -1 does not exist"),
        ({"pinned": [0.5]}, "pinned is"),
        ({"rest_length": 0.0}, "rest_length of edge 0 is 0.0; give a finite length > 0"),
        ({"rest_length": [1.0, 2.0]}, "rest_length does not fit"),
        ({"damping": -1.0}, "damping is -1.0"),
        ({"drag": np.nan}, "drag is nan"),
        ({"deflated_below": 1.5}, "deflated_below is 1.5"),
    ],
)
def test_wrong_options_of_a_soft_body_are_refused_by_name(options, message):
    world = World()
    with pytest.raises(ParameterError, match=message):
        world.add_soft_body(SOLID, 1.0, 10.0, 1.0, **options)
    assert len(world.state.position) == 0


def test_gas_may_not_become_negative():
    body = World().add_soft_body(SOLID, 1.0, 10.0, 1.0)
    with pytest.raises(ParameterError, match="gas is -1"):
        body.gas = -1.0


@integrators
def test_a_step_above_the_stable_one_is_refused_with_the_number_to_use(integrator):
    world = World(integrator=integrator)
    world.add_soft_body(SOLID, 1.0, 10.0, 1.0)
    stable = world.stable_time_step()
    before = world.state.copy()
    with pytest.raises(ParameterError, match=rf"a stable time step here is {stable:.6g} s .* or substeps=3, or say"):
        world.step(2.5 * stable)
    assert same(world.state, before)
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


@pytest.mark.parametrize("force", [(np.inf, 0.0, 0.0), np.zeros((2, 3)), "up"])
def test_an_external_force_must_fit(force):
    body = World().add_soft_body(SOLID, 1.0, 10.0, 1.0)
    with pytest.raises(ParameterError, match="external_force"):
        body.external_force = force
    assert not body.external_force.any()


def test_an_external_force_belongs_to_its_body_and_stays_when_bodies_are_added():
    world = World(gravity=(0.0, 0.0, 0.0))
    world.add_soft_body(SOLID, 1.0, 10.0, 1.0)
    pushed = world.add_soft_body(SOLID, 1.0, 10.0, 1.0, position=(5.0, 0.0, 0.0))
    pushed.external_force = (0.0, 0.0, 2.0)
    third = world.add_soft_body(SOLID, 1.0, 10.0, 1.0, position=(10.0, 0.0, 0.0))
    assert world.model.external_force.sum(axis=0) == pytest.approx([0.0, 0.0, 12.0])
    assert not third.external_force.any()


def test_springs_can_be_changed_between_steps():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(SOLID, 1.0, 10.0, 0.0)
    body.set_springs(rest_length=0.5 * 2.0**0.5)
    world.equilibrium()
    assert body.volume == pytest.approx(SOLID.volume / 8.0, rel=1e-9)
    stable = world.stable_time_step()
    body.set_springs(stiffness=40.0)
    assert world.stable_time_step() == pytest.approx(0.5 * stable, rel=1e-9)
    with pytest.raises(ParameterError, match="stiffness of edge 0 is -1"):
        body.set_springs(stiffness=-1.0)


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


def test_the_first_step_is_like_any_other():
    def thrown():
        world = World()
        for x in (0.0, 1.2):
            world.add_soft_body(softbody.icosphere(1, 0.5), 1.0, 100.0, 20.0, (x, 0.0, 0.0), (-x, 0.0, 0.0))
        return world

    whole, parts = thrown(), thrown()
    whole.step(2e-3, 300)
    for steps in (0, 1, 299):
        parts.step(2e-3, steps)
    assert whole.state_hash() == parts.state_hash()
    assert whole.steps == 300


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda w, b, box: b.velocities.__setitem__((3, 1), np.nan), "velocity of particle 3 of soft body 0 is not"),
        (lambda w, b, box: b.external_force.__setitem__((2, 0), np.inf), "external_force of particle 2 of soft body 0"),
        (lambda w, b, box: w.model.box_force.__setitem__((1, 2), np.nan), "force of box 1 is not finite"),
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


def test_a_fast_ball_goes_through_a_plate_only_where_steps_are_not_split():
    for split in (True, False):
        world = World(gravity=(0.0, 0.0, 0.0), split_steps=split)
        world.add_box((4.0, 4.0, 0.1), None)
        ball = world.add_soft_body(softbody.icosphere(1, 0.2), 0.2, 200.0, 200.0, (0.0, 0.0, 0.9), (0.0, 0.0, -100.0))
        world.run(0.02, 0.5 * world.stable_time_step())
        assert (ball.positions[:, 2] > 0.0).all() == split


def test_a_skin_lies_on_the_side_of_a_box_only_with_edge_contacts():
    """A soft cube comes down on the side of a box that is turned by 45°: its corners miss it by half a metre."""
    for edges in (True, False):
        world = World(edge_contacts=edges)
        world.add_box((4.0, 4.0, 4.0), None, orientation=(np.cos(np.pi / 8), 0.0, np.sin(np.pi / 8), 0.0))
        top = 2.0 * 2.0**0.5
        cube = world.add_soft_body(softbody.box((1.0, 1.0, 1.0)), 1.0, 500.0, 20.0, (0.0, 0.0, top + 0.55), drag=2.0)
        lowest = min(step_and_tell(world, cube) for _ in range(60))
        assert (lowest > top + 0.1) == edges


def step_and_tell(world, ball):
    """Take ten steps, and return the height of the ball's centre."""
    world.step(0.5 * world.stable_time_step(), 10)
    return ball.centre[2]


# ---- the paper's own rules ----


def test_the_papers_world_has_all_that_the_paper_chose():
    world, rules = World.paper(), World.paper().rules
    assert (world.integrator, rules.paper_axes, rules.single_contact, rules.exhaustive_pairs) == (
        "rk4_velocity",
        True,
        True,
        True,
    )
    assert 0.0 < rules.angular_speed_floor < rules.angular_speed_ceiling < np.inf
    assert rules.speed_ceiling < np.inf


def test_nothing_has_friction_in_the_papers_world():
    world = World.paper()
    world.add_ground(friction=0.9)
    world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 0.5), velocity=(1.0, 0.0, 0.0), friction=0.9)
    ball = world.add_soft_body(BALL, 1.0, 200.0, 5.0, (4.0, 0.0, 1.0), velocity=(1.0, 0.0, 0.0), friction=0.9)
    world.step(4e-3, 250)
    assert world.state.box_velocity[0, 0] == pytest.approx(1.0, abs=1e-12)
    assert ball.velocities[:, 0].mean() == pytest.approx(1.0, abs=1e-12)


def test_one_of_the_papers_choices_can_be_changed():
    rules = World.paper(contact="manifold", gravity=(0.0, 0.0, 0.0)).rules
    assert not rules.single_contact
    assert rules.paper_axes


def test_all_pairs_of_soft_bodies_give_the_bits_of_the_grid():
    hashes = []
    for pairs in ("grid", "exhaustive"):
        world = World(pairs=pairs)
        world.add_ground()
        for k in range(3):
            world.add_soft_body(SOLID, 1.0, 200.0, 5.0, (0.1 * k, 0.0, 1.0 + 1.5 * k))
        world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.2, 6.0))
        world.step(2e-3, 600)
        hashes.append(world.state_hash())
    assert hashes[0] == hashes[1]
