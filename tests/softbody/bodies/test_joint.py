"""Do joints hold what they are said to hold, and say no to what they cannot?"""

import contextlib
import copy
import itertools
import pickle
import sys
import threading

import numpy as np
import pytest

import softbody
from softbody import BusyError, Joint, ParameterError, SnapshotError, World

pytestmark = pytest.mark.interpreted

SOLID = softbody.octahedron(0.3)


@pytest.fixture
def world():
    """A world of a box, a soft body and a joint between them, far from each other."""
    world = World(gravity=(0.0, 0.0, 0.0))
    box = world.add_box((0.2, 0.2, 0.2), 1.0, (2.0, 0.0, 0.0))
    body = world.add_soft_body(SOLID, 1.0, 500.0, 0.0)
    world.add_joint((body, 0), (box, (2.0, 0.1, 0.0)), 20.0, 0.1, 1.5)
    return world


def test_a_joint_says_what_and_where_it_is(world):
    (joint,) = world.joints
    assert joint.ends == pytest.approx(np.array([world.soft_bodies[0].positions[0], (2.0, 0.1, 0.0)]))
    assert (joint.stiffness, joint.damping, joint.rest_length) == (20.0, 0.1, 1.5)
    assert repr(joint) == f"<joint 0: {joint.length:.4g} m, 20 N/m>"
    assert joint == Joint(world, 0)


def test_a_joint_of_two_bodies_keeps_momenta(world):
    world.integrator = "symplectic_euler"
    world.boxes[0].angular_velocity = (0.0, 1.0, 2.0)
    before = world.linear_momentum(), world.angular_momentum()
    world.run(2.0, 2e-3)
    assert world.joints[0].length < 1.9
    assert world.linear_momentum() == pytest.approx(before[0], abs=1e-12)
    assert world.angular_momentum() == pytest.approx(before[1], abs=1e-12)


def test_energy_counts_the_springs_of_joints_and_stays():
    world = World(integrator="symplectic_euler")
    box = world.add_box((0.2, 0.2, 0.2), 2.0)
    world.add_joint((box, box.position), (0.0, 0.0, 0.5), 100.0)
    begin = world.energy()
    assert world.energies().spring == pytest.approx(0.5 * 100.0 * 0.25)
    world.run(1.0, 1e-4)
    assert world.energy() == pytest.approx(begin, rel=2e-3)
    assert world.energies().total == pytest.approx(world.energy())


@pytest.mark.compiled
def test_a_target_that_is_moved_takes_the_body_along():
    world = World(gravity=(0.0, 0.0, 0.0))
    ball = world.add_soft_body(softbody.icosphere(1, 0.3), 1.0, 200.0, 10.0, damping=0.5)
    hold = world.add_joint((0.3, 0.0, 0.0), (ball, (0.3, 0.0, 0.0)), 100.0, 20.0)
    for k in range(1, 101):
        hold.target = (0.3 + 0.02 * k, 0.0, 0.0)
        world.run(0.02, 1e-3)
    world.run(3.0, 1e-3)
    assert hold.length < 1e-3
    assert ball.centre[0] == pytest.approx(2.0, abs=0.02)


def test_joints_without_stiffness_do_nothing_and_zero_length_is_no_direction():
    world, free = World(), World()
    for each in (world, free):
        each.add_box((1.0, 1.0, 1.0), 1.0)
    world.add_joint((world.boxes[0], (0.0, 0.0, 0.0)), (0.0, 0.0, 0.0), 50.0, 1.0, rest_length=0.7)
    world.joints[0].stiffness = 0.0
    for each in (world, free):
        each.step(1e-3)
    assert world.state_hash() == free.state_hash()


def test_a_step_too_long_for_a_joint_is_refused_with_its_cure(world):
    world.joints[0].stiffness = 1e6
    step = world.stable_time_step()
    with pytest.raises(ParameterError, match="joints allow"):
        world.step(0.01, substeps=1000)
    world.step(0.9 * step, 100)


@pytest.mark.compiled
def test_a_stiff_joint_is_stable_at_the_stable_step():
    world = World()
    boxes = [world.add_box((0.3, 0.1, 0.1), 10.0**k, (0.5 * k, 0.0, 0.0)) for k in range(-1, 2)]
    ball = world.add_soft_body(softbody.icosphere(1, 0.2), 0.5, 300.0, 5.0, (0.0, 2.0, 0.0))
    for a, b in itertools.pairwise(boxes):
        world.add_joint((a, a.position + (0.15, 0.05, 0.05)), (b, b.position - (0.15, 0.0, 0.0)), 1e5)
    world.add_joint((ball, 3), (boxes[0], boxes[0].position), 1e4, 1.0, 2.0)
    world.add_joint((boxes[2], boxes[2].position), (1.0, 0.0, 1.0), 1e4, 50.0)
    begin = world.energy()
    world.run(1.0, 0.95 * world.stable_time_step())
    assert world.energy() < begin + 1.0


