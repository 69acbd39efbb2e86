"""Engines and libraries that are installed, with their versions, and the machine."""

from __future__ import annotations

import importlib.util
import json
import os
import platform
import subprocess
from importlib import metadata
from pathlib import Path

from validation import plug_ins
from validation.declared import Declared, all_in
from validation.record import ENGINE


def declared_engines() -> list[Declared]:
    """Return what the files of references/, and those of plug-ins, say; nothing is imported for that."""
    spec = importlib.util.find_spec("references")
    folders = spec.submodule_search_locations if spec else None
    return [one for folder in folders or () for one in all_in(Path(folder))] + plug_ins.engines()


DECLARED = declared_engines()

# Import name of everything that a claim may lean on → the name under which it is installed.
PACKAGES = {"numpy": "numpy", "numba": "numba"}
for one in [*DECLARED, *plug_ins.subjects()]:
    PACKAGES |= one.packages

# Import names of what is another simulator, or a collision library, and not mathematics.
ENGINES = frozenset(name for one in DECLARED if one.kind == ENGINE for name in one.packages)


def missing(engines: tuple[str, ...]) -> list[str]:
    """Return those of `engines` (import names) that cannot be found, without importing any."""
    return [engine for engine in engines if importlib.util.find_spec(engine) is None]


def versions() -> dict[str, str | None]:
    """Return the version of each package, None where it is missing."""
    return {name: _version(package) for name, package in PACKAGES.items()}


def version_of(engine: Declared) -> str | None:
    """Return the version of the package that a file stands on, the first that it names, or of its own environment."""
    return _version(next(iter(engine.packages.values()))) if engine.packages else _pinned(engine.name)


def _pinned(name: str) -> str | None:
    """Return the version that an engine in an environment of its own is pinned to; None if it has none."""
    home = Path(__file__).parent / "foreign" / name
    if (home / "package.json").is_file():
        return str(next(iter(json.loads((home / "package.json").read_text())["dependencies"].values())))
    if (home / "requirements.in").is_file():
        return (home / "requirements.in").read_text().partition("==")[2].strip()
    return None


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def environment() -> dict[str, str]:
    """Describe the machine, as far as it bears on results and timings."""
    import psutil

    return {
        "Python": f"{platform.python_implementation()} {platform.python_version()}",
        "system": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "cores": f"{psutil.cpu_count(logical=False) or '?'} physical, {os.cpu_count()} logical",
        "memory": f"{psutil.virtual_memory().total / 2**30:.1f} GiB",
    }


def _processor() -> str:
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        for line in cpuinfo.read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def revision(package: Path) -> str | None:
    """Return the git commit that a package's folder belongs to, with "+" if anything in its repository differs.

    None where it is not under version control, such as an installed one, be it in a folder inside a repository.
    """
    if _git("ls-files", "--error-unmatch", "__init__.py", folder=package) is None:
        return None
    return _git("describe", "--always", "--abbrev=12", "--dirty=+", "--exclude=*", folder=package)


def _git(*arguments: str, folder: Path) -> str | None:
    """Return what git says in a folder, or None if it fails or says nothing."""
    try:
        done = subprocess.run(["git", *arguments], cwd=folder, capture_output=True, text=True, timeout=10)
    except (OSError, subprocess.TimeoutExpired):
        return None
    return (done.stdout.strip() or None) if done.returncode == 0 else None
