"""Does a cache that cannot be read count as one that is not there?"""

import pytest

pytest.importorskip("softbody.compile_once", reason="Numba's internals are not as expected", exc_type=ImportError)

from softbody.compile_once import _CacheFile

KEY, DATA = ("kernel", "signature"), ("machine", "code")


class Gone:
    """A type of an older core."""


def test_an_index_that_names_types_of_an_older_core_counts_as_empty_and_is_written_anew(tmp_path, monkeypatch):
    cache = _CacheFile(str(tmp_path), "kernel", 1.0)
    cache.save((*KEY, Gone), DATA)
    assert cache.load((*KEY, Gone)) == DATA
    monkeypatch.delattr(f"{__name__}.Gone")
    assert cache.load(KEY) is None
    cache.save(KEY, DATA)
    assert cache.load(KEY) == DATA


@pytest.mark.parametrize("damage", [b"", b"\x80", b"no pickle at all"])
def test_damaged_files_count_as_not_there(tmp_path, damage):
    cache = _CacheFile(str(tmp_path), "kernel", 1.0)
    for kind in ("*.nbi", "*.nbc"):
        cache.save(KEY, DATA)
        for path in tmp_path.glob(kind):
            path.write_bytes(damage)
        assert cache.load(KEY) is None
    cache.save(KEY, DATA)
    assert cache.load(KEY) == DATA
