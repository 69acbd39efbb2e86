"""Is what a world did kept to the last bit, whatever ends it, and is a damaged folder one typed error?"""

import errno
import io
import json
import os
import pickle
import shutil
import threading
import zipfile

import numpy as np
import pytest

import softbody
from softbody import OutputError, ParameterError, State, Trajectory, TrajectoryError, TrajectoryWriter, World
from softbody.storage import atomic_file
from softbody.trajectory import writer as writing


@pytest.fixture
def world():
    """A ball, a tetrahedron and two boxes."""
    return new_world()


def new_world():
    world = World()
    world.add_soft_body(softbody.octahedron(), 1.0, 100.0, 10.0, (0.0, 0.0, 2.0))
    world.add_soft_body(softbody.tetrahedron(), 1.0, 100.0, 10.0, (5.0, 0.0, 2.0))
    world.add_box((1.0, 2.0, 3.0), 1.0, (9.0, 0.0, 2.0))
    world.add_box((1.0, 1.0, 1.0), None, (20.0, 0.0, 2.0))
    return world


def moved(world, k):
    """Put everything somewhere else, as if time had gone on to frame k."""
    rng = np.random.default_rng(k)
    for name in ("particle_position", "particle_velocity", "box_position", "box_velocity", "box_angular_velocity"):
        array = getattr(world.state, name)
        array[:] = rng.normal(size=array.shape)
    turn = rng.normal(size=(2, 4))
    world.state.box_orientation[:] = turn / np.linalg.norm(turn, axis=1, keepdims=True)
    world.time = k / 64.0
    return world.state.copy()


def keep(world, path, numbers, **options):
    """Keep frames of these numbers; return the states that were kept."""
    states = []
    with TrajectoryWriter(world, path, **options) as kept:
        for k in numbers:
            states.append(moved(world, k))
            kept.frame()
    return states


def same(frame, state):
    np.testing.assert_array_equal(frame.positions, state.particle_position)
    np.testing.assert_array_equal(frame.box_positions, state.box_position)
    np.testing.assert_array_equal(frame.box_orientations, state.box_orientation)
    if frame.velocities is not None:
        np.testing.assert_array_equal(frame.velocities, state.particle_velocity)
        np.testing.assert_array_equal(frame.box_velocities, state.box_velocity)
        np.testing.assert_array_equal(frame.box_angular_velocities, state.box_angular_velocity)


def test_every_frame_is_there_to_the_last_bit(world, tmp_path, monkeypatch):
    monkeypatch.setattr(writing, "CHUNK_FRAMES", 3)
    states = keep(world, tmp_path / "t", range(8))
    kept = Trajectory.open(tmp_path / "t")
    assert len(kept) == len(list(kept)) == 8
    np.testing.assert_array_equal(kept.times, np.arange(8) / 64.0)
    for k in (0, 7, 3, 2, 5, -1, -8):
        assert kept[k].time == kept.times[k]
        same(kept[k], states[k])
    assert sorted(os.listdir(tmp_path / "t")) == [
        "000000.npz", "000001.npz", "000002.npz", "bodies.npz", "trajectory.json"
    ]  # fmt: skip
    assert (kept.soft_count, kept.box_count) == (2, 2)
    for i, body in enumerate(world.soft_bodies):
        np.testing.assert_array_equal(kept.triangles(i), body.triangles)
        np.testing.assert_array_equal(kept[7].positions[kept.particles(i)], body.positions)
    np.testing.assert_array_equal(kept.box_sizes, [[1.0, 2.0, 3.0], [1.0, 1.0, 1.0]])
    assert "8 frames until 0.109375 s; 2 soft bodies of 10 particles, 2 boxes" in repr(kept)
    assert pickle.loads(pickle.dumps(kept))[4].time == kept[4].time


def test_what_is_taken_is_a_copy(world, tmp_path):
    keep(world, tmp_path / "t", range(2))
    kept = Trajectory.open(tmp_path / "t")
    kept[0].positions[:] = np.nan
    assert np.isfinite(kept[0].positions).all()
    assert not kept.times.flags.writeable


def test_velocities_may_be_left_out(world, tmp_path):
    states = keep(world, tmp_path / "t", range(2), velocities=False)
    frame = Trajectory.open(tmp_path / "t")[1]
    same(frame, states[1])
    assert frame.velocities is frame.box_velocities is frame.box_angular_velocities is None


