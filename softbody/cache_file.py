"""Where is the machine code of a kernel kept? In one file for each signature, so that those who write never meet."""

from __future__ import annotations

import hashlib
import os
import pickle
import tempfile
from pathlib import Path
from typing import Any

import numba
from numba.core.serialize import dumps


class CacheFile:
    """What Numba asks for the machine code of one kernel, by key: a signature, a processor, a core.

    A file that cannot be read, is damaged, or holds another key counts as not there, and is written anew. Numba's own
    has one list of all keys, in which processes that write at the same time lose, or mix up, their entries.
    """

    def __init__(self, folder: str, base: str) -> None:
        self._folder, self._base = Path(folder), base

    def load(self, key: Any) -> Any:
        """Return what is kept under a key, or None."""
        try:
            digest, kept = _split(self._path(key).read_bytes())
            if digest != hashlib.sha256(kept).digest():
                return None
            name, data = pickle.loads(kept)
            return data if name == _name(key) else None
        except Exception:  # whatever the disk and unpickling raise
            return None

    def save(self, key: Any, data: Any) -> None:
        """Keep data under a key, whole or not at all."""
        kept = dumps((_name(key), data))
        descriptor, written = tempfile.mkstemp(dir=self._folder, prefix=self._base, suffix=".tmp")
        try:
            with os.fdopen(descriptor, "wb") as file:
                file.write(hashlib.sha256(kept).digest() + kept)
            os.replace(written, self._path(key))
        except BaseException:
            Path(written).unlink(missing_ok=True)
            raise

    def flush(self) -> None:
        """Forget all that is kept of the kernel."""
        for path in self._folder.glob(f"{self._base}.*.nbc"):
            path.unlink(missing_ok=True)

    def _path(self, key: Any) -> Path:
        return self._folder / f"{self._base}.{hashlib.sha256(_name(key).encode()).hexdigest()[:16]}.nbc"


def _split(raw: bytes) -> tuple[bytes, bytes]:
    """Return the digest that a file begins with, and the rest."""
    size = hashlib.sha256().digest_size
    return raw[:size], raw[size:]


def _name(key: Any) -> str:
    """Return a key in words, the same in every process."""
    return f"{numba.__version__} {key!r}"
