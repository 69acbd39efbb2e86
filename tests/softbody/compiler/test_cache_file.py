"""Is machine code kept for each signature alone, and does what cannot be read count as not there?"""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip(
    "softbody.compiler.compile_once", reason="Numba's internals are not as expected", exc_type=ImportError
)

import softbody
from softbody.compiler.cache_file import DAY, CacheFile
from softbody.compiler.core_digest import core_digest

KEY, OTHER_KEY, DATA = ("kernel", "signature"), ("kernel", "another one"), ("machine", "code")


class Gone:
    """A type of an older core."""


def test_each_key_has_data_of_its_own(tmp_path):
    # Two processes that do not know of each other: one list of keys for both is what loses entries.
    one, other = CacheFile(str(tmp_path), "kernel"), CacheFile(str(tmp_path), "kernel")
    assert one.load(KEY) is None
    assert other.load(OTHER_KEY) is None
    one.save(KEY, DATA)
    other.save(OTHER_KEY, "other code")
    assert one.load(OTHER_KEY) == "other code"
    assert other.load(KEY) == DATA
    assert CacheFile(str(tmp_path), "another kernel").load(KEY) is None
    one.flush()
    assert other.load(OTHER_KEY) is None


def test_a_file_that_holds_another_key_counts_as_not_there(tmp_path):
    cache = CacheFile(str(tmp_path), "kernel")
    cache.save(KEY, DATA)
    cache._path(KEY).rename(cache._path(OTHER_KEY))
    assert cache.load(OTHER_KEY) is None


def test_data_of_a_type_that_is_gone_counts_as_not_there_and_is_written_anew(tmp_path, monkeypatch):
    cache = CacheFile(str(tmp_path), "kernel")
    cache.save(KEY, Gone)
    assert cache.load(KEY) is Gone
    monkeypatch.delattr(f"{__name__}.Gone")
    assert cache.load(KEY) is None
    cache.save(KEY, DATA)
    assert cache.load(KEY) == DATA


@pytest.mark.parametrize("damage", ["emptied", "cut", "a bit", "no pickle"])
def test_damaged_files_count_as_not_there(tmp_path, damage):
    cache = CacheFile(str(tmp_path), "kernel")
    cache.save(KEY, DATA)
    (path,) = tmp_path.iterdir()
    raw = bytearray(path.read_bytes())
    raw[-1] ^= 1
    path.write_bytes({"emptied": b"", "cut": raw[:-3], "a bit": bytes(raw), "no pickle": b"no pickle"}[damage])
    assert cache.load(KEY) is None
    cache.save(KEY, DATA)
    assert cache.load(KEY) == DATA


@pytest.mark.skipif(os.name != "posix", reason="pipes and devices are those of POSIX")
@pytest.mark.parametrize("what", ["pipe", "device", "loop", "link to nothing"])
def test_what_is_no_file_counts_as_not_there_and_is_replaced(tmp_path, what):
    cache = CacheFile(str(tmp_path), "kernel")
    path = cache._path(KEY)
    if what == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to({"device": "/dev/zero", "loop": path.name, "link to nothing": "nowhere"}[what])
    assert cache.load(KEY) is None
    cache.save(KEY, DATA)
    assert cache.load(KEY) == DATA


def test_a_folder_in_the_way_is_an_error_of_the_disk(tmp_path):
    cache = CacheFile(str(tmp_path), "kernel")
    (cache._path(KEY) / "full").mkdir(parents=True)
    assert cache.load(KEY) is None
    with pytest.raises(OSError, match="directory"):
        cache.save(KEY, DATA)
    assert [path.name for path in tmp_path.iterdir()] == [cache._path(KEY).name]


@pytest.mark.skipif(os.name != "posix", reason="modes are those of POSIX")
@pytest.mark.parametrize(("folder", "file"), [(0o777, 0o644), (0o755, 0o644), (0o750, 0o640), (0o700, 0o600)])
def test_whom_a_folder_lets_in_may_read_and_not_write(tmp_path, folder, file):
    tmp_path.chmod(folder)
    cache = CacheFile(str(tmp_path), "kernel")
    cache.save(KEY, DATA)
    assert cache._path(KEY).stat().st_mode & 0o777 == file


def test_what_cannot_be_kept_leaves_nothing_behind(tmp_path):
    cache = CacheFile(str(tmp_path), "kernel")
    with pytest.raises(TypeError):
        cache.save(KEY, (each for each in DATA))
    assert not list(tmp_path.iterdir())


def test_what_was_not_used_for_long_is_removed_when_something_is_kept(tmp_path):
    cache, now = CacheFile(str(tmp_path), "kernel"), time.time()
    for key, days in (KEY, 29), (OTHER_KEY, 31):
        cache.save(key, DATA)
        os.utime(cache._path(key), (now - days * DAY,) * 2)
    (tmp_path / "another.nbc").touch()
    os.utime(tmp_path / "another.nbc", (now - 99 * DAY,) * 2)
    cache.save("a third", DATA)
    assert not cache._path(OTHER_KEY).exists()
    assert (tmp_path / "another.nbc").exists()
    assert cache.load(KEY) == DATA
    assert cache._path(KEY).stat().st_mtime > now - DAY  # it was used


PROGRAM = """
import warnings
import numba.core.caching as caching
{damage}
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    import softbody
    print(softbody.tetrahedron().volume > 0.0)
print([str(each.message)[:27] for each in said if each.category is softbody.CacheWarning])
"""
DAMAGE = {
    "no folder": "getattr(caching, 'CacheImpl', getattr(caching, '_CacheImpl', None))._locator_classes = []",
    "full disk": "import os\ndef full(*what): raise OSError(28, 'No space left on device')\nos.replace = full",
}


@pytest.mark.parametrize("plain", ["0", "1"])
@pytest.mark.parametrize("damage", DAMAGE)
def test_a_core_that_cannot_keep_machine_code_runs_and_says_so_once(tmp_path, damage, plain):
    if (damage, plain) == ("full disk", "1"):
        pytest.skip("Numba's own cache writes as it likes")
    core = tmp_path / "softbody"  # without caches that could be read
    shutil.copytree(Path(softbody.__file__).parent, core, ignore=shutil.ignore_patterns("__pycache__"))
    environment = os.environ | {
        "NUMBA_CACHE_DIR": str(tmp_path / "cache"),
        "SOFTBODY_PLAIN_NUMBA": plain,
        "PYTHONPATH": str(tmp_path),
    }
    program = [sys.executable, "-c", PROGRAM.format(damage=DAMAGE[damage])]
    run = subprocess.run(program, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert run.stdout.splitlines() == ["True", "['machine code cannot be kept']"], run.stderr


def test_an_editors_lock_is_no_part_of_the_core(tmp_path):
    core = tmp_path / "softbody"
    shutil.copytree(Path(softbody.__file__).parent, core, ignore=shutil.ignore_patterns("__pycache__"))
    (core / ".#world.py").symlink_to("somebody@somewhere.1234")
    (core / ".world.py.swp.py").write_text("not Python")
    program = "from softbody.compiler.core_digest import core_digest; print(core_digest())"
    run = subprocess.run(
        [sys.executable, "-c", program],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": ""},
        capture_output=True,
        text=True,
    )
    assert run.stdout.strip() == core_digest(), run.stderr
