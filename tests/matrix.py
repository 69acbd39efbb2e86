"""Does the core install, run and give the same bits on every Python that is here, and on every Numba it knows?

`make matrix`. Each pair gets an environment of its own, with what `pip install .` brings, and does two things there:
the README's example, and a scene whose bits must be those of all other pairs. This Python, with the newest Numba, does
the scene once more by Numba's public decorator alone.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import click

from softbody.compiler.compile_once import FIRST, LAST
from tests.readme_example import readme_example

ROOT = Path(__file__).parents[1]
OLDEST_PYTHON = 10  # 3.10

# Every kind of body and contact. Nothing in it comes from NumPy's own sines, which differ from version to version.
SCENE = """
import numba, softbody, warnings
warnings.simplefilter("ignore")
world = softbody.World()
world.add_ground(restitution=0.3)
world.add_soft_body(softbody.box((1.0, 0.8, 0.6), 3), 1.0, 150.0, 20.0, (0.0, 0.0, 0.9), (0.5, 0.0, -1.0))
world.add_soft_body(softbody.octahedron(0.4), 0.5, 100.0, 4.0, (0.1, 0.1, 1.8), (0.0, 0.0, -3.0), restitution=0.5)
world.add_box((0.6, 0.5, 0.4), 2.0, (-0.1, 0.2, 2.5), velocity=(0.0, 0.0, -2.0), angular_velocity=(1.0, 2.0, 0.0))
world.add_box((4.0, 4.0, 0.2), None, (0.0, 0.0, 0.2))
world.run(0.5, 2e-3)
print(numba.__version__, type(softbody.stepping.step.run).__name__, world.state_hash())
"""


def pythons() -> Iterator[tuple[int, str]]:
    """Yield (minor version, path) of each Python 3 from OLDEST_PYTHON on that is on the path or kept by pyenv."""
    for minor in range(OLDEST_PYTHON, 30):
        kept = sorted(Path.home().glob(f".pyenv/versions/3.{minor}.*/bin/python3"), reverse=True)
        for candidate in (shutil.which(f"python3.{minor}"), *map(str, kept)):
            if candidate and _version(candidate) == minor:
                yield minor, candidate
                break


def _version(python: str) -> int | None:
    """Return the minor version of a Python 3, or None if it does not start."""
    done = subprocess.run([python, "-c", "import sys; print(sys.version_info[1])"], capture_output=True, text=True)
    return int(done.stdout) if done.returncode == 0 else None


def smoke(uv: str, python: str, numba: str, folder: Path, plainly: bool = False) -> list[str]:
    """Install the core with a Numba, run example and scene; return Numba's version, the kind of kernel and the hash.

    Raises subprocess.CalledProcessError if the two do not go together, or the core does not go with them.
    """
    environment, own = folder / "bin" / "python", {**os.environ, "NUMBA_CACHE_DIR": str(folder / "cache")}
    if plainly:
        own["SOFTBODY_PLAIN_NUMBA"] = "1"
    if not environment.exists():
        _run([uv, "venv", "--quiet", "--python", python, str(folder)], own)
        _run([uv, "pip", "install", "--quiet", "--python", str(environment), str(ROOT), numba], own)
    if not plainly:
        _run([str(environment), "-c", readme_example(ROOT / "README.md")], own, folder)
    return _run([str(environment), "-c", SCENE], own, folder).split()


def _run(command: list[str], environment: dict[str, str], folder: Path | None = None) -> str:
    return subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, check=True).stdout


@click.command()
@click.option("--uv", default="uv", help="The program that makes environments.")
@click.option("-k", "only", default="", metavar="TEXT", help="Only pairs with TEXT in them, such as 3.12 or 0.60.")
def main(uv: str, only: str) -> None:
    """Try every pair: each Python with the newest Numba, and this Python with every Numba that the core knows."""
    uv = str(Path(uv).resolve()) if Path(uv).exists() else uv
    here = dict(pythons())
    own = sys.version_info[1]
    pairs = [(minor, "numba") for minor in here]
    pairs += [(own, f"numba=={FIRST[0]}.{minor}.*") for minor in range(FIRST[1], LAST[1] + 1)]
    pairs = [pair for pair in pairs if only in f"Python 3.{pair[0]} with {pair[1]}"]
    hashes: dict[str, str] = {}
    for number, (minor, numba) in enumerate(pairs):
        name = f"Python 3.{minor} with {numba}"
        click.echo(f"{number + 1} of {len(pairs)}: {name} …", nl=False)
        with tempfile.TemporaryDirectory() as folder:
            try:
                version, kind, hashes[name] = smoke(uv, here[minor], numba, Path(folder))
                click.echo(f" {version}, {kind}, {hashes[name][:16]}")
                if (minor, numba) == (own, "numba"):
                    plain = f"{name}, plainly"
                    version, kind, hashes[plain] = smoke(uv, here[minor], numba, Path(folder), plainly=True)
                    click.echo(f"{plain}: {version}, {kind}, {hashes[plain][:16]}")
            except subprocess.CalledProcessError as error:
                hashes[name] = "failed"
                click.echo(" failed:\n" + re.sub(r"^", "    ", error.stderr.strip()[-2000:], flags=re.MULTILINE))
    agree = len(set(hashes.values())) == 1 and "failed" not in hashes.values()
    click.echo(f"{len(hashes)} runs: " + ("the same bits everywhere" if agree else "NOT the same everywhere"))
    sys.exit(0 if agree else 1)


if __name__ == "__main__":
    main()
