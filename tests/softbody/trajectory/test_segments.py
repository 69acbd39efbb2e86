"""Are bodies that come and go kept to the last bit, whatever ends that, and is a damaged folder one typed error?"""

import errno
import json
import os
import pickle

import numpy as np
import pytest

import softbody
from softbody import OutputError, ParameterError, Trajectory, TrajectoryError, TrajectoryWriter, World
from softbody.storage import atomic_file
from softbody.trajectory import writer as writing

pytestmark = pytest.mark.interpreted


def new_world(boxes=1):
    world = World()
    world.add_soft_body(softbody.octahedron(), 1.0, 100.0, 10.0, (0.0, 0.0, 2.0), name="ball")
    for k in range(boxes):
        world.add_box((1.0, 2.0, 1.0 + k), 1.0, (9.0 + 5.0 * k, 0.0, 2.0))
    return world


class Beside:
    """What a test itself keeps of each frame: copies of arrays, and what bodies there are."""

    def __init__(self):
        self.rows = []

    def note(self, world):
        state = world.state.copy()
        meshes = [body.triangles.copy() for body in world.soft_bodies]
        sizes = [box.size for box in world.boxes]
        names = [body.name for body in (*world.soft_bodies, *world.boxes)]
        self.rows.append((world.time, state, meshes, sizes, names))

    def check(self, kept):
        assert len(kept) == len(self.rows)
        for frame, (time, state, meshes, sizes, names) in zip(kept, self.rows):
            bodies = frame.bodies
            assert frame.time == time
            np.testing.assert_array_equal(frame.positions, state.particle_position)
            np.testing.assert_array_equal(frame.velocities, state.particle_velocity)
            np.testing.assert_array_equal(frame.box_positions, state.box_position)
            np.testing.assert_array_equal(frame.box_orientations, state.box_orientation)
            assert (bodies.soft_count, bodies.box_count) == (len(meshes), len(sizes))
            assert [*bodies.soft_names, *bodies.box_names] == names
            np.testing.assert_array_equal(bodies.box_sizes, np.reshape(sizes, (-1, 3)))
            for k, mesh in enumerate(meshes):
                np.testing.assert_array_equal(bodies.triangles(k), mesh)
            stops = [bodies.particles(k).stop for k in range(len(meshes))]
            assert [0, *stops][-1] == len(frame.positions)


def shake(world, k):
    rng = np.random.default_rng(k)
    for name in ("particle_position", "particle_velocity", "box_position"):
        array = getattr(world.state, name)
        array[:] = rng.normal(size=array.shape)
    world.time = k / 64.0


def keep(kept, world, numbers, beside):
    for k in numbers:
        shake(world, k)
        beside.note(world)
        kept.frame()


def written(path, changes=3):
    """Keep frames 0 to 2 of a ball and a box, 3 to 5 of a box more, and so on."""
    world, beside = new_world(), Beside()
    with TrajectoryWriter(world, path) as kept:
        for k in range(changes):
            if k:
                world.add_box((1.0, 1.0, 1.0 + k), 1.0, (20.0 * k, 0.0, 0.0))
            keep(kept, world, range(3 * k, 3 * k + 3), beside)
    return world, beside


def test_every_frame_has_its_own_bodies(tmp_path, monkeypatch):
    monkeypatch.setattr(writing, "CHUNK_FRAMES", 2)
    world, beside = new_world(2), Beside()
    with TrajectoryWriter(world, tmp_path / "t") as kept:
        keep(kept, world, range(3), beside)
        world.remove(world.boxes[0])
        keep(kept, world, range(3, 8), beside)
        world.remove(world.soft_bodies[0])
        world.add_soft_body(softbody.tetrahedron(), 1.0, 100.0, 10.0, name="ball")
        world.add_soft_body(softbody.octahedron(), 1.0, 100.0, 10.0, (5.0, 0.0, 0.0))
        keep(kept, world, range(8, 9), beside)
        for body in (*world.soft_bodies, *world.boxes):
            world.remove(body)
        keep(kept, world, range(9, 11), beside)
        world.add_box((1.0, 1.0, 1.0), 1.0, name="last")
        keep(kept, world, range(11, 12), beside)
    found = Trajectory.open(tmp_path / "t")
    beside.check(found)
    beside.check(pickle.loads(pickle.dumps(found)))
    assert found.segments == (range(3), range(3, 8), range(8, 9), range(9, 11), range(11, 12))
    assert repr(found) == "<Trajectory: 12 frames until 0.171875 s; bodies change 4 times>"
    assert repr(found[0].bodies) == "<1 soft bodies of 6 particles, 2 boxes>"
    for k in (11, 0, 5, 8, 3, -4):
        assert found[k].bodies.box_count == len(beside.rows[k][3])
    manifest = json.loads((tmp_path / "t" / "trajectory.json").read_text())
    named = {each["bodies"]["file"] for each in manifest["segments"]}
    named |= {chunk["file"] for each in manifest["segments"] for chunk in each["chunks"]}
    assert (manifest["format"], len(named)) == (2, 5 + 2 + 3 + 1 + 1 + 1)
    assert set(os.listdir(tmp_path / "t")) == named | {"trajectory.json"}


