"""Is a file whole whenever it is read, and is no file read that is not a world's?"""

import io
import os
import stat
import threading
import tracemalloc
import zipfile

import numpy as np
import pytest

import softbody
from softbody import ParameterError, SnapshotError, World
from softbody.storage import atomic_file, npz


@pytest.fixture
def world():
    world = World()
    world.add_box((1.0, 2.0, 3.0), 1.0)
    return world


@pytest.fixture
def path(tmp_path):
    return tmp_path / "world.npz"


def test_a_changed_number_in_a_file_is_refused_by_file_and_entry(world, path):
    np.savez(path, **world.snapshot() | {"model.box_inverse_mass": np.array([-1.0])})
    with pytest.raises(SnapshotError, match=r"world\.npz: model\.box_inverse_mass\[0\] is -1\.0"):
        World.load(path)


def packed(snapshot, **options):
    """The bytes of an archive of a snapshot."""
    raw = io.BytesIO()
    with zipfile.ZipFile(raw, "w", **options) as archive:
        for name, array in snapshot.items():
            entry = io.BytesIO()
            np.lib.format.write_array(entry, array)
            archive.writestr(f"{name}.npy", entry.getvalue())
    return raw.getvalue()


def test_an_archive_as_numpy_packs_it_is_read_compressed_or_not(world, path):
    for save in (np.savez, np.savez_compressed):
        save(path, **world.snapshot())
        assert World.load(path).state_hash() == world.state_hash()


def encrypted(raw):
    """The bytes of an archive whose entries say that they are encrypted."""
    raw = bytearray(raw)
    for mark, flags in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        place = raw.find(mark)
        while place >= 0:
            raw[place + flags] |= 1
            place = raw.find(mark, place + 4)
    return bytes(raw)


def npy(array):
    raw = io.BytesIO()
    np.save(raw, array)
    return raw.getvalue()


def one_entry(header, name="time.npy"):
    """The bytes of an archive of an array whose header is that."""
    raw = io.BytesIO()
    with zipfile.ZipFile(raw, "w") as archive:
        archive.writestr(name, b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header)
    return raw.getvalue()


def test_every_other_kind_of_file_is_one_typed_error(world, path):
    good = packed(world.snapshot())
    files = {
        "empty": b"",
        "text": b"no archive",
        "an array": npy(np.zeros(3)),
        "objects": npy(np.array([{}], dtype=object)),
        "a pickle": b"\x80\x04\x95.",
        "half": good[: len(good) // 2],
        "encrypted": encrypted(good),
        "bzip2": packed(world.snapshot(), compression=zipfile.ZIP_BZIP2),
        "lzma": packed(world.snapshot(), compression=zipfile.ZIP_LZMA),
        "objects in it": packed(world.snapshot() | {"time": np.array([{}], dtype=object)}),
        "records in it": packed(world.snapshot() | {"time": np.zeros(3, "i4,f8")}),
        "no array in it": one_entry(b"", "readme.txt"),
        "nothing said": one_entry(b"{}"),
        "too much said": one_entry(b"(" * 60_000),
        "a deep header": one_entry(b"-" * 900 + b"1"),
        "more said than there is": one_entry(b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000,)}"),
        "less than nothing": one_entry(b"{'descr': '<f8', 'fortran_order': False, 'shape': (-1,)}"),
        "nothing in it": packed({}),
        "too many": packed({str(k): np.array(k) for k in range(1_001)}),
    }
    for raw in files.values():
        path.write_bytes(raw)
        with pytest.raises(SnapshotError, match=r"world\.npz"):
            World.load(path)


def test_an_entry_that_is_there_twice_is_refused(world, path):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("time.npy", npy(np.array(0.0)))
        with pytest.warns(UserWarning, match="Duplicate name"):
            archive.writestr("time.npy", npy(np.array(0.0)))
    with pytest.raises(SnapshotError, match=r"'time\.npy' is there twice"):
        World.load(path)


def test_a_flipped_bit_is_found(world, path):
    good = packed(world.snapshot())
    place = good.index(np.float64(-9.81).tobytes()) + 2
    path.write_bytes(good[:place] + bytes([good[place] ^ 1]) + good[place + 1 :])
    with pytest.raises(SnapshotError, match="a damaged one"):
        World.load(path)


