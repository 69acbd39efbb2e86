"""Could this be released? Builds wheel and sdist, and is their first user on every Python that is here.

`make release-check`. In a clean environment of each Python, pip installs the pure wheel; then the README's example runs
from another folder. How long that takes stands in a table, beside the GOALS; a slow machine is no failure. Then the
wheel that brings machine code is built with each Python, and used in its place: nothing may compile.
"""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path
from statistics import median

import click

import softbody
from tests.matrix import pythons
from tests.platform_wheel import BUILDS, build_platform_wheel, folder_of, show_first_uses
from tests.readme_example import readme_example

ROOT = Path(__file__).parents[1]
DIST = ROOT / "build" / "dist"
MINORS = (10, 11, 12, 13)  # those that the classifiers name
BRINGS = {"softbody", "numpy", "numba", "llvmlite"}
GOALS = {"install": 15.0, "import": 0.4, "first step": 0.5}  # [s]
TRIES = 5  # of what is timed in a process of its own; the median counts

# What is timed by the processor's clock, as all is: what else the machine does, and the network, are not in it.
IMPORT = "import time; began = time.process_time(); import {}; print(time.process_time() - began)"
FIRST_STEP = """
import softbody, time
began = time.process_time()
world = softbody.World()
world.add_ground()
world.add_soft_body(softbody.icosphere(3, radius=0.5), mass=1.0, stiffness=200.0, gas=30.0, position=(0.0, 0.0, 1.0))
world.step(1e-3)
print(time.process_time() - began)
"""


def build(uv: str) -> list[Path]:
    """Build the sdist, and from it the wheel; return both."""
    for old in DIST.glob("softbody-*"):
        old.unlink()
    _run([uv, "build", "--quiet", "--out-dir", str(DIST), str(ROOT)])
    return sorted(DIST.glob("softbody-*"))


def findings(built: list[Path]) -> list[str]:
    """Return what is wrong with what was built, before anybody has installed it."""
    found = []
    twine = subprocess.run(
        [sys.executable, "-m", "twine", "--no-color", "check", "--strict", *map(str, built)],
        capture_output=True,
        text=True,
    )
    if twine.returncode:
        found.append(twine.stdout + twine.stderr)
    if not all(softbody.__version__ in path.name for path in built) or len(built) != 2:
        found.append(f"wheel and sdist of {softbody.__version__} were to be built, and {built} are there")
    if f"\nversion: {softbody.__version__}\n" not in (ROOT / "CITATION.cff").read_text(encoding="utf-8"):
        found.append(f"CITATION.cff does not name version {softbody.__version__}")
    return found + [f"not in the sdist: {name}" for name in sorted(_missing(built[-1]))]


def _missing(sdist: Path) -> set[str]:
    """Return the files of the repository that an sdist does not hold: it is to test itself."""
    with tarfile.open(sdist) as archive:
        has = {name.partition("/")[2] for name in archive.getnames()}
    files = _run(["git", "-C", str(ROOT), "ls-files"]).splitlines()
    return {name for name in files if not name.startswith(".ci/")} - has


def first_use(python: str, wheel: Path, folder: Path) -> dict[str, float]:
    """Install a wheel and use it as a newcomer does; return the seconds that each thing took.

    Raises subprocess.CalledProcessError for what fails, and ValueError for packages that nobody asked for.
    """
    _run([python, "-m", "venv", str(folder)])
    new = str(folder / ("Scripts" if os.name == "nt" else "bin") / "python")
    own = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "NUMBA_"))}
    own["NUMBA_CACHE_DIR"] = str(folder / "cache")
    before, began = _packages(new, own), _processor_time()
    _run([new, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", str(wheel)], own, folder)
    took = {"install": _processor_time() - began}
    brought = _packages(new, own) - before
    if brought != BRINGS:
        raise ValueError(f"pip brought {sorted(brought)}, and not {sorted(BRINGS)}")
    began = _processor_time()
    _run([new, "-c", readme_example(ROOT / "README.md")], own, folder)
    took["example, cold"] = _processor_time() - began
    for name, program in {
        "import": IMPORT.format("softbody"),
        "numba alone": IMPORT.format("numba"),
        "first step": FIRST_STEP,
    }.items():
        took[name] = median(float(_run([new, "-c", program], own, folder)) for _ in range(TRIES))
    return took


def _processor_time() -> float:
    """Return the time [s] that the processor has given to commands which have ended."""
    times = os.times()
    return times.children_user + times.children_system


def _packages(python: str, environment: dict[str, str]) -> set[str]:
    listed = _run([python, "-m", "pip", "list", "--disable-pip-version-check", "--format=json"], environment)
    return {each["name"] for each in json.loads(listed)}


def _run(command: list[str], environment: dict[str, str] | None = None, folder: Path | None = None) -> str:
    return subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, check=True).stdout


@click.command()
@click.option("--uv", default="uv", help="The program that builds wheel and sdist.")
@click.option("-k", "only", default="", metavar="TEXT", help="Only Pythons with TEXT in them, such as 3.12.")
@click.option("--pure", is_flag=True, help="Without machine code, which takes minutes to compile for each Python.")
def main(uv: str, only: str, pure: bool) -> None:
    """Build wheel and sdist, check them, and be their first user on each Python; exit with 1 for what fails."""
    uv = str(Path(uv).resolve()) if Path(uv).exists() else uv
    here, failed = dict(pythons()), False
    try:
        built = build(uv)
        for path in built:
            click.echo(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1e6:.2f} MB")
        for finding in findings(built):
            click.echo(finding)
            failed = True
    except subprocess.CalledProcessError as error:
        sys.exit(f"it cannot be built:\n{error.stderr}")
    wheel = next(path for path in built if path.suffix == ".whl")
    columns = ("install", "import", "numba alone", "first step", "example, cold")
    click.echo(f"{'':12}" + "".join(f"{name:>16}" for name in columns))
    for minor in (each for each in MINORS if only in f"3.{each}"):
        row = f"Python 3.{minor:<5}"
        if minor not in here:
            click.echo(f"{row}not run: no interpreter")
            continue
        brings_code = (platform.system(), platform.machine()) in BUILDS and not pure
        with folder_of(minor) if brings_code else tempfile.TemporaryDirectory() as made:
            folder = Path(made)
            try:
                took = first_use(here[minor], wheel, folder)
                click.echo(row + "".join(f"{_seconds(name, took[name]):>16}" for name in columns))
                if brings_code:
                    new = str(folder / "bin" / "python")
                    brings, said = build_platform_wheel(uv, new)
                    click.echo(said)
                    failed |= not show_first_uses(new, brings, folder)
            except (subprocess.CalledProcessError, ValueError) as error:
                click.echo(f"{row}failed: {error}\n{getattr(error, 'stderr', '')}")
                failed = True
    goals = ", ".join(f"{name} ≤ {seconds:g} s" for name, seconds in GOALS.items())
    click.echo(f"Goals: {goals}; ! is over it. All by the processor's clock; import and first step are warm.")
    sys.exit(1 if failed else 0)


def _seconds(name: str, took: float) -> str:
    return f"{took:.2f} s" + (" !" if took > GOALS.get(name, took) else "")


if __name__ == "__main__":
    main()