@pytest.mark.parametrize("kind", ["soft", "box"])
def test_soft_bodies_or_boxes_alone(tmp_path, kind):
    world = World()
    if kind == "soft":
        world.add_soft_body(softbody.octahedron(), 1.0, 100.0, 10.0)
    else:
        world.add_box((1.0, 1.0, 1.0), 1.0)
    with TrajectoryWriter(world, tmp_path / "t") as kept:
        kept.frame()
    frame = Trajectory.open(tmp_path / "t")[0]
    assert (len(frame.positions), len(frame.box_positions)) == ((6, 0) if kind == "soft" else (0, 1))


def test_a_world_may_have_no_bodies_yet(tmp_path):
    world = World()
    with TrajectoryWriter(world, tmp_path / "t") as kept:
        kept.frame()
        world.add_box((1.0, 1.0, 1.0), 1.0)
        kept.frame()
    assert [frame.bodies.box_count for frame in Trajectory.open(tmp_path / "t")] == [0, 1]


def test_a_run_keeps_a_frame_whenever_it_is_time(tmp_path):
    world = World()
    world.add_box((1.0, 1.0, 1.0), 1.0)
    with TrajectoryWriter(world, tmp_path / "t", 20.0) as kept:
        kept.run(0.1)
        kept.run(0.1)
        assert kept.frames == 5
        kept.run(0.1, 0.007)
    with TrajectoryWriter(world, tmp_path / "t", 20.0, resume=True) as kept:
        kept.run(0.05)
    times = Trajectory.open(tmp_path / "t").times
    np.testing.assert_allclose(times[:5], np.arange(5) * 0.05, atol=1e-12)
    assert times[-1] == world.time
    assert (np.diff(times) > 0.0).all()
    with TrajectoryWriter(world, tmp_path / "u", 20.0) as kept, pytest.raises(ParameterError, match=r"≤ 0\.05"):
        kept.run(1.0, 0.1)


def test_runs_that_meet_between_frames_keep_those_of_one_run(tmp_path):
    world = World()
    world.add_box((1.0, 1.0, 1.0), 1.0)
    with TrajectoryWriter(world, tmp_path / "t", 10.0) as kept:
        kept.run(0.25, 0.01)
        kept.run(0.25, 0.01)
    np.testing.assert_allclose(Trajectory.open(tmp_path / "t").times, np.arange(6) * 0.1, atol=1e-12)


def test_it_is_kept_in_a_loop_over_frames(tmp_path):
    world = World()
    world.add_box((1.0, 1.0, 1.0), 1.0)
    with TrajectoryWriter(world, tmp_path / "t") as kept:
        for _ in world.frames(0.1):
            kept.frame()
    assert len(Trajectory.open(tmp_path / "t")) == kept.frames == 6


def test_it_can_be_read_while_it_is_written(world, tmp_path):
    kept = TrajectoryWriter(world, tmp_path / "t")
    assert len(Trajectory.open(tmp_path / "t")) == 0
    kept.frame()
    assert len(Trajectory.open(tmp_path / "t")) == 0
    kept.flush()
    early = Trajectory.open(tmp_path / "t")
    state = moved(world, 1)
    kept.frame()
    kept.close()
    kept.close()
    assert (len(early), len(Trajectory.open(tmp_path / "t"))) == (1, 2)
    assert early[0].time == 0.0
    same(Trajectory.open(tmp_path / "t")[1], state)
    with pytest.raises(ParameterError, match="is closed"):
        kept.frame()
    with pytest.raises(IndexError, match="frame 1 is not in this trajectory: there are 1"):
        early[1]
    with pytest.raises(ParameterError, match="no whole number"):
        early[0.5]


def test_a_trajectory_is_gone_on_with(world, tmp_path, monkeypatch):
    monkeypatch.setattr(writing, "CHUNK_FRAMES", 4)
    first = keep(world, tmp_path / "t", range(10))
    other = new_world()
    moved(other, 6)
    with TrajectoryWriter(other, tmp_path / "t", resume=True) as kept:
        assert (kept.frames, kept.last_time) == (7, 6 / 64.0)
        assert len(Trajectory.open(tmp_path / "t")) == 10  # what is later is left out when something is written
        later = [moved(other, k) for k in (100, 101)]
        for k in (100, 101):
            moved(other, k)
            kept.frame()
    found = Trajectory.open(tmp_path / "t")
    assert len(found) == 9
    for frame, state in zip(found, first[:7] + later, strict=True):
        same(frame, state)
    named = {chunk["file"] for chunk in json.loads((tmp_path / "t" / "trajectory.json").read_text())["chunks"]}
    assert set(os.listdir(tmp_path / "t")) == named | {"bodies.npz", "trajectory.json"}


