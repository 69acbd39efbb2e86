"""`python -m validation.foreign`: makes the environments of engines that need one of their own, from pins."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import click

from validation.foreign import ENVIRONMENTS, HERE

NODE, PYTHON = ("package.json", "package-lock.json"), ("requirements.txt",)  # pins
UV = HERE.parents[1] / ".uv" / "bin" / "uv"  # where the Makefile puts it, if there is none


def engines() -> list[str]:
    """Return the engines that have an environment of their own."""
    return sorted(
        folder.name for folder in HERE.iterdir() if any((folder / pins[0]).is_file() for pins in (NODE, PYTHON))
    )


def made(engine: str, say: Callable[[str], None]) -> str | None:
    """Make the environment of an engine, if its pins are not those of the one that is there; return why it cannot be.

    The pins are put into it last: what an interrupt leaves is not taken for an environment, and is made anew.
    """
    place, by_node = ENVIRONMENTS / engine, (HERE / engine / NODE[0]).is_file()
    pins = [HERE / engine / name for name in (NODE if by_node else PYTHON)]
    if all((place / pin.name).is_file() and (place / pin.name).read_bytes() == pin.read_bytes() for pin in pins):
        return None
    say(f"makes the environment of {engine}, once")
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    why = _install_node(place, pins) if by_node else _install_python(place, pins[0])
    if why:
        shutil.rmtree(place, ignore_errors=True)
        return why
    for pin in pins:
        shutil.copy(pin, place)
    return None


def _install_node(place: Path, pins: list[Path]) -> str | None:
    if not shutil.which("npm"):
        return "npm is not installed: on Debian, `apt-get install nodejs npm`"
    with tempfile.TemporaryDirectory() as folder:
        for pin in pins:
            shutil.copy(pin, folder)
        why = _done(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"], Path(folder))
        if not why:
            shutil.copytree(Path(folder, "node_modules"), place / "node_modules")
        return why


def _install_python(place: Path, pins: Path) -> str | None:
    uv = shutil.which("uv") or str(UV)
    if not Path(uv).is_file():
        return "uv is not installed: `pip install uv`"
    python = str(place / "bin" / "python")
    return _done([uv, "venv", "--quiet", "--clear", "--python", "3.11", str(place)]) or _done(
        [uv, "pip", "sync", "--quiet", "--require-hashes", "--python", python, str(pins)]
    )


def _done(command: list[str], folder: Path | None = None) -> str | None:
    """Return why a command has failed, if it has."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if not done.returncode:
        return None
    return f"{Path(command[0]).name} could not install it: {(done.stderr or done.stdout).strip()[:600]}"


@click.command()
@click.argument("names", nargs=-1, metavar="[ENGINE]...", type=click.Choice(engines()))
def main(names: tuple[str, ...]) -> None:
    """Make the environment of each ENGINE, or of all."""
    failed = False
    for name in names or engines():
        why = made(name, lambda text: click.echo(text, err=True))
        click.echo(f"{name}: {why or f'is in {ENVIRONMENTS / name}'}", err=True)
        failed |= why is not None
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
