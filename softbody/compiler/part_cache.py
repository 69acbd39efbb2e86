"""Parts of kernels on the disk: after an edit of the core, what it changes is compiled, and what else there is linked.

A part is kept under the fingerprint of its function, the types of its arguments and all that is the same for every
part. It holds as long as the parts that it calls return what they returned, and are called the same. Its file may lie
anywhere, since what a core is does not depend on where: SOFTBODY_PARTS_IN names one for several copies of the core.
"""

from __future__ import annotations

import hashlib
import os
import sys
from contextlib import suppress
from functools import cache, cached_property
from typing import Any, NamedTuple

import llvmlite
import numba
import numpy as np
from numba.core.caching import FunctionCache
from numba.core.compiler import compile_result
from numba.core.environment import Environment
from numba.core.errors import NumbaError
from numba.core.sigutils import normalize_signature

from softbody.compiler.cache_file import CacheFile
from softbody.compiler.core_digest import FLAGS, source_digest
from softbody.compiler.fingerprint import UnknownValueError, fingerprint, words_of_types
from softbody.compiler.libraries import PartLibrary

PARTS_IN = "SOFTBODY_PARTS_IN"

_kernels: dict[str, Any] = {}  # by name; None where several have the same


class Callee(NamedTuple):
    """A part as one that calls it sees it."""

    name: str
    arguments: tuple[Any, ...]
    returned: Any
    symbol: str  # which it is called by in machine code: Numba names it by flags, too, that depend on its body


class KeptPart(NamedTuple):
    """A part as it is on the disk."""

    bitcode: bytes
    descriptor: Any
    signature: Any
    reload: tuple[Any, ...]
    callees: tuple[Callee, ...]


def register(name: str, kernel: Any) -> None:
    """Let parts that are kept find a kernel by its name."""
    _kernels[name] = None if name in _kernels else kernel


def unique_id(name: str, function: Any, signature: Any) -> str | None:
    """Return what tells a function, compiled for a signature, from all others; None where that cannot be told.

    Numba's own names do not tell types of the same name from each other, such as two NamedTuples.
    """
    kernel = _kernels.get(name)
    if kernel is None or kernel.py_func is not function:
        return None  # another kernel is called the same
    try:
        words = f"{name} {words_of_types(normalize_signature(signature)[0])}"
    except UnknownValueError:
        return None
    return hashlib.sha256(words.encode()).hexdigest()[:16]


def part_of(callee: Callee) -> Any:
    """Return what was compiled of a callee, or is now; None if it is no more what its caller calls."""
    kernel = _kernels.get(callee.name)
    if kernel is None:
        return None
    part = kernel.part
    try:
        part.compile(callee.arguments)
    except NumbaError:  # the caller says so, as it is compiled
        return None
    compiled = part.overloads[callee.arguments]
    is_same = compiled.signature.return_type == callee.returned and compiled.fndesc.mangled_name == callee.symbol
    return compiled if is_same else None


class PartCache:
    """Where Numba asks for the code of one part, and keeps it."""

    def __init__(self, name: str, function: Any) -> None:
        self._name, self._function = name, function

    @property
    def cache_path(self) -> str | None:
        """The folder of all parts."""
        return parts_folder()

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        """Return what is kept for the types of a part's arguments, if it still fits; or None."""
        target_context.refresh()
        kept = self._load(normalize_signature(signature)[0], target_context.codegen())
        if kept is None:
            return None
        callees = [part_of(callee) for callee in kept.callees]
        if None in callees:
            return None
        for again in kept.reload:
            again()
        library = PartLibrary(target_context.codegen(), kept.descriptor.mangled_name)
        library.fill(kept.bitcode, [each.library for each in callees], kept.reload)
        environment = Environment.from_fndesc(kept.descriptor)
        return compile_result(
            target_context=target_context,
            typing_context=target_context.typing_context,
            library=library,
            environment=environment,
            entry_point=target_context.get_executable(library, kept.descriptor, environment),
            fndesc=kept.descriptor,
            signature=kept.signature,
            objectmode=False,
            lifted=(),
            reload_init=kept.reload,
            referenced_envs=(),
        )

    def save_overload(self, signature: Any, data: Any) -> None:
        """Keep a part, if the disk takes it, and nothing in it is of this process alone."""
        callees = tuple(each.seen_as for each in data.library.callees)
        if not data.library.is_lasting or data.library.seen_as is None or None in callees or data.environment.consts:
            return
        key, folder = self._key(data.signature.args, data.codegen), parts_folder()
        if not key or not folder:
            return
        data.fndesc.typemap = data.fndesc.calltypes = None
        kept = KeptPart(
            data.library.bitcode(), data.fndesc, data.signature, tuple(dict.fromkeys(data.reload_init)), callees
        )
        with suppress(OSError):  # then it is compiled anew
            CacheFile(folder, self._base).save(key, kept)

    def _load(self, arguments: Any, codegen: Any) -> KeptPart | None:
        key, folder = self._key(arguments, codegen), parts_folder()
        return CacheFile(folder, self._base).load(key) if key and folder else None

    def _key(self, arguments: Any, codegen: Any) -> Any:
        """Return what a part is kept under; None if that cannot be told."""
        try:
            return self._name, self._fingerprint, words_of_types(arguments), codegen.magic_tuple(), _for_all_parts()
        except UnknownValueError:
            return None

    @property
    def _base(self) -> str:
        return f"{self._function.__module__}.{self._function.__qualname__}"

    @cached_property
    def _fingerprint(self) -> str:
        return fingerprint(self._function)


@cache
def parts_folder() -> str | None:
    """Return the folder of all parts; None where none can be written."""
    try:
        folder = os.environ.get(PARTS_IN) or f"{FunctionCache(register).cache_path}/parts"
        os.makedirs(folder, exist_ok=True)
    except (OSError, RuntimeError):
        return None
    return folder


@cache
def _for_all_parts() -> str:
    """Return the hash of what decides the code of every part: Numba, LLVM, Python, flags, and how the core compiles."""
    digest = hashlib.sha256()
    flags = [f"{flag}={os.environ.get(flag)}" for flag in FLAGS]
    digest.update(repr([sys.version_info[:2], numba.__version__, llvmlite.__version__, np.__version__, flags]).encode())
    digest.update(source_digest("compiler").encode())
    return digest.hexdigest()