def test_gone_on_with_from_before_its_first_frame_it_is_anew(world, tmp_path):
    keep(world, tmp_path / "t", (5, 6))
    world.time = 0.0
    states = keep(world, tmp_path / "t", (1, 2, 3), resume=True)
    found = Trajectory.open(tmp_path / "t")
    assert len(found) == 3
    same(found[2], states[2])


def test_other_bodies_are_refused(world, tmp_path):
    keep(world, tmp_path / "t", range(2))
    before = {name: (tmp_path / "t" / name).read_bytes() for name in os.listdir(tmp_path / "t")}
    smaller, other = new_world(), new_world()
    smaller.remove(smaller.boxes[0])
    other.remove(other.boxes[1])
    other.add_box((1.0, 1.0, 1.5), None)
    for unlike, message in (
        (smaller, "the world has 1 boxes, and its trajectory had 2 then"),
        (other, "other meshes or sizes"),
    ):
        with pytest.raises(TrajectoryError, match=message):
            TrajectoryWriter(unlike, tmp_path / "t", resume=True)
        with pytest.raises(ParameterError, match="has other bodies"):
            Trajectory.open(tmp_path / "t").put_into(unlike, 0)
    with pytest.raises(TrajectoryError, match="velocities=True"):
        TrajectoryWriter(world, tmp_path / "t", velocities=False, resume=True)
    assert {name: (tmp_path / "t" / name).read_bytes() for name in os.listdir(tmp_path / "t")} == before


def test_what_is_not_finite_or_goes_back_in_time_is_refused_and_costs_nothing(world, tmp_path):
    with TrajectoryWriter(world, tmp_path / "t") as kept:
        moved(world, 3)
        kept.frame()
        for name, value in (("particle_position", np.nan), ("box_velocity", np.inf), ("box_orientation", 2.0)):
            array = getattr(world.state, name)
            before, array[1, 2] = array[1, 2], value
            with pytest.raises(ParameterError, match=f"cannot be kept: {name}"):
                kept.frame()
            array[1, 2] = before
        world.time = 0.0
        with pytest.raises(ParameterError, match="before the last frame"):
            kept.frame()
    assert len(Trajectory.open(tmp_path / "t")) == 1


def test_what_is_in_the_way_is_said_before_anything_is_written(world, tmp_path):
    keep(world, tmp_path / "kept", range(2))
    (tmp_path / "file").write_text("mine")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.tex").write_text("mine")
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    for name, message in (
        ("kept", "holds a trajectory; resume=True goes on with it"),
        ("file", "file cannot be written: File exists"),
        ("file/below", "cannot be written: Not a directory"),
        ("full", "holds other things than a trajectory"),
        ("link", "link cannot be written: File exists"),
    ):
        with pytest.raises(OutputError, match=message):
            TrajectoryWriter(world, tmp_path / name)
        if name != "kept":
            with pytest.raises(OutputError, match=message):
                TrajectoryWriter(world, tmp_path / name, resume=True)
    assert (tmp_path / "file").read_text() == "mine"
    assert os.listdir(tmp_path / "full") == ["thesis.tex"]
    assert len(Trajectory.open(tmp_path / "kept")) == 2
    for path in ("", 3, "a\0b"):
        with pytest.raises(ParameterError, match="give the name of a file"):
            TrajectoryWriter(world, path)
    for options in ({"frames_per_second": 0.0}, {"velocities": 1}, {"resume": "yes"}):
        with pytest.raises(ParameterError, match=next(iter(options))):
            TrajectoryWriter(world, tmp_path / "new", **options)
    assert not (tmp_path / "new").exists()