def test_what_unpacks_to_too_much_is_refused_before_it_takes_memory_and_may_be_allowed(world, path):
    np.savez_compressed(path, **world.snapshot() | {"state.box_position": np.zeros((10**6, 3))})
    assert path.stat().st_size < 10**5
    tracemalloc.start()
    with pytest.raises(SnapshotError, match=r"24\d+ bytes and more, and 1000000 are allowed; .* a larger most_bytes"):
        World.load(path, most_bytes=10**6)
    assert tracemalloc.get_traced_memory()[1] < 2 * 10**6
    tracemalloc.stop()
    with pytest.raises(SnapshotError, match=r"state\.box_position has shape"):
        World.load(path)
    world.save(path)
    with pytest.raises(SnapshotError, match="and 100 are allowed"):
        World.load(path, most_bytes=100)
    with pytest.raises(ParameterError, match="most_bytes is 0"):
        World.load(path, most_bytes=0)
    assert World.load(path, most_bytes=10**5).state_hash() == world.state_hash()


def test_a_file_that_is_none_is_said_to_be_none(world, tmp_path):
    with pytest.raises(SnapshotError, match="is no file"):
        World.load(tmp_path)
    with pytest.raises(FileNotFoundError):
        World.load(tmp_path / "none.npz")
    for wrong in (None, 3, "", "."):
        with pytest.raises(ParameterError, match="path is"):
            World.load(wrong)
        with pytest.raises(ParameterError, match="path is"):
            world.save(wrong)


def test_a_file_is_saved_with_the_rights_of_any_new_file_and_nothing_is_left_beside_it(world, path):
    world.save(path)
    (path.parent / "other").touch()
    assert sorted(found.name for found in path.parent.iterdir()) == ["other", "world.npz"]
    assert stat.S_IMODE(path.stat().st_mode) == stat.S_IMODE((path.parent / "other").stat().st_mode)


def test_saving_goes_through_no_link(world, path, tmp_path):
    victim = tmp_path / "victim"
    victim.write_text("precious")
    (tmp_path / ".world.npz.part").symlink_to(victim)
    path.symlink_to(victim)
    world.save(path)
    assert victim.read_text() == "precious"
    assert not path.is_symlink()
    assert World.load(path).state_hash() == world.state_hash()


def test_saving_goes_through_no_link_at_the_temporary_name(world, path, tmp_path, monkeypatch):
    victim = tmp_path / "victim"
    victim.write_text("precious")
    monkeypatch.setattr(atomic_file.secrets, "token_hex", lambda size: "known")
    (tmp_path / ".known.part").symlink_to(victim)
    with pytest.raises(FileExistsError):
        world.save(path)
    assert victim.read_text() == "precious"


def test_a_full_disk_leaves_the_old_file_and_nothing_else(world, path, monkeypatch):
    world.save(path)
    before = path.read_bytes()

    def full(file, **arrays):
        file.write(b"PK")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(npz.np, "savez", full)
    with pytest.raises(OSError, match="No space left"):
        world.save(path)
    assert path.read_bytes() == before
    assert [found.name for found in path.parent.iterdir()] == ["world.npz"]


def test_an_interrupt_while_saving_is_an_interrupt(world, path, monkeypatch):
    def interrupted(file, **arrays):
        try:
            raise KeyboardInterrupt
        finally:
            raise ValueError("Can't close the ZIP file")

    monkeypatch.setattr(npz.np, "savez", interrupted)
    with pytest.raises(KeyboardInterrupt):
        world.save(path)
    assert not list(path.parent.iterdir())


def test_a_world_that_could_not_be_read_is_not_written_over_one_that_can(world, path):
    world.save(path)
    before = path.read_bytes()
    world.state.box_position[0, 0] = np.nan
    with pytest.raises(SnapshotError, match=r"state\.box_position\[0, 0\] is nan"):
        world.save(path)
    assert path.read_bytes() == before


@pytest.mark.skipif(not hasattr(os, "fork"), reason="elsewhere an open file cannot be replaced")
def test_two_writers_and_a_reader_never_meet(path):
    worlds = [World(gravity=(0.0, 0.0, float(k))) for k in range(2)]
    worlds[0].save(path)
    errors = []

    def work(one):
        try:
            for _ in range(40):
                worlds[one].save(path) if one < 2 else World.load(path)
        except Exception as error:
            errors.append(error)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not errors
    assert [found.name for found in path.parent.iterdir()] == ["world.npz"]


def test_a_mesh_with_any_numbers_is_saved_and_read(path):
    world = World()
    world.add_soft_body(softbody.octahedron(), 1.0, 10.0, 1.0)
    world.save(path)
    assert World.load(path).state_hash() == world.state_hash()


def test_a_file_takes_no_more_memory_than_it_has_bytes(tmp_path):
    world = World()
    world.add_box((1.0, 1.0, 1.0), 1.0)
    world.save(tmp_path / "w.npz")
    assert World.load(tmp_path / "w.npz", most_bytes=2**62).state_hash() == world.state_hash()
