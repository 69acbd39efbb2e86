"""Is a part of a kernel taken from the disk only while it is what its sources say, and whenever it is?"""

import os
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import numba
import pytest

import softbody
from softbody.compiler.jit import _knows_numba
from softbody.compiler.part_cache import parts_folder
from validation.bench import PARTS

CORE = Path(softbody.__file__).parent

pytestmark = pytest.mark.skipif(
    os.environ.get("NUMBA_DISABLE_JIT") == "1" or not _knows_numba(), reason="Numba alone keeps no parts"
)

# A kernel that calls a part, which calls another; one is pasted into it.
TRIAL = """
from typing import NamedTuple
import numpy as np
from softbody.compiler.jit import jit, jit_inlined, jit_threaded
from numba import prange

WEIGHT = 2.0
WEIGHTS = np.array([1.0, 2.0, 4.0])

class Pair(NamedTuple):
    first: float
    second: float

@jit
def leaf(x, more=1.0):
    return x + more

@jit_inlined
def pasted(x):
    return 3.0 * x

@jit
def middle(x):
    pair = Pair(leaf(x=x), 5.0)
    return WEIGHT * pasted(pair.first) + WEIGHTS[1] * pair.second

@jit_threaded
def shared_out(x):
    total = np.zeros(4)
    for i in prange(4):
        total[i] = middle(x) * i
    return total

@jit
def top(x):
    return middle(x) + shared_out(x).sum()
"""
PROGRAM = """
from softbody import trial
kernels = [trial.leaf, trial.middle, trial.shared_out]
value = trial.top(1.0)
print(value, " ".join(each.py_func.__name__ for each in kernels if any(each.part.stats.cache_misses.values())))
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    where = tmp_path_factory.mktemp("package")
    shutil.copytree(CORE, where / "softbody", ignore=shutil.ignore_patterns("__pycache__", "_machine_code"))
    return where


@pytest.fixture
def run(package, tmp_path):
    """What a trial of some source prints in a fresh process that has the parts of those before."""

    def printed(source=TRIAL, program=PROGRAM, **variables):
        (package / "softbody" / "trial.py").write_text(source)
        environment = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
        environment |= {"PYTHONPATH": str(package), "PYTHONDONTWRITEBYTECODE": "1"}
        environment |= {"NUMBA_CACHE_DIR": str(tmp_path / "kernels"), "SOFTBODY_PARTS_IN": str(tmp_path / "parts")}
        done = subprocess.run(
            [sys.executable, "-W", "error", "-c", program],
            cwd=package,
            env=environment | variables,
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    return printed


def interpreted(source):
    """What the kernel returns as Python."""
    names = {}
    exec(textwrap.dedent(source).replace("@jit_inlined", "").replace("@jit_threaded", "").replace("@jit", ""), names)
    return names["top"](1.0)


# An edit, and what it lets be compiled anew.
EDITS = {
    "a comment": ("def leaf", "# nothing\ndef leaf", ""),
    "the body of what is called": ("x + more", "x - more", "leaf"),
    "a default": ("more=1.0", "more=7.0", "leaf middle"),
    "the order of arguments": ("def leaf(x, more=1.0):", "def leaf(more=5.0, x=1.0):", "leaf middle"),
    "what is called returns another type": ("x + more", "int(x + more)", "leaf middle"),
    "a constant": ("WEIGHT = 2.0", "WEIGHT = -0.0", "middle"),
    "a constant of another type": ("WEIGHT = 2.0", "WEIGHT = 2", "middle"),
    "an array": ("2.0, 4.0", "2.5, 4.0", "middle"),
    "the fields": ("first: float\n    second", "second: float\n    first", "middle"),
    "what is pasted": ("3.0 * x", "x / 3.0", "middle"),
    "whether anything is pasted": ("return x + more", "return pasted(x) + more", "leaf middle"),
    "a loop of threads": ("middle(x) * i", "middle(x) * i * i", "shared_out"),
    "how it is compiled": ("@jit\ndef leaf", "@jit_inlined\ndef leaf", "middle"),
}


@pytest.mark.parametrize("edit", EDITS)
def test_an_edit_lets_be_compiled_what_it_changes_and_no_more(run, edit):
    old, new, compiled = EDITS[edit]
    edited = TRIAL.replace(old, new)
    assert edited != TRIAL
    assert run() == f"{interpreted(TRIAL)} leaf middle shared_out"
    assert run(edited) == f"{interpreted(edited)} {compiled}".strip()
    assert run() == str(interpreted(TRIAL))  # the parts of before are still there, the kernel of before as well


KEPT = """
import hashlib, pathlib, pickle
import llvmlite.binding as llvm
from softbody.compiler.part_cache import parts_folder
for path in sorted(pathlib.Path(parts_folder()).iterdir()):
    _, part = pickle.loads(path.read_bytes()[32:])
    module = llvm.parse_bitcode(part.bitcode)
    names = [(each.linkage.name, each.name) for each in [*module.functions, *module.global_variables]
             if not each.is_declaration and each.linkage.name not in ("internal", "private")]
    assert names == [("linkonce_odr", part.descriptor.mangled_name)], names
    print(part.descriptor.qualname, hashlib.sha256(part.bitcode).hexdigest())