def test_a_joint_goes_with_its_body_and_handles_follow(world):
    box, body = world.boxes[0], world.soft_bodies[0]
    of_box = world.add_joint((box, (2.0, 0.0, 0.0)), (2.0, 0.0, 1.0), 10.0)
    of_body = world.add_joint((body, 2), (0.0, 0.0, 1.0), 10.0)
    first = world.joints[0]
    world.remove(box)
    assert [each.is_there for each in (first, of_box, of_body)] == [False, False, True]
    assert of_body.index == 0
    assert repr(first) == "<joint that is gone>"
    with pytest.raises(ParameterError, match="this joint was removed"):
        first.stiffness = 1.0
    world.remove(of_body)
    assert world.joints == ()
    world.step(1e-3)


def test_a_world_with_joints_is_saved_copied_and_goes_on_to_the_same_bits(world, tmp_path):
    world.run(0.1, 1e-3)
    world.save(tmp_path / "world.npz")
    others = [World.load(tmp_path / "world.npz"), copy.deepcopy(world), pickle.loads(pickle.dumps(world))]
    for each in (world, *others):
        each.run(0.1, 1e-3)
        assert each.state_hash() == world.state_hash()


def test_a_snapshot_from_before_there_were_joints_is_read(world):
    old = {
        name: value for name, value in world.snapshot().items() if not name.startswith(("joints.", "names.", "rest."))
    }
    old["format"] = np.array(2)
    world.restore(old)
    assert world.joints == ()


@pytest.mark.parametrize(
    ("name", "place", "value", "message"),
    [
        ("joint_box", (0, 1), 7, "end 1 of joint 0"),
        ("joint_box", (0, 0), 0, "end 0 of joint 0"),
        ("joint_box", (0, 1), -2, "joint_box"),
        ("joint_particles", (0, 1), 6, "end 0 of joint 0"),
        ("joint_particles", (0, 1), -1, "end 0 of joint 0"),
        ("joint_particles", (0, 4), 2, "end 1 of joint 0"),
        ("joint_weights", (0, 0), 0.5, "end 0 of joint 0"),
        ("joint_weights", (0, 0), np.nan, "joint_weights"),
        ("joint_place", (0, 3), np.inf, "joint_place"),
        ("joint_stiffness", 0, -1.0, "joint_stiffness"),
    ],
)
def test_damage_to_joints_in_a_snapshot_is_named(world, name, place, value, message):
    snapshot = world.snapshot()
    snapshot[f"joints.{name}"][place] = value
    with pytest.raises(SnapshotError, match=message):
        world.restore(snapshot)


def test_a_joint_across_two_soft_bodies_in_one_end_is_damage(world):
    world.add_soft_body(SOLID, 1.0, 500.0, 0.0, (0.0, 3.0, 0.0))
    snapshot = world.snapshot()
    snapshot["joints.joint_particles"][0, 1] = 7
    with pytest.raises(SnapshotError, match="end 0 of joint 0"):
        world.restore(snapshot)


def test_a_list_of_joints_that_is_too_short_is_damage(world):
    snapshot = world.snapshot()
    snapshot["joints.joint_damping"] = np.zeros(0)
    with pytest.raises(SnapshotError, match="joint_damping"):
        world.restore(snapshot)


@pytest.mark.parametrize(
    ("ends", "message"),
    [
        (((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), "two places in the world"),
        (("soft 0", (1.0, np.nan, 0.0)), "b is"),
        (("soft 6", (1.0, 0.0, 0.0)), "particle of a is 6, and .* has 6"),
        (("soft -1", (1.0, 0.0, 0.0)), "particle of a"),
        (("soft 1.5", (1.0, 0.0, 0.0)), "particle of a"),
        (("other", (1.0, 0.0, 0.0)), "a is on .*, which is no body of this world"),
        (("text", (1.0, 0.0, 0.0)), "a is on 'ball'"),
        (("box", (1.0, 0.0, 0.0)), "place of a"),
        (("ragged", (1.0, 0.0, 0.0)), "place of a is"),
        (("soft None", (1.0, 0.0, 0.0)), "place of a is None"),
    ],
)
def test_ends_that_are_none_are_refused(world, ends, message):
    body = world.soft_bodies[0]
    other = World().add_box((1.0, 1.0, 1.0), 1.0)
    given = {
        "soft 0": (body, 0), "soft 6": (body, 6), "soft -1": (body, -1), "soft 1.5": (body, 1.5),
        "other": (other, (0.0, 0.0, 0.0)), "text": ("ball", 0), "box": (world.boxes[0], 3),
        "ragged": (body, [0.0, [1.0], 2.0]), "soft None": (body, None),
    }  # fmt: skip
    with pytest.raises(ParameterError, match=message):
        world.add_joint(*(given.get(end, end) if isinstance(end, str) else end for end in ends), 1.0)
    assert len(world.joints) == 1


@pytest.mark.parametrize("name", ["stiffness", "damping", "rest_length"])
@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf, "soft"])
def test_numbers_of_a_joint_must_be_numbers(world, name, value):
    with pytest.raises(ParameterError, match=name):
        world.add_joint((world.boxes[0], (2.0, 0.0, 0.0)), (0.0, 0.0, 0.0), **{"stiffness": 1.0, name: value})
    with pytest.raises(ParameterError, match=name):
        setattr(world.joints[0], name, value)


