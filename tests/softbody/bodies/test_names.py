"""Are bodies and joints found by the names that they were given, wherever a world goes?"""

import copy
import pickle

import numpy as np
import pytest

import softbody
from softbody import ParameterError, SnapshotError, World

pytestmark = pytest.mark.interpreted

SOLID = softbody.octahedron(0.3)


@pytest.fixture
def world():
    """A world of a named and an unnamed one of each kind."""
    world = World()
    for name, x in (("ball", 0.0), (None, 2.0)):
        world.add_soft_body(SOLID, 1.0, 100.0, 1.0, (x, 0.0, 0.0), name=name)
    for name, x in ((None, 4.0), ("lid", 6.0)):
        world.add_box((0.2, 0.2, 0.2), 1.0, (x, 0.0, 0.0), name=name)
    for name, body in (("cord", world.soft_bodies[0]), (None, world.boxes[1])):
        end = (body, 0) if name else (body, (6.0, 0.0, 0.0))
        world.add_joint(end, (0.0, 0.0, 5.0), 1.0, name=name)
    return world


def test_a_name_finds_what_was_given_it(world):
    assert world["ball"] == world.soft_bodies[0]
    assert world["lid"] == world.boxes[1]
    assert world["cord"] == world.joints[0]
    assert [each.name for each in (*world.soft_bodies, *world.boxes, *world.joints)] == [
        "ball", None, None, "lid", "cord", None,
    ]  # fmt: skip
    assert "ball" in world
    assert "bell" not in world
    assert 0 not in world


def test_repr_shows_a_name_where_there_is_one(world):
    assert repr(world["ball"]).startswith("<soft body 0 'ball': 6 particles")
    assert repr(world["lid"]).startswith("<box 1 'lid': (")
    assert repr(world["cord"]).startswith("<joint 0 'cord': ")
    assert repr(world.soft_bodies[1]).startswith("<soft body 1: ")


def test_a_name_that_there_is_none_of_lists_those_there_are(world):
    with pytest.raises(ParameterError, match=r"no 'bal' in this world; did you mean 'ball'\? there are 'ball', 'lid'"):
        world["bal"]
    for name in (0, None, ["ball"]):
        with pytest.raises(ParameterError, match="in this world; there are 'ball', 'lid', 'cord'"):
            world[name]
    with pytest.raises(ParameterError, match="none has a name: give it one"):
        World()["ball"]
    for k in range(30):
        world.add_box((0.2, 0.2, 0.2), 1.0, (8.0 + k, 0.0, 0.0), name=f"box {k}")
    with pytest.raises(ParameterError, match="'box 16' and 13 more"):
        world["x"]


def test_a_name_may_be_given_changed_and_taken_later(world):
    other = world.soft_bodies[1]
    other.name = "other"
    world["ball"].name = "first"
    assert (world["first"].index, world["other"].index) == (0, 1)
    other.name = "other"
    other.name = None
    assert other.name is None
    other.name = "ball"
    assert world["ball"] == other


@pytest.mark.parametrize("name", ["", " ball", "ball ", "a\nb", "a\0", "\ud800", "x" * 101, 3, b"ball", ["a"]])
def test_what_is_no_name_is_refused(world, name):
    before = world.snapshot()
    adding = (
        lambda: world.add_soft_body(SOLID, 1.0, 1.0, 1.0, name=name),
        lambda: world.add_box((1.0, 1.0, 1.0), 1.0, name=name),
        lambda: world.add_joint((world.boxes[0], (0.0, 0.0, 0.0)), (0.0, 0.0, 0.0), 1.0, name=name),
        lambda: setattr(world.boxes[0], "name", name),
    )
    for add in adding:
        with pytest.raises(ParameterError, match=r"name is .*; give a text of 1 to 100 characters"):
            add()
    after = world.snapshot()
    assert all(np.array_equal(after[entry], before[entry]) for entry in before)


@pytest.mark.parametrize(("name", "whose"), [("ball", "soft body 0"), ("lid", "box 1"), ("cord", "joint 0")])
def test_a_name_belongs_to_one_of_all_kinds(world, name, whose):
    with pytest.raises(ParameterError, match=f"name is '{name}', which {whose} has; give another"):
        world.add_box((1.0, 1.0, 1.0), 1.0, name=name)
    with pytest.raises(ParameterError, match=f"which {whose} has"):
        world.soft_bodies[1].name = name
    assert (world.model.box_count, world.soft_bodies[1].name) == (2, None)


def test_what_is_refused_leaves_its_name_free(world):
    with pytest.raises(ParameterError, match="mass"):
        world.add_box((1.0, 1.0, 1.0), -1.0, name="crate")
    world.add_box((1.0, 1.0, 1.0), 1.0, name="crate")


def test_names_stay_with_their_bodies_when_others_are_removed(world):
    world.remove(world.boxes[0])
    assert world["lid"].index == 0
    ball, cord = world["ball"], world["cord"]
    world.remove(ball)
    assert not cord.is_there
    assert "ball" not in world
    assert "cord" not in world
    with pytest.raises(ParameterError, match="was removed"):
        print(ball.name)
    world.remove(world["lid"])
    assert world.joints == ()
    world.add_soft_body(SOLID, 1.0, 1.0, 1.0, name="ball")
    assert world["ball"].index == 1


def test_names_follow_joints_that_are_removed(world):
    world.joints[1].name = "rod"
    world.remove(world["cord"])
    assert world["rod"].index == 0


def test_names_go_with_a_world_wherever_it_goes_and_are_no_part_of_its_state(world, tmp_path):
    world.save(tmp_path / "world.npz")
    before = world.state_hash()
    for other in (World.load(tmp_path / "world.npz"), copy.deepcopy(world), pickle.loads(pickle.dumps(world))):
        assert [other[name].index for name in ("ball", "lid", "cord")] == [0, 1, 0]
        assert other.boxes[0].name is None
    world["ball"].name = "something else"
    assert world.state_hash() == before


def test_a_world_takes_the_names_of_what_it_is_restored_from(world):
    snapshot = world.snapshot()
    world["ball"].name = "later"
    world.restore(snapshot)
    assert "ball" in world
    assert "later" not in world


def test_a_snapshot_from_before_there_were_names_is_read_without(world):
    old = {entry: array for entry, array in world.snapshot().items() if not entry.startswith(("names.", "rest."))}
    world.restore(old | {"format": np.array(4)})
    assert world.soft_bodies[0].name is None
    assert "ball" not in world


@pytest.mark.parametrize(
    ("entry", "value", "message"),
    [
        ("soft", ["ball", "ball"], r"names\.soft\[1\] is 'ball', which another has"),
        ("box", ["", "ball"], r"names\.box\[1\] is 'ball', which another has"),
        ("joint", [" x", ""], r"names\.joint\[0\] is ' x'; give a text"),
        ("joint", ["x"], r"names\.joint has shape \(1,\); it must be \(2,\)"),
        ("soft", [1, 2], r"names\.soft holds int64; it must be words"),
    ],
)
def test_damage_to_names_in_a_snapshot_is_named(world, entry, value, message):
    with pytest.raises(SnapshotError, match=message):
        world.restore(world.snapshot() | {f"names.{entry}": np.array(value)})
