"""The core as it is installed: machine code that came along, and nowhere to keep more.

The wheels that `tests.platform_wheel` builds are made and used by it, and so is the small one of a claim.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import llvmlite.binding as llvm

import softbody
from softbody.cli.warmup import Kind
from softbody.compiler.shipped_code import FAMILIES, KEEP_IN, folder_name

# A folder that nobody can make, and no other is looked for.
NOWHERE = {"NUMBA_CACHE_DIR": "/proc/nowhere", "NUMBA_CACHE_LOCATOR_CLASSES": "UserProvidedCacheLocator"}
COMPILE = "from softbody.cli.warmup import Kind, run_small_world; run_small_world({kind!r})"
WATCH = """
import runpy, sys, time
began = time.process_time()
from numba.core import event
compiled = []
class Watch(event.Listener):
    def on_start(self, at):
        kernel = at.data.get("dispatcher")
        if type(kernel).__name__ == "_Kernel":  # not a part of one
            compiled.append(f"{kernel.py_func.__module__}.{kernel.py_func.__qualname__}")
    def on_end(self, at):
        pass
event.register("numba:compile", Watch())
try:
    del sys.argv[0]
    runpy.run_path(sys.argv[0], run_name="__main__")
finally:
    print(round(time.process_time() - began, 2), *sorted(set(compiled)), file=sys.stderr)
"""


def family_here() -> str | None:
    """Return a family of processors that this one is of; None if none is known."""
    has = {name for name, is_there in llvm.get_host_cpu_features().items() if is_there}
    return next((family for family, needs in FAMILIES.items() if needs <= has), None)


def install(kinds: tuple[Kind, ...], family: str, folder: Path) -> None:
    """Put a copy of the core that is imported here into a folder, with machine code of kinds of worlds."""
    core = folder / "softbody"
    shutil.copytree(Path(softbody.__file__).parent, core, ignore=shutil.ignore_patterns("__pycache__"))
    for kind in kinds:
        compile_for(family, kind, folder / "code" / folder_name(family), folder)
    shutil.move(folder / "code", core / "_machine_code")


class Use(NamedTuple):
    """What came of a program: what it printed, how long it took, and which kernels were compiled for it."""

    printed: str
    seconds: float  # of the processor
    compiled: tuple[str, ...]


def compile_for(family: str, kind: Kind, code: Path, core: Path, python: str = sys.executable) -> None:
    """Compile a kind of world for a family of processors, and keep its kernels in the folder `code`.

    `core` is where a Python finds the package; parts are shared by all that keep in one folder. Raises
    subprocess.CalledProcessError.
    """
    code.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as cache:
        chosen = {
            "NUMBA_CPU_NAME": family,
            "NUMBA_CPU_FEATURES": "",  # those of the family, and not the host's
            "NUMBA_CACHE_DIR": cache,
            "SOFTBODY_PARTS_IN": str(code.parent / f"parts-{code.name}"),
            "PYTHONHASHSEED": "0",
            KEEP_IN: str(code),
        }
        command = [python, "-W", "ignore", "-c", _damage() + COMPILE.format(kind=kind)]
        subprocess.run(command, env=_clean() | chosen, cwd=core, check=True, capture_output=True, text=True)


def use(program: str, core: Path, arguments: tuple[str, ...] = (), python: str = sys.executable) -> Use:
    """Run a program in the folder `core`, whose package it imports unless `python` has one; nothing can be kept.

    Raises subprocess.CalledProcessError.
    """
    own = _clean() | NOWHERE | {"PYTHONDONTWRITEBYTECODE": "1"}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "program.py"
        file.write_text(_damage() + program, encoding="utf-8")
        command = [python, "-W", "ignore", "-c", WATCH, str(file), *arguments]
        done = subprocess.run(command, env=own, cwd=core, capture_output=True, text=True, check=True)
    seconds, *compiled = done.stderr.strip().splitlines()[-1].split()
    return Use(done.stdout, float(seconds), tuple(compiled))


def _clean() -> dict[str, str]:
    """Return the environment without what is chosen for Python, Numba or the core."""
    return {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "NUMBA_", "SOFTBODY_"))}


def _damage() -> str:
    """Return a line of Python that wakes, in another process, the damage that is awake in this one."""
    switch = sys.modules.get("softbody.switch")
    return f"from softbody import switch; switch.AWAKE.value = {switch.AWAKE.value}\n" if switch else ""
