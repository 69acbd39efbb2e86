"""Is machine code on disk used only while it is what the sources say, and is it what they say at all?"""

import os
import pickle
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pytest
from numba import prange
from numba.core.codegen import JITCPUCodegen
from numba.core.errors import NumbaError

import softbody
from softbody.compiler.jit import _knows_numba, jit, jit_lean, jit_threaded
from softbody.linalg.vec import norm

CORE = Path(softbody.__file__).parent

compiled = pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="nothing is compiled")


def output(code, where, **variables):
    """What `code` prints in a fresh process that imports softbody from `where`."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA_")}
    environment |= {"PYTHONPATH": str(where), "PYTHONDONTWRITEBYTECODE": "1", **variables}
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=where, env=environment, capture_output=True, text=True, timeout=900
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.fixture
def copy(tmp_path):
    """A copy of the core's sources, without its caches."""
    shutil.copytree(CORE, tmp_path / "softbody", ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


AREA = """
from softbody.geometry.triangle import triangle_area as f
print(f((0.0, 0.0, 0.0), (3.0, 0.0, 0.0), (0.0, 4.0, 0.0)), sum(f.stats.cache_hits.values()))
"""


def test_an_edit_in_another_file_of_the_core_is_not_hidden_by_the_cache(copy):
    """triangle_area calls norm, which calls dot in linalg/vec.py: three times the dot product is √3 times the area."""
    assert output(AREA, copy) == "6.0 0"
    assert output(AREA, copy) == "6.0 1"
    vec = copy / "softbody" / "linalg" / "vec.py"
    vec.write_text(vec.read_text().replace("return a[0] * b[0] + a[1]", "return 9 * a[0] * b[0] + 9 * a[1]"))
    vec.write_text(vec.read_text().replace("* b[1] + a[2] * b[2]", "* b[1] + 9 * a[2] * b[2]"))
    assert output(AREA, copy) == "18.0 0"


BEYOND = """
import numpy as np
from softbody.linalg.vec import load
try:
    load(np.zeros((2, 3)), 2)
    print("unchecked", sum(load.stats.cache_hits.values()))
except IndexError:
    print("checked", sum(load.stats.cache_hits.values()))
"""


def test_code_without_bounds_checks_is_not_used_where_they_are_asked_for(copy):
    assert output(BEYOND, copy) == "unchecked 0"
    assert output(BEYOND, copy, NUMBA_BOUNDSCHECK="1") == "checked 0"
    assert output(BEYOND, copy, NUMBA_BOUNDSCHECK="1") == "checked 1"
    assert output(BEYOND, copy) == "unchecked 1"


NESTED = """
import numba, numpy as np
from softbody.linalg.vec import load, norm, sub

@numba.njit
def distance(rows, i, j):
    return norm(sub(load(rows, i), load(rows, j)))

rows = np.array([[3.0, 0.0, 0.0], [0.0, 4.0, 0.0]])
try:
    print(distance(rows, 0, 1), distance(rows, 0, 2))
except IndexError as error:
    print(distance(rows, 0, 1), error)
"""


def test_other_numba_code_calls_kernels_and_sees_their_errors(copy):
    assert output(NESTED, copy, NUMBA_BOUNDSCHECK="1").startswith("5.0 index")


def test_a_kernel_is_pickled_for_another_process(copy):
    there = f"import pickle; print(pickle.loads({pickle.dumps(norm)!r})((0.0, 3.0, 4.0)))"
    assert output(there, copy) == "5.0"


STEP = """
import hashlib, warnings
import softbody
warnings.simplefilter("ignore")
for integrator in ("rk4_velocity", "rk4", "symplectic_euler"):
    world = softbody.World(integrator=integrator)
    world.add_ground(restitution=0.3)
    world.add_soft_body(softbody.octahedron(), 1.0, 50.0, 5.0, (5.0, 0.0, 1.0), (0.5, 0.0, -1.0))
    world.add_box((1.0, 1.0, 1.0), 2.0, (0.0, 0.0, 0.6), (0.8, 0.6, 0.0, 0.0), (1.0, 0.1, 0.0), (0.1, 0.2, 0.3))
    world.add_box((1.0, 2.0, 1.0), 3.0, (1.1, 0.2, 0.7), velocity=(-1.0, 0.0, 0.0), restitution=0.5)
    world.step(1e-2, 12)
    print(hashlib.sha256(b"".join(array.tobytes() for array in world.state)).hexdigest(), world.energy())
"""


def test_kernels_run_without_the_compiler_to_the_same_bits():
    root = CORE.parent
    interpreted = output(STEP, root, NUMBA_DISABLE_JIT="1")
    assert interpreted.count("\n") == 2
    assert interpreted == output(STEP, root)


PLAIN = """
import numpy as np, softbody
from softbody.geometry import MeshQuery
print(softbody.compiler.jit._knows_numba())
world = softbody.World()
ball = world.add_soft_body(softbody.icosphere(2, 0.5), 1.0, 50.0, 5.0, (0.1, 0.2, 0.3), (0.5, 0.0, -1.0), drag=0.1)
query, points = MeshQuery(ball.positions, ball.triangles), np.random.default_rng(1).uniform(-1.0, 1.0, (2_000, 3))
for numbers in (query.contains(points), query.closest(points).distance, world.angular_momentum()):
    print(hash(numbers.tobytes()))
print(world.energy(), ball.pressure, world.stable_time_step())
"""


@compiled
def test_numbas_public_decorator_alone_gives_the_same_bits(tmp_path):
    """Kernels that compile in reasonable time; `make matrix` does it with a whole scene."""
    known = output(PLAIN, CORE.parent, SOFTBODY_PLAIN_NUMBA="0", PYTHONHASHSEED="0").split()
    ways = {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONHASHSEED": "0"}
    plain = output(PLAIN, CORE.parent, SOFTBODY_PLAIN_NUMBA="1", **ways).split()
    assert (known[0], plain[0]) == ("True", "False")
    assert len(known) == 7
    assert known[1:] == plain[1:]


@pytest.mark.parametrize(
    ("version", "known"), [("0.59.1", False), ("0.60.0", True), ("0.68.0rc1", True), ("0.99.0", False), ("1.0", False)]
)
def test_only_a_numba_that_was_tried_is_taken_for_known(monkeypatch, version, known):
    monkeypatch.delenv("SOFTBODY_PLAIN_NUMBA", raising=False)
    monkeypatch.setattr(numba, "__version__", version)
    assert _knows_numba() == known


class Rows(NamedTuple):
    count: int
    rows: np.ndarray


@jit_lean
def lean_same(rows):
    return rows


@jit_lean
def lean_tuple(rows):
    return 1.0, (2, rows[1:])


@jit_lean
def lean_named(rows):
    return Rows(1, rows)


@jit
def squares(rows):
    return rows * rows


@jit
def sum_of_squares(rows):
    return squares(rows).sum()


@jit_lean
def lean_maybe(rows):
    return rows if rows[0] > 0.0 else None


@jit_lean
def lean_of_array(rows):
    return squares(rows)[0]


@jit_lean
def lean_of_number(rows):
    return sum_of_squares(rows) + 1.0


@jit_lean
def lean_view(rows):
    rows[1:][0] = 7.0


guarded = pytest.mark.skipif(
    bool(numba.config.DISABLE_JIT) or not _knows_numba(), reason="the public decorator counts all references"
)


@guarded
@pytest.mark.parametrize("kernel", [lean_same, lean_tuple, lean_named, lean_maybe], ids=lambda k: k.__name__)
def test_a_lean_kernel_that_returns_an_array_is_refused_by_name(kernel):
    for _ in range(2):  # nothing is kept of it
        with pytest.raises(NumbaError, match=rf"{kernel.__name__} is lean and returns an array"):
            kernel(np.ones(3))


@guarded
def test_a_lean_kernel_that_calls_one_that_returns_an_array_is_refused_by_name():
    with pytest.raises(NumbaError, match="squares returns an array, and a lean kernel calls it"):
        lean_of_array(np.ones(3))


def test_a_lean_kernel_may_call_one_that_makes_an_array_for_itself_and_write_to_a_view():
    rows = np.ones(3)
    assert lean_of_number(rows) == 4.0
    lean_view(rows)
    assert rows.tolist() == [1.0, 7.0, 1.0]


@jit_threaded
def threaded_sums(rows, threads):
    sums = np.zeros(threads)
    for share in prange(threads):
        sums[share] = sum_of_squares(rows[share::threads])
    return sums


@guarded
def test_machine_code_is_made_once_of_a_kernel_and_all_that_it_calls_on_threads_too(monkeypatch):
    """What threads run would else be optimised before it is known who calls it: in more time, to less speed."""
    made, add = [], JITCPUCodegen._add_module
    monkeypatch.setattr(JITCPUCodegen, "_add_module", lambda self, module: made.append(module) or add(self, module))
    assert threaded_sums(np.arange(5.0), 2).tolist() == [20.0, 10.0]
    assert len(made) == 1
    # Others' kernels are made as ever, and may call what was part of ours.
    assert numba.njit(lambda rows: np.zeros(2).sum() + sum_of_squares(rows))(np.arange(5.0)) == 30.0
    assert len(made) > 1


def test_dividing_by_zero_gives_infinity_as_in_numpy():
    from softbody.dynamics.pressure import gas_pressure

    if os.environ.get("NUMBA_DISABLE_JIT") == "1":
        pytest.skip("plain Python floats raise instead")
    assert gas_pressure(1.0, 0.0) == float("inf")