def test_members_of_all_frames_are_refused_where_bodies_change(tmp_path):
    world, _ = written(tmp_path / "t")
    found = Trajectory.open(tmp_path / "t")
    for ask in (
        lambda: found.soft_count, lambda: found.box_count, lambda: found.soft_names, lambda: found.box_names,
        lambda: found.box_sizes, lambda: found.particles(0), lambda: found.triangles(0),
    ):  # fmt: skip
        with pytest.raises(ParameterError, match=r"bodies change at frame 3: ask a frame, trajectory\[k\]\.bodies"):
            ask()
    with pytest.raises(
        ParameterError, match="has other bodies than frame 5, which has 1 soft bodies of 6 particles, 2"
    ):
        found.put_into(world, 5)
    found.put_into(world, -2)
    np.testing.assert_array_equal(world.state.box_position, found[7].box_positions)
    with pytest.raises(ParameterError, match="body is 1"):
        found[0].bodies.triangles(1)


def test_bodies_that_do_not_change_are_one_segment_as_ever(tmp_path):
    world = new_world(2)
    with TrajectoryWriter(world, tmp_path / "t") as kept:
        kept.frame()
        world.remove(world.add_box((1.0, 1.0, 1.0), 1.0, (50.0, 0.0, 0.0)))
        kept.frame()
        world.remove(world.boxes[1])
        world.add_box((1.0, 2.0, 2.0), 1.0, (70.0, 0.0, 0.0))  # as the one that went
        kept.frame()
    assert json.loads((tmp_path / "t" / "trajectory.json").read_text())["format"] == 1
    found = Trajectory.open(tmp_path / "t")
    assert (found.segments, found.box_count) == ((range(3),), 2)
    with TrajectoryWriter(world, tmp_path / "t", resume=True) as kept:
        world.remove(world.boxes[1])
        world.add_box((1.0, 2.0, 2.0), 1.0, (70.0, 0.0, 0.0), name="other")
        kept.frame()
    assert Trajectory.open(tmp_path / "t").segments == (range(3), range(3, 4))


def test_bodies_that_change_before_the_first_frame_are_the_first(tmp_path):
    world, beside = new_world(), Beside()
    with TrajectoryWriter(world, tmp_path / "t") as kept:
        world.add_box((3.0, 3.0, 3.0), 1.0, (30.0, 0.0, 0.0))
        kept.flush()
        assert Trajectory.open(tmp_path / "t").box_count == 1
        keep(kept, world, range(2), beside)
    beside.check(Trajectory.open(tmp_path / "t"))
    assert Trajectory.open(tmp_path / "t").box_count == 2
    assert sorted(os.listdir(tmp_path / "t")) == ["000000.npz", "bodies-000001.npz", "trajectory.json"]
    with TrajectoryWriter(world, tmp_path / "t", resume=True) as kept:
        keep(kept, world, range(2, 3), beside)
    beside.check(Trajectory.open(tmp_path / "t"))


def test_a_refused_frame_begins_no_segment(tmp_path):
    world = new_world()
    with TrajectoryWriter(world, tmp_path / "t") as kept:
        kept.frame()
        box = world.add_box((3.0, 3.0, 3.0), 1.0, (30.0, 0.0, 0.0))
        world.state.box_position[1] = np.nan
        with pytest.raises(ParameterError, match="cannot be kept: box_position"):
            kept.frame()
        world.remove(box)
        kept.frame()
    assert Trajectory.open(tmp_path / "t").segments == (range(2),)


def test_a_run_goes_on_over_changes(tmp_path):
    world = new_world()
    with TrajectoryWriter(world, tmp_path / "t", 20.0) as kept:
        kept.run(0.2)
        world.add_box((1.0, 1.0, 1.0), 1.0, (50.0, 0.0, 0.0))
        kept.run(0.2)
    found = Trajectory.open(tmp_path / "t")
    np.testing.assert_allclose(found.times, np.arange(9) * 0.05, atol=1e-12)
    assert found.segments == (range(5), range(5, 9))


