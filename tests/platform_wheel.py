"""Builds a wheel that brings the machine code of every kernel, for this Python and this kind of processor.

`make wheel`. Every kind of world is compiled in a process of its own, one after the other: that takes as long as
`python -m softbody warmup` does on one core. Then the wheel is used as by a newcomer who can keep nothing.
"""

from __future__ import annotations

import hashlib
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import click
import trimesh

from softbody import scenes
from softbody.cli.warmup import KINDS, Kind
from softbody.compiler.shipped_code import KEEP_IN, folder_name
from tests.readme_example import readme_example

ROOT = Path(__file__).parents[1]
DIST, CODE = ROOT / "build" / "dist", ROOT / "build" / "machine_code"
BUILDS = {("Linux", "x86_64"): ("x86-64-v3", "manylinux_2_17_x86_64")}  # no library is linked but by Numba
EXAMPLES = ("bowling", "keep_and_export", "pull_pin_inflate", "resting", "squeeze_part")  # not too long
COMPILE = "from softbody.cli.warmup import Kind, run_small_world; run_small_world({kind!r})"


def compile_kinds(family: str, kinds: tuple[Kind, ...], code: Path) -> Iterator[Kind]:
    """Compile kinds of worlds for a family of processors into `code`; yield each when it is done."""
    where = code / folder_name(family)
    where.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as cache:
        chosen = {
            "NUMBA_CPU_NAME": family,
            "NUMBA_CPU_FEATURES": "",  # those of the family, and not the host's
            "NUMBA_CACHE_DIR": cache,
            "PYTHONHASHSEED": "0",
            KEEP_IN: str(where),
        }
        for kind in kinds:
            program = [sys.executable, "-c", COMPILE.format(kind=kind)]
            subprocess.run(program, env={**os.environ, **chosen}, cwd=ROOT, check=True)
            yield kind


WATCH = """
import sys, time
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
    exec(compile(sys.argv.pop(1), "program", "exec"), {"__name__": "__main__"})
finally:
    print(round(time.process_time() - began, 2), *sorted(set(compiled)), file=sys.stderr)
"""


def first_uses(wheel: Path, folder: Path) -> Iterator[tuple[str, str]]:
    """Install a wheel in a clean environment, and use it without a cache; yield what was done, and what that compiled.

    The second is the seconds of the processor, and the kernels that were compiled.
    """
    subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
    python = str(folder / "bin" / "python")
    subprocess.run(
        [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", f"{wheel}[files,record]"], check=True
    )
    own = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "NUMBA_", "SOFTBODY_"))}
    own |= {"NUMBA_CACHE_DIR": "/proc/nowhere", "PYTHONDONTWRITEBYTECODE": "1"}
    programs = {"README": readme_example(ROOT / "README.md")}
    programs |= {f"example {name}": (ROOT / "examples" / f"{name}.py").read_text("utf-8") for name in EXAMPLES}
    for scene in scenes.__all__:
        programs[f"scene {scene}"] = f"import softbody; softbody.scenes.{scene}.build().run(0.01)"
    trimesh.creation.icosphere(2, 0.2).export(folder / "part.stl")
    for name, program in programs.items():
        command = [python, "-W", "ignore", "-c", WATCH, program, "part.stl"]  # one of them is told a mesh file
        done = subprocess.run(command, env=own, cwd=folder, capture_output=True, text=True)
        said = (done.stderr.strip().splitlines() or [""])[-1]
        yield name, said if done.returncode == 0 else f"failed: {said}"


def digest_of(folder: Path) -> str:
    """Return one hash of all files in a folder."""
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*.nbc")):
        digest.update(path.relative_to(folder).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()


@click.command()
@click.option("--uv", default="uv", help="The program that builds the wheel.")
@click.option("-k", "kinds", type=int, default=len(KINDS), help="Only so many kinds of worlds, the last ones.")
def main(uv: str, kinds: int) -> None:
    """Compile, build, and use what was built as a newcomer does. Two runs build the same bytes.

    Exit code: 0, or 1 where a first use has compiled something.
    """
    from rich.progress import track

    here = platform.system(), platform.machine()
    if here not in BUILDS:
        raise click.ClickException(f"no family of processors is known for {' '.join(here)}: the wheel would be pure")
    family, tag = BUILDS[here]
    for old in CODE.rglob("*.nbc"):
        old.unlink()
    chosen = KINDS[len(KINDS) - kinds :]
    for _ in track(compile_kinds(family, chosen, CODE), "kinds of worlds", total=len(chosen)):
        pass
    files = list(CODE.rglob("*.nbc"))
    size = sum(path.stat().st_size for path in files)
    command = [uv, "build", "--quiet", "--wheel", "--python", sys.executable, "--out-dir", str(DIST), str(ROOT)]
    subprocess.run(
        command, env={**os.environ, "SOFTBODY_MACHINE_CODE": str(CODE), "SOFTBODY_PLATFORM": tag}, check=True
    )
    wheel = max(DIST.glob(f"*{tag}.whl"), key=lambda path: path.stat().st_mtime)
    click.echo(f"{len(files)} kernels, {size / 1e6:.1f} MB, sha256 {digest_of(CODE)[:16]}")
    digest = hashlib.sha256(wheel.read_bytes()).hexdigest()[:16]
    click.echo(f"{wheel.relative_to(ROOT)}, {wheel.stat().st_size / 1e6:.2f} MB, sha256 {digest}")
    compiles = False
    with tempfile.TemporaryDirectory() as folder:
        for name, said in first_uses(wheel, Path(folder)):
            seconds, _, what = said.partition(" ")
            click.echo(f"{name:28} {seconds:>6} s of the processor{', compiles ' + what if what else ''}")
            compiles |= bool(what)
    sys.exit(compiles)


if __name__ == "__main__":
    main()