def test_a_full_disk_costs_nothing_that_is_written_and_can_be_cured(world, tmp_path, monkeypatch):
    states = []
    with TrajectoryWriter(world, tmp_path / "t") as kept:
        for k in range(3):
            states.append(moved(world, k))
            kept.frame()
            if k == 1:
                kept.flush()
        with monkeypatch.context() as full:
            full.setattr(os, "fsync", lambda _: (_ for _ in ()).throw(OSError(errno.ENOSPC, "No space left on device")))
            with pytest.raises(OutputError, match="No space left on device; its first 2 frames are there"):
                kept.flush()
            assert len(Trajectory.open(tmp_path / "t")) == 2
            assert not [name for name in os.listdir(tmp_path / "t") if name.endswith(".part")]
    found = Trajectory.open(tmp_path / "t")
    for frame, state in zip(found, states, strict=True):
        same(frame, state)


@pytest.mark.parametrize("moment", ["chunk", "manifest", "written"])
def test_an_interrupt_in_the_midst_of_writing_costs_nothing(world, tmp_path, monkeypatch, moment):
    """Ctrl-C comes in a chunk, in the manifest, or when that was put in its place; more frames are kept after it."""
    real, calls = atomic_file.Path.replace, []

    def replace(part, path):
        calls.append(path.name)
        if moment == "written":
            real(part, path)
        if (moment == "chunk") == (path.suffix == ".npz"):
            raise KeyboardInterrupt
        return real(part, path) if moment != "written" else path

    states = [moved(world, 0)]
    kept = TrajectoryWriter(world, tmp_path / "t")
    kept.frame()
    with monkeypatch.context() as interrupted:
        interrupted.setattr(atomic_file.Path, "replace", replace)
        with pytest.raises(KeyboardInterrupt):
            kept.flush()
    assert len(Trajectory.open(tmp_path / "t")) == (moment == "written")
    states.append(moved(world, 1))
    kept.frame()
    kept.close()
    for frame, state in zip(Trajectory.open(tmp_path / "t"), states, strict=True):
        same(frame, state)


def test_a_kill_in_the_midst_of_writing_leaves_a_trajectory(world, tmp_path):
    states = keep(world, tmp_path / "t", range(2))
    (tmp_path / "t" / ".0123456789abcdef.part").write_bytes(b"half")
    (tmp_path / "t" / "000001.npz").write_bytes(b"a chunk that the manifest does not know")
    states += keep(world, tmp_path / "t", range(2, 4), resume=True)
    for frame, state in zip(Trajectory.open(tmp_path / "t"), states, strict=True):
        same(frame, state)
    only_bodies = tmp_path / "begun"
    keep(world, only_bodies, range(2))
    (only_bodies / "trajectory.json").unlink()
    (only_bodies / "000000.npz").unlink()
    keep(world, only_bodies, range(3))
    assert len(Trajectory.open(only_bodies)) == 3


def test_two_writers_of_a_folder_are_told(world, tmp_path):
    one = TrajectoryWriter(world, tmp_path / "t")
    two = TrajectoryWriter(world, tmp_path / "t", resume=True)
    one.frame()
    one.close()
    two.frame()
    with pytest.raises(TrajectoryError, match="changed by somebody else"):
        two.close()
    assert len(Trajectory.open(tmp_path / "t")) == 1
    three = TrajectoryWriter(world, tmp_path / "u")
    three.frame()
    shutil.rmtree(tmp_path / "u")
    with pytest.raises(TrajectoryError, match="holds no trajectory"):
        three.close()


@pytest.mark.skipif(os.name != "posix", reason="no locks of folders")
@pytest.mark.parametrize("turn", range(5))
def test_of_writers_at_the_same_time_one_has_the_folder_and_the_others_are_told(tmp_path, turn):
    start, told = threading.Barrier(3), []

    def write():
        world = new_world()
        start.wait()
        try:
            with TrajectoryWriter(world, tmp_path / "t", resume=True) as kept:
                for _ in range(10):
                    kept.frame()
                    kept.flush()
            told.append("")
        except (TrajectoryError, OutputError) as error:
            told.append(str(error))

    writers = [threading.Thread(target=write) for _ in range(3)]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    assert len(list(Trajectory.open(tmp_path / "t"))) >= 10
    assert len(told) == 3
    assert told.count("") >= 1
    assert all("by somebody else" in error or "holds a trajectory" in error for error in told if error)


def test_a_program_may_go_elsewhere_meanwhile(world, tmp_path, monkeypatch):
    for name in ("here", "there"):
        (tmp_path / name).mkdir()
    monkeypatch.chdir(tmp_path / "here")
    with TrajectoryWriter(world, "t") as writer:
        writer.frame()
        early = Trajectory.open("t")
        monkeypatch.chdir(tmp_path / "there")
    assert not os.listdir()
    monkeypatch.chdir(tmp_path / "here")
    kept = Trajectory.open("t")
    monkeypatch.chdir(tmp_path / "there")
    same(kept[0], world.state)
    assert len(early) == 0


