"""Does the list of contacts count all, and keep what it must when it grows?"""

import numpy as np
import pytest

import softbody
from softbody import World
from softbody.bodies.store import FIRST_ROOM
from softbody.collision.contact import (
    GROUND,
    ImpulseCache,
    Touch,
    add_contact,
    box_side,
    fit,
    new_contacts,
    remembered,
    soft_side,
    surface_point,
    with_room,
)
from softbody.model.arrays import NOBODY
from softbody.model.material import Material
from softbody.model.surface_point import SurfacePoint, at_particle


def filled(capacity, found):
    """A list in which so many were found: of a particle and a triangle, and of a box on the ground, by turns."""
    contacts = new_contacts(capacity)
    for k in range(found):
        touch = Touch((1.0 * k, 2.0, 3.0), (0.0, 0.0, 1.0), 0.1 * k, 7 * k)
        triangle = SurfacePoint((k, k + 1, k + 2), (0.5, 0.3, 0.2))
        a, b = (box_side(k), GROUND) if k % 2 else (soft_side(at_particle(k)), soft_side(triangle))
        add_contact(contacts, a, b, touch, Material(0.01 * k, 0.02 * k))
    return contacts


def test_a_contact_is_what_was_added():
    contacts = filled(8, 4)
    assert contacts.number.tolist() == [4, 0]
    assert fit(contacts)
    assert contacts.box[:4].tolist() == [[NOBODY, NOBODY], [1, NOBODY], [NOBODY, NOBODY], [3, NOBODY]]
    assert surface_point(contacts, 2, 0) == at_particle(2)
    assert surface_point(contacts, 2, 1) == SurfacePoint((2, 3, 4), (0.5, 0.3, 0.2))
    assert contacts.particles[3].tolist() == [[NOBODY] * 3] * 2
    assert contacts.point[3].tolist() == [3.0, 2.0, 3.0]
    assert contacts.normal[3].tolist() == [0.0, 0.0, 1.0]
    row = contacts.depth[3], contacts.feature[3], contacts.restitution[3], contacts.friction[3]
    assert row == pytest.approx((0.3, 21, 0.03, 0.06))
    assert not contacts.impulse[:4].any()


def test_a_list_that_overflows_counts_on_and_more_room_keeps_what_was_asked_for_and_the_cache():
    contacts = filled(40, 43)  # the last three find no room
    assert contacts.number[0] == 43
    assert not fit(contacts)
    contacts.number[1] = 11
    random = np.random.default_rng(0)
    contacts.impulse[:] = random.normal(size=(40, 3))
    contacts.cache.number[0], contacts.cache.soft[0] = 30, 7
    for rows in contacts.cache[2:]:
        rows[:] = random.integers(0, 99, rows.shape)
    longer = with_room(contacts, 39)
    assert longer.number.tolist() == [39, 11]
    assert fit(longer)
    for name in contacts._fields:
        if name not in ("number", "row", "cache"):  # a row is working memory
            assert len(getattr(longer, name)) == 86, name
            assert (getattr(longer, name)[:39] == getattr(contacts, name)[:39]).all(), name
    assert longer.cache.number[0] == 30
    assert longer.cache.soft[0] == 7
    for name in ImpulseCache._fields[2:]:
        assert len(getattr(longer.cache, name)) == 86, name
        assert (getattr(remembered(longer), name) == getattr(remembered(contacts), name)).all(), name


@pytest.mark.parametrize("boxes", [60, 70])
def test_a_world_that_makes_room_for_its_contacts_has_the_bits_of_one_that_had_it(boxes):
    """Of sixty boxes the contacts have room, and those of a ball with a plate have none; of seventy not even these."""

    def crowded():
        world = World()
        world.add_ground()
        for i in range(boxes):
            world.add_box((1.0, 1.0, 1.0), 1.0, (2.0 * i, 0.0, 0.5), velocity=(0.1, 0.0, 0.0))
        world.add_box((4.0, 4.0, 0.2), None, (0.0, 9.0, 0.1))
        world.add_soft_body(softbody.icosphere(3), 1.0, 100.0, 20.0, (0.0, 9.0, 1.21), (0.0, 0.0, -2.0))
        return world

    growing, roomy = crowded(), crowded()
    roomy.store.contacts = new_contacts(10_000)
    for world in (growing, roomy):
        world.step(1e-3, 100)
    assert roomy.store.contacts.depth.shape == (10_000,)
    assert FIRST_ROOM < growing.store.contacts.number[0] <= len(growing.store.contacts.depth) < 10_000
    assert growing.store.contacts.number.tolist() == roomy.store.contacts.number.tolist()
    assert growing.store.contacts.number[1] == 4 * boxes
    assert growing.state_hash() == roomy.state_hash()
    for mine, yours in zip(remembered(growing.store.contacts), remembered(roomy.store.contacts), strict=True):
        assert (mine == yours).all()


def test_a_world_makes_room_for_its_contacts_and_keeps_what_they_remember():
    world = World()
    world.add_ground()
    first = world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 0.5))
    world.step(1e-3, 10)
    for i in range(1, 60):
        world.add_box((1.0, 1.0, 1.0), 1.0, (2.0 * i, 0.0, 0.5))
    world.step(1e-3, 10)
    assert world.store.contacts.number[0] == 240
    assert world.steps == 20
    assert np.abs(world.state.box_velocity).max() < 1e-6  # the solver stops when little changes
    assert first.position[2] == pytest.approx(0.5, abs=1e-9)
