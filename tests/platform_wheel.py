"""Builds wheels that bring the machine code of every kernel, for a Python and this kind of processor.

`make wheel`. Every kind of world is compiled in a process of its own, one after the other: that takes as long as
`python -m softbody warmup` does on one core. Then the wheel is used as by a newcomer who can keep nothing.
"""

from __future__ import annotations

import hashlib
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click
import trimesh

from softbody import scenes
from softbody.cli.warmup import KINDS, Kind
from tests.matrix import pythons
from tests.readme_example import readme_example
from validation.installed import Use, compile_for, use

ROOT = Path(__file__).parents[1]
DIST = ROOT / "build" / "dist"
BUILDS = {("Linux", "x86_64"): ("x86-64-v3", "manylinux_2_17_x86_64")}  # no library is linked but by Numba
FOLDER_NAME = "from softbody.compiler.shipped_code import folder_name; print(folder_name({family!r}))"


@contextmanager
def folder_of(minor: int) -> Iterator[Path]:
    """Make a folder for a Python's environment, the same each time, and remove it afterwards.

    Machine code names Numba's files, so that other places were other bytes. Raises click.ClickException if it is there.
    """
    folder = Path(tempfile.gettempdir()) / f"softbody-wheel-3.{minor}"
    try:
        folder.mkdir(mode=0o700)
    except FileExistsError:
        raise click.ClickException(f"{folder} is there: wait for the build that runs, or remove it") from None
    try:
        yield folder
    finally:
        shutil.rmtree(folder)


def build_platform_wheel(uv: str, python: str, kinds: tuple[Kind, ...] = KINDS) -> tuple[Path, str]:
    """Compile with a `python` that has the core installed, and build; return the wheel, and its size in words.

    Raises click.ClickException where no family of processors is known, and subprocess.CalledProcessError.
    """
    from rich.progress import track

    here = platform.system(), platform.machine()
    if here not in BUILDS:
        raise click.ClickException(f"no family of processors is known for {' '.join(here)}: the wheel would be pure")
    family, tag = BUILDS[here]
    with tempfile.TemporaryDirectory() as folder:
        name = _run([python, "-c", FOLDER_NAME.format(family=family)], folder).strip()
        code = Path(folder) / "code" / name
        for kind in track(kinds, name):
            compile_for(family, kind, code, Path(folder), python)
        shutil.rmtree(code.with_name(f"parts-{name}"))
        chosen = {"SOFTBODY_MACHINE_CODE": str(code.parent), "SOFTBODY_PLATFORM": tag}
        _run([uv, "build", "--quiet", "--wheel", "--python", python, "--out-dir", str(DIST), str(ROOT)], folder, chosen)
        wheel = max(DIST.glob(f"*{tag}.whl"), key=lambda path: path.stat().st_mtime)
        files = list(code.rglob("*.nbc"))
        size = sum(path.stat().st_size for path in files)
    digest = hashlib.sha256(wheel.read_bytes()).hexdigest()[:16]
    kernels = f"{len(files)} kernels, {size / 1e6:.1f} MB as installed"
    return wheel, f"{wheel.name}, {wheel.stat().st_size / 1e6:.2f} MB, {kernels}, sha256 {digest}"


def programs() -> Iterator[tuple[str, str]]:
    """Yield what a newcomer runs: name and program of README, examples and scenes."""
    yield "README", readme_example(ROOT / "README.md")
    for example in sorted((ROOT / "examples").glob("*.py")):
        yield f"example {example.stem}", example.read_text("utf-8")
    for scene in scenes.__all__:
        yield f"scene {scene}", f"import softbody; softbody.scenes.{scene}.build().run(0.01)"


def first_uses(python: str, wheel: Path, folder: Path) -> Iterator[tuple[str, Use | str]]:
    """Install a wheel with all that examples need, and use it without a cache; yield what was done, and the use.

    Of a program that fails, it is the last line that it wrote.
    """
    _run([python, "-m", "pip", "install", "--quiet", "--force-reinstall", "--no-deps", str(wheel)], str(folder))
    _run([python, "-m", "pip", "install", "--quiet", f"{wheel}[files,mp4,record,scenes]", "matplotlib"], str(folder))
    trimesh.creation.icosphere(2, 0.2).export(folder / "part.stl")
    for name, program in programs():
        try:
            yield name, use(program, folder, ("part.stl",), python)  # one of them is told a mesh file
        except subprocess.CalledProcessError as error:
            yield name, (error.stderr.strip().splitlines() or ["nothing was written"])[-1]


def show_first_uses(python: str, wheel: Path, folder: Path) -> bool:
    """Print a line for each first use; return whether all went well and nothing was compiled."""
    well = True
    for name, found in first_uses(python, wheel, folder):
        if isinstance(found, str):
            click.echo(f"{name:28} failed: {found}")
        else:
            compiles = f", compiles {' '.join(found.compiled)}" if found.compiled else ""
            click.echo(f"{name:28} {found.seconds:6.2f} s of the processor{compiles}")
        well &= not isinstance(found, str) and not found.compiled
    return well


def _run(command: list[str], folder: str, more: dict[str, str] | None = None) -> str:
    done = subprocess.run(command, env={**os.environ, **(more or {})}, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise click.ClickException(f"{' '.join(command[:4])} … failed:\n{done.stderr}")
    return done.stdout


@click.command()
@click.option("--uv", default="uv", help="The program that builds the wheel.")
@click.option("-k", "only", default=f"3.{sys.version_info[1]}", help="The Pythons with this in them; '' for all.")
@click.option("--kinds", type=int, default=len(KINDS), help="Only so many kinds of worlds, the last ones.")
def main(uv: str, only: str, kinds: int) -> None:
    """Compile, build, and use what was built as a newcomer does. Two runs build the same bytes.

    Exit code: 0, or 1 where a first use has failed, or has compiled something.
    """
    uv = str(Path(uv).resolve()) if Path(uv).exists() else uv
    well = True
    for minor, python in pythons():
        if only not in f"3.{minor}":
            continue
        with folder_of(minor) as folder:
            _run([python, "-m", "venv", str(folder)], str(folder))
            new = str(folder / "bin" / "python")
            _run([new, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", str(ROOT)], str(folder))
            wheel, said = build_platform_wheel(uv, new, KINDS[len(KINDS) - kinds :])
            click.echo(said)
            well &= show_first_uses(new, wheel, folder)
    sys.exit(0 if well else 1)


if __name__ == "__main__":
    main()