def test_a_chunk_is_what_numpy_reads(world, tmp_path):
    states = keep(world, tmp_path / "t", range(2))
    with np.load(tmp_path / "t" / "000000.npz") as chunk:
        kept = [name for name in State._fields if name != "box_time_left"]  # which is no part of where bodies are
        assert set(chunk) == {"time", *kept}
        for name in kept:
            np.testing.assert_array_equal(chunk[name][1], getattr(states[1], name))


def test_a_world_is_put_where_it_was(world, tmp_path):
    states = keep(world, tmp_path / "t", range(3))
    other = new_world()
    Trajectory.open(tmp_path / "t").put_into(other, 1)
    assert other.time == 1 / 64.0
    for a, b in zip(other.state, states[1], strict=True):
        np.testing.assert_array_equal(a, b)
    keep(world, tmp_path / "still", range(3, 5), velocities=False)
    Trajectory.open(tmp_path / "still").put_into(other, 0)
    assert not other.state.particle_velocity.any()


def packed(path, **changes):
    """Write an NPZ file anew, with other entries."""
    with np.load(path, allow_pickle=True) as old:
        entries = dict(old) | changes
    np.savez(path, **{name: value for name, value in entries.items() if value is not None})


def huge_header(path):
    """Replace an entry by one that says that it is huge."""
    entry = io.BytesIO()
    np.lib.format.write_array_header_1_0(entry, {"descr": "<f8", "fortran_order": False, "shape": (10**12, 10, 3)})
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("particle_position.npy", entry.getvalue())


def manifest(**changes):
    """Return what changes entries of the manifest of a folder."""

    def change(folder):
        path = folder / "trajectory.json"
        path.write_text(json.dumps(json.loads(path.read_text()) | changes))

    return change


def in_file(name, change):
    return lambda folder: change(folder / name)


def chunk(**changes):
    return manifest(chunks=[{"file": "000000.npz", "frames": 2, "times": [0.0, 0.015625]} | changes])