def test_only_a_joint_to_a_place_has_a_target(world):
    with pytest.raises(ParameterError, match="between two bodies"):
        world.joints[0].target = (0.0, 0.0, 0.0)
    hold = world.add_joint((0.0, 0.0, 1.0), (world.boxes[0], (2.0, 0.0, 0.0)), 1.0)
    hold.target = (0.0, 0.0, 2.0)
    assert hold.ends[0].tolist() == [0.0, 0.0, 2.0]
    with pytest.raises(ParameterError, match="target"):
        hold.target = (0.0, np.inf, 2.0)


def test_equilibrium_plays_without_joints(world):
    world.equilibrium()
    assert not world.state.particle_velocity.any()


@pytest.mark.parametrize(
    ("place", "stiffness", "damping"),
    [
        ((2.0, 0.0, 0.0), 1e308, 0.0),
        ((2.0, 0.0, 0.0), 0.0, 1e308),
        ((1e160, 0.0, 0.0), 1.0, 0.0),
        ((1e160, 0.0, 0.0), 0.0, 1.0),
    ],
)
@pytest.mark.filterwarnings("error")
def test_a_joint_for_which_no_step_is_stable_says_so(world, place, stiffness, damping):
    box = world.boxes[0]
    world.add_joint((box, place), (0.0, 0.0, 0.0), stiffness, damping)
    for call in (world.stable_time_step, lambda: world.step(1e-300), lambda: world.run(1.0)):
        with pytest.raises(ParameterError, match="no time step is stable: joints are too stiff"):
            call()
    assert world.steps == 0


@pytest.mark.filterwarnings("error")
def test_a_joint_without_force_or_on_what_never_moves_asks_for_no_step():
    world = World()
    wall = world.add_box((1.0, 1.0, 1.0), None)
    box = world.add_box((1.0, 1.0, 1.0), 1.0, (3.0, 0.0, 0.0))
    world.add_joint((wall, (1e160, 0.0, 0.0)), (9.0, 0.0, 0.0), 1e308, 1e308)
    world.add_joint((box, (1e160, 0.0, 0.0)), (9.0, 0.0, 0.0), 0.0)
    assert world.stable_time_step() == np.inf


@pytest.mark.parametrize("seed", range(10))
def test_nine_tenths_of_the_stable_step_are_taken_with_joints(seed):
    rng = np.random.default_rng(seed)
    world = World(gravity=(0.0, 0.0, 0.0), integrator=str(rng.choice(["rk4_velocity", "rk4", "symplectic_euler"])))
    box = world.add_box((0.2, 0.2, 0.2), 10.0 ** rng.uniform(-3, 3), (2.0, 0.0, 0.0))
    body = world.add_soft_body(SOLID, 10.0 ** rng.uniform(-3, 3), 500.0, 0.0)
    for end in ((box, box.position + rng.normal(size=3)), (body, 2), (0.0, 1.0, 0.0)):
        world.add_joint((body, 0) if end is not body else (box, 2), end, *10.0 ** rng.uniform(-6, 6, 2))
    for _ in range(3):
        h = world.stable_time_step()
        assert 0.0 < h < np.inf
        world.step(0.9 * h, 2)


@pytest.mark.compiled  # a box that is nowhere has a cell for compiled code only
def test_a_target_that_was_written_over_is_named(world):
    hold = world.add_joint((0.0, 0.0, 1.0), (world.boxes[0], (2.0, 0.0, 0.0)), 1.0)
    world.step(1e-3)
    hold.target[:] = np.nan
    before = world.state_hash()
    with pytest.raises(ParameterError, match="target of joint 1 is not finite"):
        world.step(1e-3, 5)
    assert (world.steps, world.state_hash()) == (1, before)


def test_ends_can_be_asked_for_while_others_remove_bodies(world):
    hold = world.joints[0]
    stop, wrong = threading.Event(), []

    def come_and_go():
        while not stop.is_set() and not wrong:
            try:
                box = world.add_box((0.2, 0.2, 0.2), 1.0, (9.0, 0.0, 0.0))
                world.add_joint((box, box.position), (9.0, 0.0, 1.0), 1.0)
                world.remove(box)
            except BusyError:
                continue
            except RuntimeError as error:
                wrong.append(error)

    thread = threading.Thread(target=come_and_go)
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    thread.start()
    try:
        for k in range(300):
            with contextlib.suppress(ParameterError, BusyError):  # it is gone; somebody else has their turn
                last = world.joints[-1]
                assert last.length >= 0.0
                last.stiffness = 2.0
                world.boxes[0].friction = 0.1 + 0.001 * k
                hold.stiffness = 1.0 + k
            joints = world.store.joints._asdict().items()
            sizes = {len(array) for name, array in joints if name.startswith("joint_")}
            assert len(sizes) == 1
            model = world.model
            assert len(model.box_friction) == model.box_count
    finally:
        stop.set()
        thread.join()
        sys.setswitchinterval(before)
    assert not wrong
