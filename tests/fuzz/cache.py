"""Whatever has become of kept machine code, a new process gives the right answer, with a warning at most."""

from __future__ import annotations

import ctypes
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

Rng = np.random.Generator

ROOT = Path(__file__).parents[2]
SECONDS = 100.0  # that a process may take, compiling included

KERNELS = """
import softbody
from softbody.geometry import surface_area
mesh = softbody.octahedron(0.3)
print(mesh.volume.hex(), surface_area(mesh.vertices, mesh.triangles).hex())
"""
BALL = """
import softbody
world = softbody.World()
world.add_ground()
world.add_soft_body(softbody.icosphere(0, 0.5), 1.0, 200.0, 30.0, (0.0, 0.0, 0.52))
world.step(1e-3, 50)
print(world.state_hash())
"""


class Place:
    """A copy of a cache that was filled once, and a core, both to be damaged."""

    def __init__(self, folder: Path, program: str) -> None:
        self.core, filled, self.answer = _filled(program)
        self.folder, self.program = folder, program
        self.cache, home = folder / "cache", folder / "home"
        self.environment = {"NUMBA_CACHE_DIR": str(self.cache), "HOME": str(home), "XDG_CACHE_HOME": str(home)}
        shutil.copytree(filled, self.cache)

    @property
    def files(self) -> list[Path]:
        """Return the files of machine code, in order."""
        return sorted(self.cache.rglob("*.nbc"))

    def start(self, before: Callable[[], None] | None = None) -> subprocess.Popen[str]:
        """Start the program; `before` it begins, do something in its process."""
        return subprocess.Popen(
            [sys.executable, "-c", self.program],
            cwd=self.folder,
            env=os.environ | {"PYTHONPATH": str(self.core), "PYTHONDONTWRITEBYTECODE": "1"} | self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=before,
        )

    def wrong(self, process: subprocess.Popen[str]) -> str | None:
        """Return what is wrong with how a process ended, and what it said."""
        try:
            said, complained = process.communicate(timeout=SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return f"no end after {SECONDS} s"
        if process.returncode or said != self.answer:
            return f"ended with {process.returncode} and {said!r}, not {self.answer!r}: {complained[-500:]}"
        if complained and "Warning" not in complained:
            return f"complains: {complained[-500:]}"
        return None


@cache
def _filled(program: str) -> tuple[Path, Path, str]:
    """Return a core that cannot be written to, a cache that a program has filled, and what it says.

    The folders are removed with the process.
    """
    holder = tempfile.TemporaryDirectory()
    _kept.append(holder)
    core, filled = Path(holder.name) / "core", Path(holder.name) / "cache"
    shutil.copytree(ROOT / "softbody", core / "softbody", ignore=shutil.ignore_patterns("__pycache__"))
    for path in (*core.rglob("*"), core):
        path.chmod(0o555 if path.is_dir() else 0o444)
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=holder.name,
        env=os.environ | {"PYTHONPATH": str(core), "NUMBA_CACHE_DIR": str(filled)},
        capture_output=True,
        text=True,
        check=True,
    )
    if not list(filled.rglob("*.nbc")):
        raise RuntimeError("nothing was kept: nothing can be damaged")
    return core, filled, done.stdout


_kept: list[tempfile.TemporaryDirectory[str]] = []


def _drop_rights() -> None:
    """Let permissions count for root, too."""
    capabilities = 1, 2  # to write, and to read, whatever the permissions
    for each in capabilities:
        ctypes.CDLL(None).prctl(24, each, 0, 0, 0)  # out of the bounding set; refused to those who have none


def bytes_changed(place: Place, rng: Rng) -> None:
    """Some files are cut, emptied, flipped in bits, overwritten, made longer, or another one's."""
    for path in rng.permutation(np.array(place.files, object))[: int(rng.integers(1, 4))]:
        raw = bytearray(path.read_bytes())
        way = int(rng.integers(6))
        if way == 0:
            del raw[int(rng.integers(len(raw))) :]
        elif way == 1:
            raw.clear()
        elif way == 2:
            for _ in range(int(rng.integers(1, 9))):
                raw[int(rng.integers(len(raw)))] ^= 1 << int(rng.integers(8))
        elif way == 3:
            first = int(rng.integers(len(raw)))
            raw[first : first + 64] = rng.bytes(64)
        elif way == 4:
            raw += rng.bytes(int(rng.integers(1, 100)))
        else:
            raw = bytearray(place.files[int(rng.integers(len(place.files)))].read_bytes())
        path.write_bytes(raw)


def something_in_the_way(place: Place, rng: Rng) -> None:
    """In place of files there are folders, pipes, links to nothing, to themselves or to devices."""
    for path in place.files:
        way = int(rng.integers(6))
        path.unlink()
        if way == 0:
            (path / "full").mkdir(parents=True)
        elif way == 1:
            os.mkfifo(path)
        elif way == 2:
            path.symlink_to("nowhere")
        elif way == 3:
            path.symlink_to(path.name)
        elif way == 4:
            path.symlink_to("/dev/null" if rng.integers(2) else "/dev/zero")