DAMAGE = {
    "no chunk": (in_file("000000.npz", os.unlink), r"000000\.npz is missing; copy the whole folder"),
    "no bodies": (in_file("bodies.npz", os.unlink), r"bodies\.npz is missing"),
    "no manifest": (in_file("trajectory.json", os.unlink), r"holds no trajectory: there is no trajectory\.json"),
    "cut": (in_file("000000.npz", lambda path: os.truncate(path, 500)), r"000000\.npz is no NPZ file of a trajectory"),
    "empty": (in_file("000000.npz", lambda path: os.truncate(path, 0)), r"000000\.npz is no NPZ file"),
    "shape": (
        in_file("000000.npz", lambda path: packed(path, particle_position=np.zeros((2, 9, 3)))),
        r"000000\.npz: particle_position has shape \(2, 9, 3\); it must be \(2, 10, 3\)",
    ),
    "kind": (
        in_file("000000.npz", lambda path: packed(path, box_position=np.zeros((2, 2, 3), np.float32))),
        "box_position holds float32",
    ),
    "nan": (
        in_file("000000.npz", lambda path: packed(path, particle_velocity=np.full((2, 10, 3), np.nan))),
        r"particle_velocity\[0, 0, 0\] is nan",
    ),
    "turn": (
        in_file("000000.npz", lambda path: packed(path, box_orientation=np.ones((2, 2, 4)))),
        r"box_orientation\[0, 0\] has length 2",
    ),
    "entry": (in_file("000000.npz", lambda path: packed(path, box_velocity=None)), "'box_velocity' is missing"),
    "more": (in_file("000000.npz", lambda path: packed(path, other=np.zeros(3))), "'other' is no entry of a part"),
    "time": (in_file("000000.npz", lambda path: packed(path, time=np.ones(2))), "a chunk of another trajectory"),
    "pickle": (
        in_file("000000.npz", lambda path: packed(path, time=np.array([{}, {}], object))),
        r"000000\.npz: 'time\.npy' is not what it says",
    ),
    "huge": (in_file("000000.npz", huge_header), "is not what it says"),
    "folder": (
        in_file("000000.npz", lambda path: (path.unlink(), path.mkdir())),
        r"000000\.npz is no file; give one that softbody\.TrajectoryWriter wrote",
    ),
    "pipe": (
        in_file("trajectory.json", lambda path: (path.unlink(), os.mkfifo(path))),
        r"trajectory\.json: it is no file",
    ),
    "triangles": (
        in_file("bodies.npz", lambda path: packed(path, triangle_particles=np.full((12, 3), 7))),
        "go beyond its 6 particles",
    ),
    "starts": (
        in_file("bodies.npz", lambda path: packed(path, soft_particle_start=np.array([0, 7, 6]))),
        "it must begin with 0 and grow",
    ),
    "no starts": (
        in_file("bodies.npz", lambda path: packed(path, soft_particle_start=np.array(3))),
        "soft_particle_start has shape",
    ),
    "other bodies": (
        in_file("bodies.npz", lambda path: packed(path, box_size=np.ones((2, 3)))),
        r"of other bodies than trajectory\.json says",
    ),
    "newer": (manifest(format=3), "format is 3, and this softbody reads formats up to 2: take a newer one"),
    "format": (manifest(format="1"), "format must be 1 or 2"),
    "none": (manifest(format=0), "format must be 1 or 2"),
    "bodies": (manifest(bodies=3), r"bodies\.sha256 must be one"),
    "velocities": (manifest(velocities="yes"), "velocities must be true or false"),
    "chunks": (manifest(chunks={}), "chunks must be a list"),
    "no object": (manifest(chunks=[3]), r"chunks\[0\] must be an object"),
    "elsewhere": (chunk(file="../../etc/passwd"), r"chunks\[0\]\.file must be such as 000000\.npz"),
    "frames": (chunk(frames=3), r"chunks\[0\]\.frames must be the number of its times, 2"),
    "many": (chunk(frames=10**18, times=10**18), r"chunks\[0\]\.times must be times of frames"),
    "not a time": (chunk(times=[0.0, float("nan")]), r"chunks\[0\]\.times must be times of frames"),
    "labels": (manifest(labels={"soft": ["a", ""], "box": ["", "a"], "held": [False, False]}), "another has"),
    "no labels": (manifest(labels=3), "labels must have soft, box and held"),
    "names of numbers": (manifest(labels={"soft": [1, ""], "box": ["", ""], "held": [False, False]}), "a text of 1 to"),
    "held": (manifest(labels={"soft": ["", ""], "box": ["", ""], "held": [0, 1]}), "labels.held must be true or false"),
    "other numbers": (manifest(labels={"soft": [""], "box": [], "held": []}), "labels of other numbers of bodies"),
    "back": (chunk(times=[1.0, 0.5]), "times of chunks must not go back"),
    "no json": (in_file("trajectory.json", lambda path: path.write_bytes(b"\xff{")), "it is no JSON"),
    "deep": (in_file("trajectory.json", lambda path: path.write_text("[" * 10**5)), "it is no JSON"),
    "list": (in_file("trajectory.json", lambda path: path.write_text("[]")), "it is no manifest"),
    "large": (
        in_file("trajectory.json", lambda path: os.truncate(path, 2**26 + 1)),
        "more than 67108864 bytes",
    ),
}


@pytest.mark.parametrize("name", DAMAGE)
def test_damage_is_one_typed_error_that_names_what_and_the_cure(world, tmp_path, name):
    keep(world, tmp_path / "t", range(2))
    damage, message = DAMAGE[name]
    damage(tmp_path / "t")
    with pytest.raises(TrajectoryError, match=message):
        list(Trajectory.open(tmp_path / "t"))


def test_a_folder_of_something_else_and_none_are_one_typed_error(world, tmp_path):
    (tmp_path / "file").write_text("")
    for name in (".", "file", "nowhere"):
        with pytest.raises(TrajectoryError, match=r"holds no trajectory|give the folder of one"):
            Trajectory.open(tmp_path / name)


def test_memory_is_bounded(world, tmp_path):
    keep(world, tmp_path / "t", range(100))
    with pytest.raises(TrajectoryError, match=r"give Trajectory\.open a larger most_bytes"):
        Trajectory.open(tmp_path / "t", most_bytes=30_000)[0]
    assert len(Trajectory.open(tmp_path / "t", most_bytes=300_000)) == 100
