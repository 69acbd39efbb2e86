"""Cores that are kept, each in a folder named by its digest: the newest, and those that comparisons use.

The same core, asked for again, finds its machine code there.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import re
import shutil
import tempfile
from pathlib import Path

CORE = "softbody"
KEPT = 8  # cores: two of a comparison, three of a calibration, and some to come back to

_in_use: list[int] = []  # folders, held open: their locks end with this process, however it ends


def digest_of(folder: Path) -> str:
    """Return a hash of all sources in a folder."""
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


def kept(made: Path, store: Path) -> Path:
    """Return the folder of the store for a core that was laid out in `made`; nobody removes it while this process runs.

    It holds `softbody` and nothing else.
    """
    folder = store / digest_of(made / CORE)
    while not _use(folder):
        fresh = Path(tempfile.mkdtemp(dir=store))
        shutil.copytree(made / CORE, fresh / CORE)
        try:
            os.replace(fresh, folder)
        except OSError:  # another comparison was faster
            shutil.rmtree(fresh)
    return folder


def _use(folder: Path) -> bool:
    """Lock a folder against removal, and make it the newest; return whether it is there."""
    try:
        held = os.open(folder, os.O_RDONLY)
    except FileNotFoundError:
        return False
    fcntl.flock(held, fcntl.LOCK_SH)  # waits for one who is removing it
    try:
        is_there = os.path.samestat(os.fstat(held), folder.stat())
    except FileNotFoundError:
        is_there = False
    if not is_there:
        os.close(held)
        return False
    os.utime(folder)
    _in_use.append(held)
    return True


def prune(store: Path) -> int:
    """Remove all cores but the newest KEPT and those in use; return how many are gone."""
    folders = [folder for folder in store.iterdir() if re.fullmatch("[0-9a-f]{16}", folder.name)]
    folders.sort(key=lambda folder: folder.stat().st_mtime, reverse=True)
    return sum(_remove(folder) for folder in folders[KEPT:])


def _remove(folder: Path) -> bool:
    """Remove a core, unless it is in use."""
    held = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        with tempfile.TemporaryDirectory(dir=folder.parent) as gone:
            os.replace(folder, Path(gone) / "core")  # whole or not there
    except BlockingIOError:
        return False
    finally:
        os.close(held)
    return True
