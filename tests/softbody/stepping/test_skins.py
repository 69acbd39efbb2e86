"""Is a user told once, and at the same step however steps are taken, that a body goes through itself?"""

import warnings

import numpy as np
import pytest

import softbody
from softbody import SelfIntersectionWarning, World
from softbody.stepping.skins import EARLY, EVERY, Skins, next_look


def limp_world() -> World:
    world = World()
    world.add_ground()
    world.add_soft_body(softbody.torus(0.4, 0.15, 18, 10), 1.0, 20.0, 0.05, (0.0, 0.0, 0.2), name="bag")
    return world


def warnings_of(world: World, calls: list[int]) -> list[warnings.WarningMessage]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for steps in calls:
            world.step(1e-3, steps)
    return caught


def test_looks_are_after_the_same_steps_whatever_was_asked_for():
    looks, at = [], 0
    while at < 3 * EVERY:
        at = next_look(at)
        looks.append(at)
    assert looks == [*EARLY, EVERY, 2 * EVERY, 3 * EVERY]


def test_a_limp_body_is_named_once_with_the_step_and_the_cure():
    told = warnings_of(limp_world(), [600, 600])
    assert [each.category for each in told] == [SelfIntersectionWarning]
    assert told[0].filename == __file__
    assert "soft body 0 'bag' goes through itself: " in str(told[0].message)
    assert "triangles meet after step 512 (and none after step 128), such as" in str(told[0].message)
    assert "more gas" in str(told[0].message)


@pytest.mark.parametrize("calls", [[1] * 520, [127, 1, 383, 9], [513, 7]])
def test_it_is_said_of_the_same_step_however_steps_are_taken(calls):
    at_once, in_parts = warnings_of(limp_world(), [520]), warnings_of(limp_world(), calls)
    assert [str(each.message) for each in at_once] == [str(each.message) for each in in_parts]


def test_run_names_the_users_line_too():
    with pytest.warns(SelfIntersectionWarning) as told:
        limp_world().run(0.6, 1e-3)
    assert told[0].filename == __file__


def test_many_are_named_in_one_breath_and_not_again():
    world = World()
    for k in range(25):
        world.add_soft_body(softbody.torus(0.4, 0.15, 12, 6), 1.0, 20.0, 1.0, (2.0 * k, 0.0, 0.0))
    skins, store = Skins(world.model), world.runner.store
    skins.look(store.state.particle_position, 512, store.names)
    folded = np.abs(store.state.particle_position - [2.0, 0.0, 0.0]) + 1e-3
    with pytest.warns(SelfIntersectionWarning) as told:
        skins.look(folded, 2048, store.names)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        skins.look(folded, 4096, store.names)
    (text,) = {str(each.message) for each in told}
    assert "soft body 0 goes through itself: " in text
    assert "meet after step 2048 (and none after step 512), such as" in text
    assert "; so do soft body 1 (" in text
    assert "soft body 20 (" in text
    assert " pairs), 4 more. Nothing keeps" in text


def test_surfaces_that_share_an_edge_by_its_places_do_not_meet():
    one, other = softbody.box((1.0, 1.0, 1.0), 2), softbody.box((1.0, 1.0, 1.0), 2)
    vertices = np.concatenate([one.vertices, other.vertices + [1.0, 1.0, 0.0]])
    triangles = np.concatenate([one.triangles, other.triangles + len(one.vertices)])
    world = World()
    world.add_soft_body(softbody.Mesh(vertices, triangles), 1.0, 20.0, 1.0)
    skins, store = Skins(world.model), world.runner.store
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        skins.look(store.state.particle_position, 128, store.names)
    deeper = store.state.particle_position.copy()
    deeper[: len(one.vertices), :2] += 0.1
    with pytest.warns(SelfIntersectionWarning, match=r"after step 512 \(and none after step 128\)"):
        skins.look(deeper, 512, store.names)


def test_who_takes_it_for_an_error_loses_no_step():
    world, other = limp_world(), limp_world()
    with warnings.catch_warnings():
        warnings.simplefilter("error", SelfIntersectionWarning)
        with pytest.raises(SelfIntersectionWarning):
            world.step(1e-3, 600)
        world.step(1e-3, 600 - world.steps)
        warnings.simplefilter("ignore", SelfIntersectionWarning)
        other.step(1e-3, 600)
    assert world.state_hash() == other.state_hash()
