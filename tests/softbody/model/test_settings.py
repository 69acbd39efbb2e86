"""Are the choices of a world those that it was given, those of the paper, and refused by name where they are none?"""

import numpy as np
import pytest

import softbody
from softbody import ParameterError, World
from softbody.model.settings import INTEGRATORS, WORDS, Choices, Settings, settings_of

pytestmark = pytest.mark.interpreted

BALL = softbody.icosphere(1)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("integrator", "euler"),
        ("integrator", None),
        ("integrator", []),
        ("axes", "all"),
        ("axes", []),
        ("contact", "many"),
        ("soft_contact", "manifold"),
        ("pairs", "some"),
        ("iterations", 0),
        ("iterations", 2.5),
        ("iterations", 10**9),
        ("speed_ceiling", -1.0),
        ("angular_speed_ceiling", float("nan")),
        ("angular_speed_floor", -1.0),
        ("gravity", 9.81),
        ("gravity", (0.0, 0.0, float("nan"))),
        ("gravity", None),
    ],
)
def test_a_world_is_refused_by_the_name_of_its_bad_parameter(name, value):
    with pytest.raises(ParameterError, match=name):
        World(**{name: value})


def test_a_choice_that_a_world_does_not_have_is_refused():
    with pytest.raises(
        ParameterError, match=r"a World has no 'rules'; choose from gravity, precision, threads, integr"
    ):
        World(rules="paper")
    with pytest.raises(ParameterError, match=r"a World has no 'substep'; did you mean 'substeps'\? choose from"):
        World(substep=2)
    with pytest.raises(
        ParameterError, match=r"a World has no 'rules'; choose from integrator, substeps, axes, contact, "
    ):
        settings_of({"rules": "paper"})


def test_every_choice_is_a_setting_and_the_defaults_are_those_of_the_kernels():
    assert World().store.settings == Settings()
    assert {WORDS[name][0] if name in WORDS else name for name in Choices.__annotations__} == set(Settings._fields)


def test_the_integrator_may_be_changed_between_steps_and_is_checked():
    world = World(integrator="rk4")
    assert world.integrator == "rk4"
    world.integrator = "symplectic_euler"
    assert world.store.settings.integrator == INTEGRATORS["symplectic_euler"]
    with pytest.raises(
        ParameterError, match="integrator is 'euler'; choose one of rk4_velocity, rk4, symplectic_euler"
    ):
        world.integrator = "euler"
    assert world.integrator == "symplectic_euler"


def test_the_papers_world_has_all_that_the_paper_chose():
    world, settings = World.paper(), World.paper().store.settings
    assert world.integrator == "rk4_velocity"
    assert settings.paper_axes
    assert settings.single_contact
    assert settings.single_soft_contact
    assert settings.exhaustive_pairs
    assert 0.0 < settings.angular_speed_floor < settings.angular_speed_ceiling < np.inf
    assert settings.speed_ceiling < np.inf


def test_nothing_has_friction_in_the_papers_world():
    world = World.paper()
    world.add_ground(friction=0.9)
    world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 0.5), velocity=(1.0, 0.0, 0.0), friction=0.9)
    ball = world.add_soft_body(BALL, 1.0, 200.0, 5.0, (4.0, 0.0, 1.0), velocity=(1.0, 0.0, 0.0), friction=0.9)
    world.step(4e-3, 250)
    assert world.state.box_velocity[0, 0] == pytest.approx(1.0, abs=1e-12)
    assert ball.velocities[:, 0].mean() == pytest.approx(1.0, abs=1e-12)


def test_one_of_the_papers_choices_can_be_changed():
    settings = World.paper(contact="manifold", gravity=(0.0, 0.0, 0.0)).store.settings
    assert not settings.single_contact
    assert settings.paper_axes
