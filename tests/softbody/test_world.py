"""Does a world take what is right, refuse what is wrong by name, and move as physics says?"""

import numpy as np
import pytest

import softbody
from softbody import ParameterError, World
from softbody.model.settings import INTEGRATORS

G = 9.81
BALL = softbody.icosphere(1)
SOLID = softbody.octahedron()
NAN, INF = float("nan"), float("inf")

integrators = pytest.mark.parametrize("integrator", INTEGRATORS)


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


def test_an_inflated_regular_solid_settles_at_the_closed_form_scale():
    """λ² − λ = 3 nRT / (k Σ l0²): here 12 edges of √2, so λ = (1 + √3)/2 for nRT = k Σ l0² / 6."""
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(SOLID, 1.0, 50.0, 50.0 * 24.0 / 6.0)
    world.step(0.005, 6000)
    assert (body.volume / SOLID.volume) ** (1 / 3) == pytest.approx((1 + 3**0.5) / 2, rel=1e-9)


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


def test_a_second_ground_replaces_the_first():
    world = World()
    world.add_ground(height=1.0)
    world.add_ground(height=-2.0, restitution=0.5, friction=0.1)
    model = world.model
    assert (model.ground_height, model.ground_restitution, model.ground_friction) == (-2.0, 0.5, 0.1)


# ---- what is refused ----

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


@pytest.mark.parametrize(("name", "value"), BAD_GROUND)
def test_a_ground_is_refused_by_the_name_of_its_bad_parameter(filled, name, value):
    with pytest.raises(ParameterError, match=name):
        filled.add_ground(**{name: value})


@pytest.mark.parametrize(("name", "value"), BAD_STEP)
def test_a_step_is_refused_by_the_name_of_its_bad_parameter(filled, name, value):
    with pytest.raises(ParameterError, match=name):
        filled.step(**{"time_step": 1e-3, name: value})


@pytest.mark.parametrize(("seconds", "time_step"), [(-1.0, 1e-3), (NAN, 1e-3), (1.0, 0.0), (1e300, 1e-3), (1e308, 0.1)])
def test_a_run_is_refused_by_the_name_of_its_bad_parameter(filled, seconds, time_step):
    with pytest.raises(ParameterError, match=r"seconds|time_step"):
        filled.run(seconds, time_step)
