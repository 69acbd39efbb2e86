"""Contacts one after the other, half of the depth each, on worlds small enough to be followed by hand."""

import numpy as np
import pytest

import softbody
from softbody import Mesh, World

TETRAHEDRON = Mesh(np.eye(4, 3), np.array([[3, 1, 0], [3, 2, 1], [3, 0, 2], [0, 1, 2]]))  # its corner 3 at the origin
STILL = (0.0, 0.0, 0.0)

pytestmark = pytest.mark.filterwarnings("ignore::softbody.OverlapWarning")


def world_of(mass, **of_tip):
    """A box of `mass` kg, and a body of 4 kg without springs whose tip, along x, is 0.05 m inside it."""
    world = World(gravity=STILL, soft_contact="single", edge_contacts=False)
    box = world.add_box((1.0, 1.0, 1.0), mass, friction=of_tip.pop("rough", 0.0))
    body = world.add_soft_body(TETRAHEDRON, 4.0, 0.0, 0.0, (-1.45, 0.05, 0.1), **of_tip)
    return world, box, body


def test_a_box_and_a_particle_that_overlap_part_by_half_each_whatever_they_weigh():
    world, box, body = world_of(1000.0)
    world.step(1e-3)
    assert body.positions[0, 0] == pytest.approx(-0.475, abs=1e-15)
    assert box.position[0] == pytest.approx(0.025, abs=1e-15)
    assert (box.velocity == 0.0).all()
    assert (body.velocities == 0.0).all()


def test_a_fixed_box_leaves_all_of_the_way_to_the_particle_and_a_fixed_particle_to_the_box():
    world, _, body = world_of(None)
    world.step(1e-3)
    assert body.positions[0, 0] == pytest.approx(-0.5, abs=1e-15)
    world, box, body = world_of(1.0, fixed=[0])
    world.step(1e-3)
    assert body.positions[0, 0] == pytest.approx(-0.45, abs=1e-15)
    assert box.position[0] == pytest.approx(0.05, abs=1e-15)


def test_friction_takes_at_most_mu_times_the_impulse():
    world, _, body = world_of(None, rough=0.25, friction=0.25, velocity=(0.002, 0.001, 0.0), restitution=1.0)
    world.step(1e-9)
    assert body.velocities[0] == pytest.approx((-0.002, 0.001 - 0.25 * 0.004, 0.0), abs=1e-12)
    world, _, body = world_of(None, rough=0.25, friction=0.25, velocity=(0.002, 0.010, 0.0), restitution=1.0)
    world.step(1e-9)
    assert body.velocities[0] == pytest.approx((-0.002, 0.009, 0.0), abs=1e-12)


def test_what_lies_pressed_against_the_ground_and_a_box_is_held_by_the_papers_rules_too():
    world = World.paper()
    world.add_ground()
    world.add_box((2.0, 2.0, 0.5), None, (0.0, 0.0, 0.25))
    ball = world.add_soft_body(softbody.icosphere(2, 0.5), 1.0, 300.0, 20.0, (0.0, 0.0, 1.1), drag=1.0)
    world.run(2.0, 2e-3)
    assert ball.positions[:, 2].min() == pytest.approx(0.5, abs=1e-3)
