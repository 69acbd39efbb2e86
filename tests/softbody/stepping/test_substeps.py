"""Do soft bodies take a step in as many parts as a world, or a call, says, and contacts as one?"""

import numpy as np
import pytest

import softbody
from softbody import ParameterError, World
from softbody.render import Recorder
from softbody.scenes import scene_file
from softbody.stepping.time_steps import BOX_STEP, OF_STABLE
from softbody.trajectory import Trajectory, TrajectoryWriter

BALL = softbody.icosphere(1, 0.3)


def two_balls(**choices):
    """Return a world in which a ball falls on another one that lies on the ground."""
    world = World(**choices)
    world.add_ground()
    world.add_soft_body(BALL, 1.0, 200.0, 6.0, (0.0, 0.0, 0.3))
    world.add_soft_body(softbody.icosphere(2, 0.2), 0.3, 300.0, 2.0, (0.05, 0.02, 0.85), velocity=(0.0, 0.0, -2.0))
    return world


def test_what_a_world_says_is_what_its_steps_say():
    said, told = two_balls(substeps=3), two_balls()
    said.step(2e-3, 200)
    told.step(2e-3, 200, substeps=3)
    assert said.state_hash() == told.state_hash() != two_balls().state_hash()
    assert len(said.contact_points().depth) > 0


def test_a_call_has_the_last_word_and_the_world_keeps_its_own():
    world, other = two_balls(substeps=3), two_balls()
    world.step(1e-3, 50, substeps=1)
    other.step(1e-3, 50)
    assert world.state_hash() == other.state_hash()
    assert world.substeps == 3


def test_the_stable_step_is_that_of_a_part_times_their_number_and_is_taken():
    world = two_balls()
    one = world.stable_time_step()
    world.substeps = 4
    assert world.stable_time_step() == 4.0 * one
    world.step(world.stable_time_step(), 2)
    with pytest.raises(ParameterError, match=r"time_step / substeps is .*, or substeps=5, or say"):
        world.step(1.01 * world.stable_time_step())


def test_joints_act_once_a_step_and_limit_it():
    world = two_balls()
    world.add_joint((world.soft_bodies[0], 0), (0.0, 0.0, 1.0), stiffness=2e4)
    few = world.stable_time_step()
    world.substeps = 1_000
    most = world.stable_time_step()
    assert few < most < 10.0 * few
    world.step(most, 10)
    with pytest.raises(ParameterError, match="joints allow"):
        world.step(1.01 * most)


def test_the_steps_that_a_world_chooses_are_so_many_times_as_long():
    world, frame = two_balls(substeps=2), 1.0 / 60.0
    assert world.step_frame(frame) == np.ceil(frame / (2.0 * OF_STABLE * two_balls().stable_time_step()))
    world.add_box((0.1, 0.1, 0.1), 1.0, (3.0, 0.0, 1.0))
    world.substeps = 1_000
    assert world.step_frame(frame) == round(frame / BOX_STEP)


def test_a_snapshot_keeps_them(tmp_path):
    world = two_balls(substeps=5)
    world.step(4e-3, 20)
    world.save(tmp_path / "world.npz")
    loaded = World.load(tmp_path / "world.npz")
    assert loaded.substeps == 5
    for each in (world, loaded):
        each.run(0.1)
    assert loaded.state_hash() == world.state_hash()


@pytest.mark.parametrize("value", [0, -1, 1.0, "2", None, 10_000_001])
def test_numbers_of_parts_that_are_none_are_refused(value):
    world = two_balls(substeps=2)
    with pytest.raises(ParameterError, match="substeps is"):
        world.substeps = value
    with pytest.raises(ParameterError, match="substeps is"):
        World(substeps=value)
    assert world.substeps == 2


@pytest.mark.parametrize(
    ("said", "message"),
    [
        ({"substeps": 2}, r"substeps is 2, and there is no time_step, .* set world\.substeps"),
        ({"allow_unstable": True}, "allow_unstable is True, and there is no time_step"),
        ({"allow_unstable": 1}, "give True or False"),
    ],
)
def test_what_is_said_of_steps_that_the_world_chooses_is_refused(tmp_path, said, message):
    world = two_balls()
    film, kept = Recorder(world, tmp_path / "film.webp"), TrajectoryWriter(world, tmp_path / "kept")
    for each in (world, film, kept):
        with pytest.raises(ParameterError, match=message):
            each.run(0.1, **said)
    assert world.steps == 0


def test_films_and_trajectories_are_of_the_worlds_parts(tmp_path):
    worlds = [two_balls(substeps=2) for _ in range(3)]
    worlds[0].run(0.2, 2e-3, substeps=4)
    with Recorder(worlds[1], tmp_path / "film.webp", 10.0, size=(32, 24)) as film:
        film.run(0.2, 2e-3, substeps=4)
    with TrajectoryWriter(worlds[2], tmp_path / "kept", 10.0) as kept:
        kept.run(0.1)
        kept.run(0.1)
    assert worlds[0].state_hash() == worlds[1].state_hash()
    assert worlds[2].steps < 2.0 * np.ceil(0.1 / (OF_STABLE * two_balls().stable_time_step()))
    assert len(Trajectory(tmp_path / "kept")) == 3


def test_a_scene_file_says_them(tmp_path):
    path = tmp_path / "scene.toml"
    body = "[[soft_body]]\nshape = { name = 'icosphere', subdivisions = 1 }\nmass = 1.0\nstiffness = 200.0\ngas = 5.0\n"
    path.write_text(f"[world]\nsubsteps = 2\n{body}")
    assert scene_file.read_scene(path).world.substeps == 2
    assert scene_file.read_scene(path, substeps=3).world.substeps == 3
    path.write_text(f"[world]\nsubsteps = true\n{body}")
    with pytest.raises(softbody.SceneError, match="substeps"):
        scene_file.read_scene(path)
