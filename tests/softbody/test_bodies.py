"""Do handles of bodies change what they say they change, and refuse nonsense?"""

import numpy as np
import pytest

import softbody
from softbody import ParameterError, World

BALL = softbody.icosphere(1)
SOLID = softbody.octahedron()


def test_changing_the_gas_between_steps_inflates_the_body():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(SOLID, 1.0, 100.0, 1.0)
    world.step(0.005, 4000)
    thin = body.volume
    body.gas = 100.0
    world.step(0.005, 4000)
    assert body.gas == 100.0
    assert body.volume > 1.1 * thin


@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf, None])
def test_gas_cannot_be_changed_to_nonsense(filled, value):
    body = softbody.SoftBody(filled, 0)
    with pytest.raises(ParameterError, match="gas"):
        body.gas = value
    assert body.gas == 1.0


def test_gas_may_not_become_negative():
    body = World().add_soft_body(SOLID, 1.0, 10.0, 1.0)
    with pytest.raises(ParameterError, match="gas is -1"):
        body.gas = -1.0


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
    assert world.controls.particle_force.sum(axis=0) == pytest.approx([0.0, 0.0, 12.0])
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


def test_a_handle_of_a_body_that_is_not_there_says_so():
    world = World()
    fewer = world.snapshot()
    soft, box = world.add_soft_body(SOLID, 1.0, 10.0, 1.0), world.add_box((1.0, 1.0, 1.0), 1.0)
    for index in (1, -1, 1.5, None):
        with pytest.raises(ParameterError, match=r"soft body 1 is not in this world: there are 1|index is"):
            softbody.SoftBody(world, index)
        with pytest.raises(ParameterError, match=r"box 1 is not in this world: there are 1|index is"):
            softbody.Box(world, index)
    world.restore(fewer)
    for ask in ("positions", "velocities", "triangles", "centre", "volume", "pressure", "gas", "external_force"):
        with pytest.raises(ParameterError, match="soft body 0 is not in this world: there are 0"):
            getattr(soft, ask)
    for ask in ("position", "orientation", "velocity", "angular_velocity", "clear_forces"):
        with pytest.raises(ParameterError, match="box 0 is not in this world: there are 0"):
            getattr(box, ask)()
    for change in (
        lambda: setattr(soft, "gas", 1.0),
        lambda: setattr(soft, "external_force", (0.0, 0.0, 1.0)),
        lambda: soft.set_springs(1.0),
        lambda: box.apply_force((0.0, 0.0, 1.0)),
        lambda: box.apply_torque((0.0, 0.0, 1.0)),
    ):
        with pytest.raises(ParameterError, match="0 is not in this world"):
            change()
