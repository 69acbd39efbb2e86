"""Plug-ins of other packages: engines, claims and subjects, which they name by entry points.

`softbody.engines` and `softbody.subjects` name modules that are read, as files of references/ are, `softbody.claims`
one that declares claims when it is imported. A plug-in that is broken costs its own claims, and is said: it is imported
in a process of its own first, which it may end, or keep for ever.
"""

from __future__ import annotations

import importlib
import importlib.util
import json
import os
import subprocess
import sys
from collections.abc import Callable, MutableMapping
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any, TypeVar

from validation.declared import Declared, read_file
from validation.plain_text import plain

ENGINES, CLAIMS, SUBJECTS = "softbody.engines", "softbody.claims", "softbody.subjects"

Found = TypeVar("Found")

PATIENCE = 60.0  # seconds that an import may take
TRIED = "SOFTBODY_TRIED_PLUG_INS"  # environment variable: what came of it, for the processes that we start
# What raises is left for us to hear; the exit status tells that the import came to an end.
TRY, ENDED = "import os, sys\nsys.path[:] = {}\ntry:\n    import {}\nfinally:\n    os._exit({})", 77

BROKEN: dict[str, str] = {}  # group, package and name of an entry point that cannot be used → why


@cache
def engines() -> list[Declared]:
    """Return what the engines of other packages say of themselves."""
    return _each(ENGINES, lambda point: read_file(_file_of(point.module), point.module))


@cache
def subjects() -> list[Declared]:
    """Return the adapters of other packages, by the names of their entry points."""
    return _each(SUBJECTS, lambda point: read_file(_file_of(point.module), point.name, point.module))


def load_claims(declared: MutableMapping[str, Any]) -> None:
    """Import the claims of other packages, which declares them; of one that is broken, none is left in `declared`."""

    def declare(point: metadata.EntryPoint) -> None:
        why = _fatal(point.module)
        if why:
            raise ValueError(why)
        before = set(declared)
        try:
            importlib.import_module(point.module)
        except BaseException:
            for name in set(declared) - before:
                del declared[name]
            raise

    _each(CLAIMS, declare)


def packages() -> list[str]:
    """Return the import names of the packages that add something."""
    return sorted({point.module.partition(".")[0] for group in (ENGINES, CLAIMS, SUBJECTS) for point in _points(group)})


def _each(group: str, use: Callable[[metadata.EntryPoint], Found]) -> list[Found]:
    """Return what becomes of each entry point of a group; what goes wrong, an exit included, is noted in BROKEN."""
    found = []
    for point in _points(group):
        try:
            found.append(use(point))
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            package = point.dist.metadata["Name"] if point.dist else point.module
            name = plain(f"{group}.{package}.{point.name}")
            what = plain(error) if isinstance(error, ValueError) else f"{type(error).__name__}: {plain(error)}"
            BROKEN[name] = f"{plain(package)} (entry point {plain(point.value)}) is broken: {what}"
    return found


def _fatal(module: str) -> str | None:
    """Return what becomes of a process that imports a module, if it does not outlive it."""
    tried: dict[str, str | None] = json.loads(os.environ.get(TRIED, "{}"))
    if module not in tried:
        tried[module] = _fate(module)
        os.environ[TRIED] = json.dumps(tried)
    return tried[module]


def _fate(module: str) -> str | None:
    command = [sys.executable, "-c", TRY.format(sys.path, module, ENDED)]
    null = subprocess.DEVNULL
    try:
        status = subprocess.run(command, stdin=null, stdout=null, stderr=null, timeout=PATIENCE, check=False).returncode
    except subprocess.TimeoutExpired:
        return f"its import is not done after {PATIENCE:g} s"
    if status == ENDED:
        return None
    return f"its import ends the process ({f'signal {-status}' if status < 0 else f'exit status {status}'})"


def _points(group: str) -> list[metadata.EntryPoint]:
    return sorted(metadata.entry_points(group=group), key=lambda point: (point.value, point.name))


def _file_of(module: str) -> Path:
    """Return the file of a module, without importing its package; raises ValueError if there is none."""
    top, *rest = module.split(".")
    spec = importlib.util.find_spec(top)
    for folder in (spec.submodule_search_locations or ()) if spec else ():
        path = Path(folder, *rest)
        for file in (path.with_suffix(".py") if rest else path, path / "__init__.py"):
            if file.is_file():
                return file
    if spec and spec.origin and not rest:
        return Path(spec.origin)
    raise ValueError(f"there is no module {module}; correct the entry point, or install the package again")
