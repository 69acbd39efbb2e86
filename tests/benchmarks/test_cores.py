"""The newest cores are kept, and those in use; a core that is removed is gone whole, and comes back when asked for."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from benchmarks import cores


@pytest.fixture
def store(tmp_path, monkeypatch):
    """Return an empty store for two."""
    monkeypatch.setattr(cores, "KEPT", 2)
    (tmp_path / "store").mkdir()
    return tmp_path / "store"


def made(tmp_path, number):
    """Lay out a core that has a number in it."""
    folder = tmp_path / str(number) / cores.CORE
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "__init__.py").write_text(f"NUMBER = {number}\n")
    return folder.parent


KEEP = """
import sys
from pathlib import Path
from benchmarks.cores import kept
print(kept(*map(Path, sys.argv[1:])), flush=True)
sys.stdin.read()
"""


def keeping(tmp_path, store, number):
    """Start a process that uses a core until its standard input is closed; it prints the folder."""
    command = [sys.executable, "-c", KEEP, str(made(tmp_path, number)), str(store)]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def unused(tmp_path, store, number):
    """Return a core that was used by a process which is no more, so many seconds after the first."""
    folder = store / keeping(tmp_path, store, number).communicate()[0].strip()
    os.utime(folder, (1e9 + number, 1e9 + number))
    return folder


def test_the_newest_are_kept(store, tmp_path):
    folders = [unused(tmp_path, store, number) for number in (3, 1, 4, 2)]
    assert cores.prune(store) == 2
    assert sorted(store.iterdir()) == sorted([folders[0], folders[2]])
    assert (folders[0] / cores.CORE / "__init__.py").read_text() == "NUMBER = 3\n"
    assert cores.prune(store) == 0


def test_what_is_asked_for_again_is_the_newest(store, tmp_path):
    folders = [unused(tmp_path, store, number) for number in (1, 2, 3)]
    keeping(tmp_path, store, 1).communicate()
    cores.prune(store)
    assert sorted(store.iterdir()) == sorted([folders[0], folders[2]])


def test_one_in_use_by_another_process_is_kept_until_that_ends(store, tmp_path):
    with keeping(tmp_path, store, 0) as other:
        folder = store / other.stdout.readline().strip()
        os.utime(folder, (1e9, 1e9))
        newer = [unused(tmp_path, store, number) for number in (1, 2, 3)]
        assert cores.prune(store) == 1
        assert sorted(store.iterdir()) == sorted([folder, *newer[1:]])
        other.stdin.close()
    assert cores.prune(store) == 1
    assert sorted(store.iterdir()) == sorted(newer[1:])


def test_one_that_was_removed_is_laid_out_anew(store, tmp_path):
    first = unused(tmp_path, store, 0)
    for number in (1, 2):
        unused(tmp_path, store, number)
    cores.prune(store)
    assert not first.exists()
    assert cores.kept(made(tmp_path, 0), store) == first
    assert (first / cores.CORE / "__init__.py").read_text() == "NUMBER = 0\n"
    os.utime(first, (1.0, 1.0))
    cores.prune(store)
    assert first.exists()  # this process uses it


def test_other_folders_are_left_alone(store, tmp_path):
    (store / "mine").mkdir()
    for number in range(4):
        unused(tmp_path, store, number)
    cores.prune(store)
    assert (store / "mine").exists()
