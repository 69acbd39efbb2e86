"""Is a number what it says, whatever it is written as, and is what is none refused by name?"""

from fractions import Fraction

import numpy as np
import pytest

import softbody
from softbody import ParameterError, World
from softbody.model.validation import check_range, check_whole, doubles, shown

SOLID = softbody.octahedron()


@pytest.mark.parametrize("kind", [np.float16, np.float32, np.longdouble, np.int8, np.uint64, int, Fraction])
def test_a_scalar_of_any_kind_is_taken_as_a_double(kind):
    value = kind(3) / kind(2) if kind in (np.float16, np.float32, np.longdouble, Fraction) else kind(3)
    world = World()
    world.add_soft_body(SOLID, value, 10.0, value)
    world.add_box((1.0, 1.0, 1.0), value)
    assert world.model.particle_inverse_mass[0] == 6.0 / float(value)
    assert world.model.box_inverse_mass[0] == 1.0 / float(value)
    assert type(check_range(value, "value")) is float


def test_a_mass_in_single_precision_is_not_computed_with_in_single_precision():
    world = World()
    world.add_box((1.0, 1.0, 1.0), np.float32(1.1))
    assert world.model.box_inverse_mass[0] == 1.0 / float(np.float32(1.1))


NO_NUMBERS = [10**400, -(10**400), "1", b"1", 1j, np.complex128(1.0), None, [1.0], np.array([1.0]), object(), {}]


@pytest.mark.parametrize("value", NO_NUMBERS, ids=lambda value: type(value).__name__)
def test_what_is_no_double_is_refused_by_name(value):
    with pytest.raises(ParameterError, match="mass is"):
        World().add_soft_body(SOLID, value, 10.0, 1.0)
    with pytest.raises(ParameterError, match="time_step is"):
        World().step(value)
    with pytest.raises(ParameterError, match="position is"):
        World().add_box((1.0, 1.0, 1.0), 1.0, (value, 0.0, 0.0) if np.ndim(value) == 0 else [value, [], 1])


def test_a_whole_number_is_exact_and_may_be_one_of_numpy():
    assert check_whole(np.uint64(2**62), "steps", 0) == 2**62
    assert type(check_whole(np.int8(3), "steps", 0)) is int
    assert len(softbody.torus(1.0, 0.4, np.uint64(8), np.uint8(5)).vertices) == 40
    for value in (2**63, 10**400, np.uint64(2**63), 1.0, "1", None):
        with pytest.raises(ParameterError, match="steps is"):
            World().step(1e-3, value)


def test_shapes_of_more_vertices_than_memory_holds_are_refused():
    for make in (lambda: softbody.torus(1.0, 0.4, 10**6, 10**6), lambda: softbody.box((1.0, 1.0, 1.0), 10**6)):
        with pytest.raises(ParameterError, match="ask for fewer segments"):
            make()


def test_complex_numbers_and_text_are_no_vectors():
    for value in (np.ones(3, complex), ["1", "2", "3"], np.array(["1", "2", "3"]), (10**400, 0, 0)):
        with pytest.raises(ParameterError, match="gravity is"):
            World(gravity=value)
    assert doubles(np.array([1, 2], np.uint8)).dtype == np.float64


def test_yes_is_true_and_no_other_word():
    assert not World(edge_contacts=np.bool_(False)).store.settings.edge_contacts
    for value in ("no", 0, None, []):
        with pytest.raises(ParameterError, match=r"edge_contacts is .*; give True or False"):
            World(edge_contacts=value)


def test_a_scene_is_built_in_a_world_and_nothing_else():
    with pytest.raises(ParameterError, match=r"world is 3; give a softbody\.World"):
        softbody.scenes.box_stack.build(world=3)


def test_messages_stay_short_whatever_they_show():
    assert len(shown(list(range(10**5)))) < 300
    assert "int" in shown(10**5000)


@pytest.mark.parametrize(
    ("size", "mass"), [(1.0, 5e-324), (1.0, 1e-310), (1e-45, 1e-250), (1e-200, 1.0), (1e200, 1.0), (1e49, 1e300)]
)
def test_a_box_without_a_finite_inverse_of_mass_and_inertia_is_refused(size, mass):
    with pytest.raises(ParameterError, match=r"mass|size"):
        World().add_box((size, size, size), mass)


def test_a_soft_body_without_a_finite_inverse_of_mass_is_refused():
    with pytest.raises(ParameterError, match=r"mass is 1e-310 kg, for 6 particles: too light or too heavy"):
        World().add_soft_body(SOLID, 1e-310, 10.0, 1.0)


def test_a_box_so_far_away_that_its_size_is_lost_is_refused():
    with pytest.raises(ParameterError, match="so far away that a size of"):
        World().add_box((1.0, 1.0, 1.0), 1.0, (1e20, 0.0, 0.0))
