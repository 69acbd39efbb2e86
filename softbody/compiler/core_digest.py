"""What decides the machine code of every kernel: the core's sources and Numba's flags, as one hash."""

from __future__ import annotations

import hashlib
import os
import sys
from pathlib import Path

FLAGS = ("NUMBA_BOUNDSCHECK", "NUMBA_OPT", "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES")


def source_digest(folder: str = ".") -> str:
    """Return the hash of the sources in a folder of the core, in hexadecimal.

    Of a core in an archive, or in a program that was made of it, the whole file counts.
    """
    digest, root = hashlib.sha256(), Path(__file__).parents[1]
    if not root.is_dir():
        archive = next((each for each in root.parents if each.is_file()), Path(sys.executable))
        return hashlib.sha256(archive.read_bytes()).hexdigest()
    files = (root / folder).rglob("*.py")
    # (An editor's lock is a link to nothing, or a hidden file.)
    for path in sorted(each for each in files if each.is_file() and not each.name.startswith(".")):
        digest.update(path.relative_to(root).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


SOURCE_DIGEST = source_digest()


def core_digest() -> str:
    """Return the hash of the sources and of Numba's flags, in hexadecimal."""
    flags = "".join(f"{flag}={os.environ.get(flag)}" for flag in FLAGS)
    return hashlib.sha256(f"{SOURCE_DIGEST}{flags}".encode()).hexdigest()


CORE_DIGEST = core_digest()
