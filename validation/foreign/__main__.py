"""`python -m validation.foreign`: makes the environments of engines that need one of their own, from pins."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable

import click

from validation.foreign import ENVIRONMENTS, HERE

PINS = ("package.json", "package-lock.json")


def engines() -> list[str]:
    """Return the engines that have an environment of their own."""
    return sorted(folder.name for folder in HERE.iterdir() if (folder / PINS[0]).is_file())


def made(engine: str, say: Callable[[str], None]) -> str | None:
    """Make the environment of an engine, if its pins are not those of the one that is there; return why it cannot be.

    It is made beside its place and moved there when it is whole: an interrupt leaves what was there.
    """
    place, pins = ENVIRONMENTS / engine, [HERE / engine / name for name in PINS]
    if all((place / pin.name).is_file() and (place / pin.name).read_bytes() == pin.read_bytes() for pin in pins):
        return None
    if not shutil.which("npm"):
        return "npm is not installed: on Debian, `apt-get install nodejs npm`"
    say(f"makes the environment of {engine}: once, a few seconds and 50 MB")
    ENVIRONMENTS.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=ENVIRONMENTS) as folder:
        for pin in pins:
            shutil.copy(pin, folder)
        command = ["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            return f"npm could not install it: {(done.stderr or done.stdout).strip()[:600]}"
        shutil.rmtree(place, ignore_errors=True)
        shutil.copytree(folder, place)
    return None


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
