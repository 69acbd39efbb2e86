"""Is the package what it says: small, self-contained, and public by name?"""

import subprocess
import sys
from pathlib import Path

import softbody

# Numba itself imports SciPy where it is installed: what it and NumPy bring does not count.
LOADED = """
import sys, numba, numpy
before = set(sys.modules)
import softbody
print(*{name.partition(".")[0] for name in set(sys.modules) - before})
"""


def test_importing_the_core_brings_numpy_numba_and_the_standard_library_only():
    root = Path(softbody.__file__).parents[1]
    done = subprocess.run([sys.executable, "-c", LOADED], cwd=root, capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert "softbody" in loaded
    assert loaded <= set(sys.stdlib_module_names) | {"softbody", "numpy", "numba", "llvmlite"}


def test_scenes_are_there_without_being_imported_by_name():
    root = Path(softbody.__file__).parents[1]
    code = "import softbody; print(softbody.scenes.tray.build(1).model.soft_count)"
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True)
    assert done.stdout == "1\n"


def test_every_public_name_is_there():
    assert len(set(softbody.__all__)) == len(softbody.__all__)
    for name in softbody.__all__:
        assert getattr(softbody, name).__doc__


def test_pictures_are_imported_when_they_are_asked_for_and_not_before():
    root = Path(softbody.__file__).parents[1]
    code = "import sys, softbody; print('softbody.render' in sys.modules, softbody.Recorder.__module__)"
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True)
    assert done.stdout == "False softbody.render.recorder\n"