"""


def test_a_part_is_the_same_code_in_every_process_and_shows_nothing_but_itself(run, tmp_path):
    """Numba numbers what it adds as it comes: in two processes the same name may be of two functions."""
    kept = []
    for before in ("", "import numba\nnumba.njit(lambda n: max(n, 2.5) + 1)(3)\n"):
        run(program=before + PROGRAM, PYTHONHASHSEED="0")
        kept.append(run(program=KEPT))
        shutil.rmtree(tmp_path / "parts")
        shutil.rmtree(tmp_path / "kernels")
    assert [line.split()[0] for line in kept[0].splitlines()] == ["leaf", "middle", "shared_out"]
    assert kept[0] == kept[1]


def test_a_part_for_another_processor_or_with_bounds_checks_is_another_part(run, tmp_path):
    first = run()
    assert run(NUMBA_CPU_NAME="x86-64", NUMBA_CPU_FEATURES="") == first
    assert run(NUMBA_BOUNDSCHECK="1") == first
    assert run(NUMBA_BOUNDSCHECK="1", NUMBA_CACHE_DIR=str(tmp_path / "other kernels")) == first.split()[0]


SAME_NAMES = """
from typing import NamedTuple
from softbody.compiler.jit import jit

class There:
    class Pair(NamedTuple):
        first: float
        second: float

class Back:
    class Pair(NamedTuple):
        second: float
        first: float

@jit
def first_of(pair):
    return pair.first

@jit
def both(there, back):
    return first_of(there) + 10.0 * first_of(back)
"""


def test_faults_take_the_parts_of_the_sound_core(monkeypatch):
    monkeypatch.delenv("SOFTBODY_PARTS_IN", raising=False)
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    assert parts_folder.__wrapped__() == str(PARTS)


def test_types_of_one_name_have_parts_of_their_own(run):
    program = "from softbody.trial import *; print(both(There.Pair(1.0, 2.0), Back.Pair(3.0, 4.0)))"
    for _ in range(2):
        assert run(SAME_NAMES, program) == "41.0"


def test_damaged_parts_are_compiled_anew(run, tmp_path):
    first = run()
    shutil.rmtree(tmp_path / "kernels")
    assert run() == first.split()[0]
    for path in (tmp_path / "parts").iterdir():
        path.write_bytes(path.read_bytes()[:-100])
    shutil.rmtree(tmp_path / "kernels")
    assert run() == first


@pytest.mark.parametrize("folder", ["/dev/null", "/proc/nowhere"])
def test_where_no_part_can_be_kept_all_is_compiled(run, folder):
    assert run(SOFTBODY_PARTS_IN=folder) == f"{interpreted(TRIAL)} leaf middle shared_out"


def test_two_kernels_of_one_name_are_two_kernels(run):
    """As where a module is loaded again: what is kept by name would be one of both."""
    again = """
import importlib
from numba.core.caching import NullCache
from softbody import trial
trial.top._cache = NullCache()
first, old = trial.top(1.0), trial.top
path = trial.__file__
text = open(path).read()
open(path, "w").write(text.replace("x + more", "x - more"))
importlib.reload(trial)
trial.top._cache = NullCache()
open(path, "w").write(text)
print(first, trial.top(1.0), old(1.0), old.py_func is trial.top.py_func)
"""
    edited = TRIAL.replace("x + more", "x - more")
    for _ in range(2):
        assert run(program=again) == f"{interpreted(TRIAL)} {interpreted(edited)} {interpreted(TRIAL)} False"
