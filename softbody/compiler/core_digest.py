"""What decides the machine code of every kernel: the core's sources and Numba's flags, as one hash."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

FLAGS = ("NUMBA_BOUNDSCHECK", "NUMBA_OPT", "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES")


def source_digest() -> str:
    """Return the hash of the sources, in hexadecimal."""
    digest = hashlib.sha256()
    root = Path(__file__).parents[1]
    # (An editor's lock is a link to nothing, or a hidden file.)
    for path in sorted(each for each in root.rglob("*.py") if each.is_file() and not each.name.startswith(".")):
        digest.update(path.relative_to(root).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


SOURCE_DIGEST = source_digest()


def core_digest() -> str:
    """Return the hash of the sources and of Numba's flags, in hexadecimal."""
    flags = "".join(f"{flag}={os.environ.get(flag)}" for flag in FLAGS)
    return hashlib.sha256(f"{SOURCE_DIGEST}{flags}".encode()).hexdigest()


CORE_DIGEST = core_digest()
