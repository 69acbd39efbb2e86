"""Is machine code kept for each signature alone, and does what cannot be read count as not there?"""

import pytest

pytest.importorskip("softbody.compile_once", reason="Numba's internals are not as expected", exc_type=ImportError)

from softbody.cache_file import CacheFile

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


def test_what_cannot_be_kept_leaves_nothing_behind(tmp_path):
    cache = CacheFile(str(tmp_path), "kernel")
    with pytest.raises(TypeError):
        cache.save(KEY, (each for each in DATA))
    assert not list(tmp_path.iterdir())