@pytest.mark.parametrize("stay", range(10))
def test_it_is_gone_on_with_by_the_bodies_of_then(tmp_path, monkeypatch, stay):
    monkeypatch.setattr(writing, "CHUNK_FRAMES", 2)
    _, beside = written(tmp_path / "t")
    world = new_world()
    for k in range(1, 1 + (max(stay, 1) - 1) // 3):
        world.add_box((1.0, 1.0, 1.0 + k), 1.0, (20.0 * k, 0.0, 0.0))
    world.time = (stay - 1) / 64.0 if stay else 0.0
    if not stay:
        first = tmp_path / "t" / "trajectory.json"
        first.write_text(first.read_text().replace("0.0,", "0.001,"))  # so that no frame stays
    del beside.rows[stay:]
    with TrajectoryWriter(world, tmp_path / "t", resume=True) as kept:
        assert kept.frames == stay
        assert len(Trajectory.open(tmp_path / "t").times) == 9
        if stay % 2:
            world.add_soft_body(softbody.tetrahedron(), 1.0, 100.0, 10.0, (50.0, 0.0, 0.0))
        keep(kept, world, range(stay, stay + 3), beside)
    beside.check(Trajectory.open(tmp_path / "t"))
    manifest = (tmp_path / "t" / "trajectory.json").read_text()
    assert all(name in manifest for name in os.listdir(tmp_path / "t") if name != "trajectory.json")


def test_of_frames_at_the_worlds_time_those_of_its_bodies_stay(tmp_path):
    world, beside = new_world(), Beside()
    with TrajectoryWriter(world, tmp_path / "t") as kept:
        keep(kept, world, range(3), beside)
        before = pickle.loads(pickle.dumps(world))
        world.add_box((3.0, 3.0, 3.0), 1.0, (30.0, 0.0, 0.0))
        kept.frame()
    assert len(Trajectory.open(tmp_path / "t")) == 4
    with TrajectoryWriter(before, tmp_path / "t", resume=True) as kept:
        assert kept.frames == 3
        keep(kept, before, range(3, 5), beside)
    beside.check(Trajectory.open(tmp_path / "t"))
    other = new_world(3)
    other.time = 2 / 64.0
    with pytest.raises(TrajectoryError, match="the world has 3 boxes, and its trajectory had 1 then"):
        TrajectoryWriter(other, tmp_path / "t", resume=True)


def test_bodies_other_than_those_of_then_are_refused(tmp_path):
    world, beside = written(tmp_path / "t")
    for time, had in ((0.0, 1), (4 / 64.0, 2), (5.5 / 64.0, 2)):
        world.time = time
        with pytest.raises(TrajectoryError, match=f"the world has 3 boxes, and its trajectory had {had} then"):
            TrajectoryWriter(world, tmp_path / "t", resume=True)
    beside.check(Trajectory.open(tmp_path / "t"))


@pytest.mark.parametrize("moment", range(3))
@pytest.mark.parametrize("when", ["before", "after"])
def test_an_interrupt_in_the_midst_of_writing_a_segment_costs_nothing(tmp_path, monkeypatch, moment, when):
    """Ctrl-C comes when the bodies, a chunk or the manifest are put in their places, or just after that."""
    world, beside, real, calls = new_world(), Beside(), atomic_file.Path.replace, []

    def replace(part, path):
        calls.append(path.name)
        if when == "after":
            real(part, path)
        if len(calls) == moment + 1:
            raise KeyboardInterrupt
        if when == "before":
            real(part, path)

    kept = TrajectoryWriter(world, tmp_path / "t")
    keep(kept, world, range(2), beside)
    world.add_box((3.0, 3.0, 3.0), 1.0, (30.0, 0.0, 0.0))
    keep(kept, world, range(2, 4), beside)
    with monkeypatch.context() as interrupted:
        interrupted.setattr(atomic_file.Path, "replace", replace)
        with pytest.raises(KeyboardInterrupt):
            kept.flush()
    assert calls == ["bodies-000001.npz", "000001.npz", "trajectory.json"][: moment + 1]
    assert len(list(Trajectory.open(tmp_path / "t"))) == (4 if (moment, when) == (2, "after") else 2)
    keep(kept, world, range(4, 5), beside)
    world.remove(world.boxes[0])
    keep(kept, world, range(5, 6), beside)
    kept.close()
    beside.check(Trajectory.open(tmp_path / "t"))


def test_a_full_disk_at_a_change_costs_nothing_and_can_be_cured(tmp_path, monkeypatch):
    world, beside = new_world(), Beside()
    with TrajectoryWriter(world, tmp_path / "t") as kept:
        keep(kept, world, range(2), beside)
        world.add_box((3.0, 3.0, 3.0), 1.0, (30.0, 0.0, 0.0))
        shake(world, 2)
        with monkeypatch.context() as full:
            full.setattr(os, "fsync", lambda _: (_ for _ in ()).throw(OSError(errno.ENOSPC, "No space left on device")))
            with pytest.raises(OutputError, match="No space left on device"):
                kept.frame()
        assert kept.frames == 2
        keep(kept, world, range(2, 4), beside)
    beside.check(Trajectory.open(tmp_path / "t"))


def in_segment(number, **changes):
    """Return what changes entries of a segment."""

    def change(folder):
        path = folder / "trajectory.json"
        manifest = json.loads(path.read_text())
        manifest["segments"][number] |= changes
        path.write_text(json.dumps(manifest))

    return change


def in_manifest(change):
    def changed(folder):
        path = folder / "trajectory.json"
        manifest = json.loads(path.read_text())
        change(manifest)
        path.write_text(json.dumps(manifest))

    return changed


def other_bodies(folder):
    (folder / "bodies-000001.npz").write_bytes((folder / "bodies.npz").read_bytes())


DAMAGE = {
    "no segments": (in_manifest(lambda found: found.pop("segments")), "segments must be a list of one at least"),
    "empty": (in_manifest(lambda found: found["segments"].clear()), "segments must be a list of one at least"),
    "none": (in_manifest(lambda found: found["segments"].insert(0, 3)), r"segments\[0\] must be an object"),
    "as format 1": (in_manifest(lambda found: found.update(format=1)), r"bodies\.sha256 must be one"),
    "no frames": (in_segment(1, chunks=[]), r"segments\[1\]\.chunks must have one at least"),
    "no chunks": (in_segment(1, chunks=None), r"segments\[1\]\.chunks must be a list"),
    "labels": (in_segment(2, labels=3), r"segments\[2\]\.labels must have soft, box and held"),
    "other labels": (
        in_segment(2, labels={"soft": ["ball"], "box": [""], "held": [False]}),
        r"labels of other numbers of bodies than there are in bodies-000002\.npz",
    ),
    "no bodies": (in_segment(1, bodies=None), r"segments\[1\]\.bodies\.file must be such as bodies\.npz"),
    "elsewhere": (
        in_manifest(lambda found: found["segments"][1]["bodies"].update(file="../bodies.npz")),
        r"segments\[1\]\.bodies\.file must be such as bodies\.npz",
    ),
    "no hash": (
        in_manifest(lambda found: found["segments"][1]["bodies"].update(sha256="0")),
        r"segments\[1\]\.bodies\.sha256 must be one",
    ),
    "bodies twice": (
        in_manifest(lambda found: found["segments"][1]["bodies"].update(file="bodies.npz")),
        "chunks must have a file each, and bodies, too",
    ),
    "chunks twice": (
        in_manifest(lambda found: found["segments"][1]["chunks"][0].update(file="000000.npz")),
        "chunks must have a file each",
    ),
    "back": (in_manifest(lambda found: found["segments"].reverse()), "times of chunks must not go back"),
    "other bodies": (other_bodies, r"bodies-000001\.npz is of other bodies than trajectory\.json says"),
    "missing": (lambda folder: (folder / "bodies-000002.npz").unlink(), r"bodies-000002\.npz is missing"),
    "cut": (lambda folder: os.truncate(folder / "bodies-000001.npz", 300), r"bodies-000001\.npz is no NPZ file"),
    "chunk": (
        lambda folder: (folder / "000001.npz").write_bytes((folder / "000000.npz").read_bytes()),
        r"000001\.npz: time is not what",
    ),
}


@pytest.mark.parametrize("name", DAMAGE)
def test_damage_is_one_typed_error_that_names_what_and_the_cure(tmp_path, name):
    written(tmp_path / "t")
    damage, message = DAMAGE[name]
    damage(tmp_path / "t")
    with pytest.raises(TrajectoryError, match=message):
        list(Trajectory.open(tmp_path / "t"))
