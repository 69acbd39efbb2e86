"""Machine code that came with the package, for a Python, a Numba and a family of processors.

It is asked for where no cache has any. It fits where Python's minor version, Numba, the system and the core's sources
are those that it was built with, the processor has at least the features of the family, and nobody has asked Numba for
other code by its variables. It is believed as the sources beside it are, and never written.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import numba

from softbody.compiler.cache_file import CacheFile
from softbody.compiler.cache_warning import warn_not_read
from softbody.compiler.core_digest import FLAGS, SOURCE_DIGEST

ROOT = Path(__file__).parents[1] / "_machine_code"

# Features that code for a family of processors may use, as LLVM calls them.
_V2 = "cx16 sahf popcnt sse3 ssse3 sse4.1 sse4.2"
FAMILIES = {"x86-64-v3": frozenset(f"{_V2} avx avx2 bmi bmi2 f16c fma lzcnt movbe xsave".split())}

# Where kernels are kept as they are compiled, to be shipped; see `tests.platform_wheel`.
KEEP_IN = "SOFTBODY_KEEP_MACHINE_CODE_IN"


def folder_name(family: str) -> str:
    """Return where code for a family of processors is, within ROOT."""
    return f"{sys.implementation.cache_tag}-numba-{numba.__version__}-{family}"


def load_shipped(function: Any, key: tuple[Any, ...]) -> Any:
    """Return what was shipped for a kernel, by its key in Numba's cache; or None."""
    _, (_, _, features), *_ = key
    where = _folder(features)
    if where is None:
        return None
    file = CacheFile(str(where), _base(function))
    found = file.load(_shipped_key(function, key))
    if found is None and file.has(_shipped_key(function, key)):
        warn_not_read(where)
    return found


def keep_to_ship(function: Any, key: tuple[Any, ...], reduced: Callable[[], Any]) -> None:
    """Keep a kernel's machine code as it is `reduced`, if this process compiles what is to be shipped."""
    where = os.environ.get(KEEP_IN)
    if where:
        CacheFile(where, _base(function)).save(_shipped_key(function, key), reduced())


def stripped(reduced: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return a reduced CompileResult without what only callers, people, or code in object mode would ask for.

    These are LLVM's bitcode, type annotations, and environments.
    """
    (name, kind, (code, _)), fndesc, *rest = reduced
    bare = llvm.parse_assembly(f'define void @"{fndesc.llvm_cpython_wrapper_name}"() {{ ret void }}')
    rest[4], rest[6] = "", ()  # what `inspect_types` shows; environments
    return ((name, kind, (code, bare.as_bitcode())), fndesc, *rest)


@cache
def _folder(features: str) -> Path | None:
    """Return the folder of a family that a processor is of, by its features as Numba lists them; None if none fits."""
    if not ROOT.is_dir() or any(os.environ.get(flag) for flag in FLAGS):
        return None
    has = {each[1:] for each in features.split(",") if each.startswith("+")}
    fitting = [ROOT / folder_name(family) for family, needs in FAMILIES.items() if needs <= has]
    return next((each for each in fitting if each.is_dir()), None)


def _base(function: Any) -> str:
    return f"{function.__module__}.{function.__qualname__}"


def _shipped_key(function: Any, key: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return what a kernel is kept under: Numba's key, but for the processor, which the folder tells."""
    signature, (triple, _, _), hashes, *_ = key
    return _base(function), signature, triple, hashes, SOURCE_DIGEST