def foreign_files(place: Place, rng: Rng) -> None:
    """There are locks of editors, rubbish of old times, and names that are no text."""
    for path in place.files:
        base = path.name.split(".py")[0]
        for name in (f".#{path.name}", f"{base}.lock", f"{path.name}.tmp", f"{path.name[:-20]}.nbi", f"{path.name}~"):
            other = path.with_name(name)
            way = int(rng.integers(4))
            if way == 0:
                other.symlink_to("somebody@somewhere.1234")
            elif way == 1:
                other.write_bytes(rng.bytes(50))
                os.utime(other, (0.0, 0.0))
            elif way == 2:
                other.mkdir()
                os.utime(other, (0.0, 0.0))
        with open(os.fsencode(path.parent) + b"/" + os.fsencode(base) + b"\xff\xfe.nbc", "wb"):
            pass
        if rng.integers(2):
            path.unlink()


def permissions(place: Place, rng: Rng) -> None:
    """Files, and folders, may not be read, or not be written."""
    for path in (*place.files, *(each for each in place.cache.iterdir()), place.cache):
        if rng.integers(2):
            path.chmod(int(rng.choice([0o000, 0o444, 0o555, 0o222, 0o111])))


def the_folder(place: Place, rng: Rng) -> None:
    """The cache's folder, or one in it, is gone, a file, a link to nothing, a device, or has a name that is none."""
    folders = [place.cache, *(each for each in place.cache.iterdir())]
    folder = folders[0] if rng.integers(2) else folders[int(rng.integers(1, len(folders)))]
    way = int(rng.integers(5))
    if way < 4:
        shutil.rmtree(folder)
    if way == 1:
        folder.write_text("a file")
    elif way == 2:
        folder.symlink_to("nowhere")
    elif way == 3:
        folder.symlink_to("/dev/null")
    elif way == 4:
        place.environment["NUMBA_CACHE_DIR"] = str(rng.choice(["/dev/null", "/proc/self/fd", "x" * 300, "/proc/x"]))


def read_only_installation(place: Place, rng: Rng) -> None:
    """Nothing can be written: neither beside the core, nor in a home, nor where the user wants it."""
    home = place.folder / "home"
    if rng.integers(2):
        home.mkdir(mode=0o555)
    if rng.integers(2):
        place.environment["NUMBA_CACHE_DIR"] = ""  # none is named
    else:
        for path in (*place.cache.rglob("*"), place.cache):
            path.chmod(0o555 if path.is_dir() else 0o444)
    if rng.integers(2):
        place.files[0].unlink()
    place.folder.chmod(0o555)


DAMAGES: tuple[Callable[[Place, Rng], None], ...] = (
    bytes_changed,
    something_in_the_way,
    foreign_files,
    permissions,
    the_folder,
    read_only_installation,
)


def damaged(place: Place, rng: Rng, which: int) -> str | None:
    """Damage the cache; a process, and one after it, must not mind."""
    DAMAGES[which](place, rng)
    for _ in range(1 + int(rng.integers(2))):
        wrong = place.wrong(place.start(_drop_rights))
        if wrong:
            return wrong
    return None


def a_full_disk(place: Place, rng: Rng) -> str | None:
    """Machine code is kept where there is room for so many bytes of a file."""
    room = int(rng.choice([0, 1, 100, 10_000]))
    for path in place.files:
        path.unlink()
    full = place.start(lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (room, room)))
    return place.wrong(full) or place.wrong(place.start(_drop_rights))


def several_at_once(place: Place, rng: Rng) -> str | None:
    """Processes fill the same cache, of which some files are missing, at the same time; perhaps one is killed."""
    for path in place.files:
        if rng.integers(4):
            path.unlink()
    processes = [place.start(_drop_rights) for _ in range(3)]
    if rng.integers(2):
        time.sleep(float(rng.uniform(0.5, 4.0)))
        processes[0].send_signal(signal.SIGKILL)
        processes.pop(0).communicate()
    for process in processes:
        wrong = place.wrong(process)
        if wrong:
            for other in processes:
                other.kill()
            return wrong
    return place.wrong(place.start(_drop_rights))


WAYS = (*DAMAGES, a_full_disk, several_at_once)


def attempt(seed: int) -> str | None:
    """Damage a cache in the way whose turn it is, of two kernels, or, now and then, of a small world."""
    rng, way = np.random.default_rng(seed), seed % len(WAYS)
    with tempfile.TemporaryDirectory() as folder:
        place = Place(Path(folder) / "place", BALL if seed // len(WAYS) % 8 == 7 else KERNELS)
        try:
            wrong = damaged(place, rng, way) if way < len(DAMAGES) else WAYS[way](place, rng)
        finally:
            for path in (place.folder, *place.folder.rglob("*")):
                if not path.is_symlink():
                    path.chmod(0o755)
    return f"{WAYS[way].__name__}: {wrong}" if wrong else None
