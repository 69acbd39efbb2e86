"""Is machine code found wherever it can be read, and is what came with the package taken only where it fits?"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import llvmlite.binding as llvm
import pytest

pytest.importorskip(
    "softbody.compiler.compile_once", reason="Numba's internals are not as expected", exc_type=ImportError
)

import softbody
from softbody.compiler.shipped_code import FAMILIES, KEEP_IN, folder_name

CORE = Path(softbody.__file__).parent
NOWHERE = "/proc/nowhere" if os.path.isdir("/proc") else "/dev/null/nowhere"  # no folder can be made there
FAMILY = next(iter(FAMILIES))

AREA = """
import warnings
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    from softbody.geometry.triangle import triangle_area as f
    area = f((0.0, 0.0, 0.0), (3.0, 0.0, 0.0), (0.0, 4.0, 0.0))
print(area, "read" if sum(f.stats.cache_hits.values()) else "compiled", *(str(each.message)[:27] for each in said))
"""
TAKEN, NOT_KEPT = "6.0 read", "6.0 compiled machine code cannot be kept"

pytestmark = [
    pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="nothing is compiled"),
    pytest.mark.skipif(os.name != "posix", reason="folders that cannot be written are those of POSIX"),
]


# Numba names both its loop and its sum by where they were in memory.
SHARED_OUT = """
import numpy as np
from numba import prange
from softbody.compiler.jit import jit_threaded

@jit_threaded
def shared_out(a, b):
    for i in prange(a.shape[0]):
        a[i] = 2.0 * b[i]
    return (a + b * b).sum()
"""


def output(where, program=AREA, **variables):
    """What a program prints in a fresh process that imports softbody from `where`."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA_")}
    environment |= {
        "PYTHONPATH": str(where),
        "PYTHONDONTWRITEBYTECODE": "1",
        "HOME": NOWHERE,
        "XDG_CACHE_HOME": NOWHERE,
    }
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=where, env=environment | variables, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def copy_of_core(where):
    shutil.copytree(CORE, where / "softbody", ignore=shutil.ignore_patterns("__pycache__", "_machine_code"))
    return where


def locked(where):
    """Put a file where each folder of caches would be: as the root of a container, one can write anywhere."""
    for folder in [where / "softbody", *(each for each in (where / "softbody").rglob("*") if each.is_dir())]:
        if folder.name not in ("_machine_code", "__pycache__") and folder.parent.name != "_machine_code":
            (folder / "__pycache__").touch()
    return where


@pytest.fixture(scope="module")
def shipped(tmp_path_factory):
    """A package that brings the machine code of one kernel, and cannot keep any."""
    where = copy_of_core(tmp_path_factory.mktemp("shipped"))
    code = where / "softbody" / "_machine_code" / folder_name(FAMILY)
    code.mkdir(parents=True)
    chosen = {"NUMBA_CPU_NAME": FAMILY, "NUMBA_CPU_FEATURES": "", KEEP_IN: str(code)}
    assert output(where, NUMBA_CACHE_DIR=str(where / "cache"), **chosen).startswith("6.0 compiled")
    assert len(list(code.iterdir())) == 1
    return locked(where)


def test_what_is_shipped_is_the_same_whenever_it_is_compiled(tmp_path):
    where, kept = copy_of_core(tmp_path / "package"), []
    (where / "softbody" / "shared_out.py").write_text(SHARED_OUT)
    program = "from softbody.shared_out import *; shared_out(np.ones(9), np.ones(9))"
    for number in "12":
        (tmp_path / number / "code").mkdir(parents=True)
        chosen = {KEEP_IN: str(tmp_path / number / "code"), "NUMBA_CACHE_DIR": str(tmp_path / number / "cache")}
        output(where, program, PYTHONHASHSEED="0", SET_APART="x" * int(number) * 999, **chosen)
        kept.append([path.read_bytes() for path in (tmp_path / number / "code").iterdir()])
    assert len(kept[0]) == 1
    assert kept[0] == kept[1]


def host_features():
    return {name for name, has in llvm.get_host_cpu_features().items() if has}


has_family = pytest.mark.skipif(
    not FAMILIES[FAMILY] <= host_features(), reason="this processor is of no family that code is shipped for"
)


@has_family
def test_what_came_along_is_taken_where_no_folder_can_be_written(shipped):
    assert output(shipped) == TAKEN
    assert output(shipped, NUMBA_CACHE_DIR=NOWHERE) == TAKEN


@has_family
@pytest.mark.parametrize(
    "asked", [{"NUMBA_BOUNDSCHECK": "1"}, {"NUMBA_OPT": "1"}, {"NUMBA_CPU_NAME": "generic"}, {"NUMBA_ENABLE_AVX": "0"}]
)
def test_other_code_than_what_came_along_is_compiled(shipped, asked):
    assert output(shipped, **asked) == NOT_KEPT


@has_family
def test_what_came_along_damaged_or_for_other_sources_is_compiled(shipped, tmp_path):
    shutil.copytree(shipped, tmp_path / "edited")
    with (tmp_path / "edited" / "softbody" / "version.py").open("a") as file:
        file.write("# edited\n")
    assert output(tmp_path / "edited") == NOT_KEPT
    shutil.copytree(shipped, tmp_path / "damaged")
    for path in (tmp_path / "damaged" / "softbody" / "_machine_code").rglob("*.nbc"):
        path.write_bytes(path.read_bytes()[:-3])
    said = output(tmp_path / "damaged")
    assert said.startswith("6.0 compiled machine code in ")
    assert said.endswith("machine code cannot be kept")


def test_what_somebody_else_has_kept_is_read_where_it_cannot_be_written(tmp_path):
    where = copy_of_core(tmp_path)
    assert output(where) == "6.0 compiled"  # kept beside the sources
    kept = list(where.rglob("*.nbc"))
    assert all(path.stat().st_mode & 0o044 == path.parent.stat().st_mode & 0o044 for path in kept)
    assert output(where, NUMBA_CACHE_DIR=NOWHERE) == TAKEN
    assert output(where, NUMBA_CACHE_DIR=str(tmp_path / "another")) == TAKEN
