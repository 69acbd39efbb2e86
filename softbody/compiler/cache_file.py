"""Disk cache of a kernel's machine code: one file for each signature, so that writers never meet."""

from __future__ import annotations

import hashlib
import os
import pickle
import tempfile
import time
from pathlib import Path
from typing import Any

import numba
from numba.core.serialize import dumps

DAY = 86_400.0  # [s]
KEPT_FOR = 30.0 * DAY  # since it was used last: every edit of the core leaves another set of files


class CacheFile:
    """What Numba asks for the machine code of one kernel, by key: a signature, a processor, a core.

    A file that cannot be read, is damaged, or holds another key counts as not there, and is written anew. Numba's own
    has one list of all keys, in which processes that write at the same time lose, or mix up, their entries.
    """

    def __init__(self, folder: str, base: str) -> None:
        self._folder, self._base = Path(folder), base

    def load(self, key: Any) -> Any:
        """Return what is kept under a key, or None."""
        path = self._path(key)
        try:
            if not path.is_file():  # nor opened: nobody may ever write to a pipe, and a device may have no end
                return None
            digest, kept = _split(path.read_bytes())
            if digest != hashlib.sha256(kept).digest():
                return None
            name, data = pickle.loads(kept)
            if name != _name(key):
                return None
            _note_use(path)
            return data
        except Exception:  # whatever the disk and unpickling raise
            return None

    def has(self, key: Any) -> bool:
        """Tell whether there is anything under a key, be it damaged."""
        return self._path(key).exists()

    def save(self, key: Any, data: Any) -> None:
        """Keep data under a key, whole or not at all, to be read by all whom the folder lets in."""
        kept = dumps((_name(key), data))
        descriptor, written = tempfile.mkstemp(dir=self._folder, prefix=self._base, suffix=".tmp")
        try:
            with os.fdopen(descriptor, "wb") as file:
                file.write(hashlib.sha256(kept).digest() + kept)
            os.chmod(written, 0o600 | 0o044 & self._folder.stat().st_mode)  # others run what it holds
            os.replace(written, self._path(key))
        except BaseException:
            Path(written).unlink(missing_ok=True)
            raise
        self._forget_unused()

    def _forget_unused(self) -> None:
        """Remove what was kept of the kernel for cores, or by processes, that have been gone for long."""
        for path in self._folder.glob(f"{self._base}*"):
            try:
                if path.suffix in (".nbc", ".nbi", ".tmp") and time.time() - path.stat().st_mtime > KEPT_FOR:
                    path.unlink()
            except OSError:  # somebody else has removed it, or may not
                continue

    def flush(self) -> None:
        """Forget all that is kept of the kernel."""
        for path in self._folder.glob(f"{self._base}.*.nbc"):
            path.unlink(missing_ok=True)

    def _path(self, key: Any) -> Path:
        return self._folder / f"{self._base}.{hashlib.sha256(_name(key).encode()).hexdigest()[:16]}.nbc"


def _note_use(path: Path) -> None:
    """Let a file's time say when it was used last, to a day."""
    try:
        if time.time() - path.stat().st_mtime > DAY:
            os.utime(path)
    except OSError:  # a folder that may only be read
        return


def _split(raw: bytes) -> tuple[bytes, bytes]:
    """Return the digest that a file begins with, and the rest."""
    size = hashlib.sha256().digest_size
    return raw[:size], raw[size:]


def _name(key: Any) -> str:
    """Return a key in words, the same in every process."""
    return f"{numba.__version__} {key!r}"
