"""Is machine code told from that of other sources, wherever these are?"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import softbody

CORE = Path(softbody.__file__).parent
USE = """
import sys
sys.path.insert(0, sys.argv[1])
import softbody
from softbody.compiler.core_digest import SOURCE_DIGEST
from softbody.linalg.vec import norm
print(softbody.__file__.startswith(sys.argv[1]), norm((3.0, 4.0, 0.0)), SOURCE_DIGEST)
"""


def use(archive: Path, cache: Path) -> list[str]:
    """Return what a program says that imports the core from an archive: whether it did, 5, and the digest."""
    chosen = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    command = [sys.executable, "-P" if sys.version_info >= (3, 11) else "-I", "-c", USE, str(archive)]
    return subprocess.run(command, env=chosen, capture_output=True, text=True, check=True).stdout.split()


def test_a_core_in_an_archive_runs_and_its_edits_count(tmp_path):
    shutil.copytree(CORE, tmp_path / "sources" / "softbody", ignore=shutil.ignore_patterns("__pycache__"))
    archive = Path(shutil.make_archive(str(tmp_path / "core"), "zip", tmp_path / "sources"))
    first, again = use(archive, tmp_path / "cache"), use(archive, tmp_path / "cache")
    assert first == again
    assert first[:2] == ["True", "5.0"]
    vec = tmp_path / "sources" / "softbody" / "linalg" / "vec.py"
    vec.write_text(vec.read_text("utf-8") + "\n# edited\n", encoding="utf-8")
    edited = use(Path(shutil.make_archive(str(tmp_path / "edited"), "zip", tmp_path / "sources")), tmp_path / "cache")
    assert edited[:2] == first[:2]
    assert edited[2] != first[2]
