"""What a kernel's own code depends on, as one hash: its bytecode, and every value that its names stand for.

Of another kernel its name counts, and how it is called, unless it is pasted into this one: a caller's code holds no
more of it, but for the type of what it returns.
"""

from __future__ import annotations

import builtins
import hashlib
import inspect
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any, cast

import numpy as np
from numba.core import types
from numba.core.dispatcher import Dispatcher

from softbody.compiler.core_digest import source_digest
from softbody.compiler.simd_types import LanesType

PLAIN = (bool, int, float, complex, str, bytes, type(None), np.generic, np.dtype)


class UnknownValueError(TypeError):
    """A kernel refers to something that this module cannot tell from another."""


def fingerprint(function: FunctionType) -> str:
    """Return the hash of a function as it would be compiled now; raises UnknownValueError."""
    digest = hashlib.sha256()
    for word in _words_of(function):
        digest.update(f"{len(word)}:".encode() + word)
    return digest.hexdigest()


def words_of_types(kinds: Iterable[Any]) -> str:
    """Return types of Numba's in words that are the same in every process; raises UnknownValueError."""
    return f"({', '.join(map(_words_of_type, kinds))})"


def _words_of_type(kind: Any) -> str:
    if isinstance(kind, (types.NamedTuple, types.NamedUniTuple)):
        one: Any = kind.instance_class
        return f"{_named(one)}{one._fields}{words_of_types(cast(Any, kind))}"
    if isinstance(kind, types.BaseTuple):
        return words_of_types(cast(Any, kind))
    if isinstance(kind, types.Optional):
        return f"{_words_of_type(kind.type)}?"
    if isinstance(kind, types.Array):
        return f"{kind} {kind.aligned}"
    if isinstance(kind, (types.Number, types.Boolean, types.NoneType, types.UnicodeType, LanesType)):
        return str(kind)
    raise UnknownValueError(f"no words for arguments of type {kind}")


def _words_of(function: FunctionType) -> Iterator[bytes]:
    yield from (function.__module__.encode(), function.__qualname__.encode())
    yield from _words_of_signature(function)
    for cell in function.__closure__ or ():
        yield from _words(cell.cell_contents)
    for code in _codes(function.__code__):
        yield from (code.co_code, getattr(code, "co_exceptiontable", b""))
        for names in (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars):
            yield repr(names).encode()
        yield from _words([each for each in code.co_consts if not isinstance(each, CodeType)])
        for name in code.co_names:
            if name in function.__globals__:
                yield from _words(function.__globals__[name])
            else:
                yield repr(getattr(builtins, name, None)).encode()


def _words_of_signature(function: FunctionType) -> Iterator[bytes]:
    """Yield what a caller's code depends on, which fills in what is left out, and orders what is named."""
    code = function.__code__
    yield repr((code.co_argcount, code.co_kwonlyargcount, code.co_flags)).encode()
    yield repr(code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]).encode()
    yield from _words(function.__defaults__)
    yield from _words(sorted((function.__kwdefaults__ or {}).items()))


def _codes(code: CodeType) -> Iterator[CodeType]:
    """Yield a code object and all that are within it."""
    yield code
    for each in code.co_consts:
        if isinstance(each, CodeType):
            yield from _codes(each)


def _words(value: Any) -> Iterable[bytes]:
    """Return what tells a value from others."""
    if isinstance(value, Dispatcher):
        yield b"kernel"
        if value.targetoptions.get("inline") == "always":
            yield from _words_of(value.py_func)
        else:
            yield name_of(value.py_func, value.targetoptions).encode()
            yield from _words_of_signature(value.py_func)
    elif isinstance(value, PLAIN):
        yield f"{type(value).__name__} {value!r}".encode()
    elif isinstance(value, np.ndarray):
        yield f"{value.dtype} {value.shape} {value.strides}".encode()
        yield value.tobytes()
    elif isinstance(value, (tuple, list, frozenset)):
        yield f"{_named(type(value))} {len(value)}".encode()
        for each in sorted(value, key=repr) if isinstance(value, frozenset) else value:
            yield from _words(each)
    elif isinstance(value, type):
        yield f"{_named(value)} {getattr(value, '_fields', None)}".encode()
        yield from _words(sorted(getattr(value, "_field_defaults", {}).items()))
    elif isinstance(value, (ModuleType, BuiltinFunctionType, np.ufunc)):
        name = value.__name__
        if name.partition(".")[0] == "softbody":
            raise UnknownValueError(f"{name} is a module: import what is used of it")
        yield f"{getattr(value, '__module__', None)} {name}".encode()
    elif hasattr(value, "__module__") and hasattr(value, "__name__"):
        yield f"{value.__module__}.{value.__name__}".encode()  # a function that Numba has a rule for
        yield _file_of(value.__module__)
    else:
        raise UnknownValueError(f"no words for {value!r}")


def name_of(function: Any, options: dict[str, Any]) -> str:
    """Return what the kernel of a function with Numba's options is called, in every process."""
    return f"{function.__module__}.{function.__qualname__} {sorted(options.items())}"


def _named(one: Any) -> str:
    return f"{one.__module__}.{one.__qualname__}"


@cache
def _file_of(module: str) -> bytes:
    """Return the hash of a module's file, if it is the core's; of others their version tells."""
    if module.partition(".")[0] != "softbody":
        return b""
    path = Path(inspect.getfile(__import__(module, fromlist=["_"])))
    return hashlib.sha256(path.read_bytes()).digest() if path.is_file() else source_digest().encode()
