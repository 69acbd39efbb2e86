"""Machine code that need not be compiled: what this user has kept, what others have, and what came with the package.

It leans on private parts of Numba, as `compile_once` says.
"""

from __future__ import annotations

import inspect
import sys
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache, UserProvidedCacheLocator
from numba.core.compiler import CompileResult

from softbody.compiler.cache_file import CacheFile
from softbody.compiler.cache_warning import warn_not_kept
from softbody.compiler.core_digest import CORE_DIGEST
from softbody.compiler.shipped_code import keep_to_ship, load_shipped, stripped


class _Stripped(CompileResultCacheImpl):
    """How Numba keeps a kernel; nobody links it, so that machine code is all that it takes."""

    def reduce(self, cres: Any) -> Any:
        return stripped(super().reduce(cres))


class _ByCore(FunctionCache):
    """Numba's cache, with all of the core in its key.

    Numba's own is the file of the function itself: after an edit to a callee in another file it would load stale
    machine code, silently. It also ignores the bounds-check flag.
    """

    _py_func: Any
    _impl_class = _Stripped

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        return (*super()._index_key(sig, codegen), CORE_DIGEST)

    def _load_from_elsewhere(self, sig: Any, target_context: Any, own: str | None) -> Any:
        """Return what is kept where it can be read, besides the user's own folder; or else what came along."""
        key = self._index_key(sig, target_context.codegen())
        for folder in _folders(self._py_func):
            reduced = CacheFile(folder, base_of(self._py_func)).load(key) if folder != own else None
            if reduced is not None:
                return CompileResult._rebuild(target_context, *reduced)
        reduced = load_shipped(self._py_func, key)
        return CompileResult._rebuild(target_context, *reduced) if reduced is not None else None


class _OwnFolder(_ByCore):
    """The cache of a kernel, in a folder that can be written."""

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        self._cache_file: Any = CacheFile(self._cache_path, base_of(function))

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        found = super().load_overload(sig, target_context)
        return self._load_from_elsewhere(sig, target_context, self._cache_path) if found is None else found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep machine code, if the disk takes it."""
        try:
            super().save_overload(sig, data)
        except OSError as error:
            warn_not_kept(error)
        keep_to_ship(self._py_func, self._index_key(sig, data.codegen), lambda: self._impl.reduce(data))


class _NoFolder(_ByCore):
    """The cache of a kernel where no folder can be written: others may still be read."""

    def __init__(self, function: Any, why: object) -> None:
        self._py_func, self._cache_path, self._why = function, None, why

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        target_context.refresh()
        return self._load_from_elsewhere(sig, target_context, None)

    def save_overload(self, sig: Any, data: Any) -> None:
        warn_not_kept(self._why)

    def flush(self) -> None:
        """Forget all that is kept: nothing."""


def cache_of(function: Any) -> Any:
    """Return the cache of a kernel's machine code."""
    try:
        return _OwnFolder(function)
    except (RuntimeError, OSError) as error:
        return _NoFolder(function, error)


def base_of(function: Any) -> str:
    """Return how the names of a kernel's files begin."""
    name = f"{Path(inspect.getfile(function)).stem}.{function.__qualname__}"
    return f"{name}-{function.__code__.co_firstlineno}.{sys.implementation.cache_tag}"


def _folders(function: Any) -> list[str]:
    """Return where Numba would keep a kernel if it could write there: chosen by the user, or beside the sources."""
    source, chosen = inspect.getfile(function), numba.config.CACHE_DIR  # type: ignore[attr-defined]
    beside = [str(Path(source).parent / "__pycache__")]
    if not chosen:
        return beside
    return [str(Path(chosen) / UserProvidedCacheLocator.get_suitable_cache_subpath(source)), *beside]
