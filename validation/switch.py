"""Which planted fault is awake? Copied into a damaged core as `softbody/switch.py`, whose kernels ask as they run."""

from __future__ import annotations

import ctypes
import os
from typing import Any

import llvmlite.binding
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic, overload

NUMBER = ctypes.c_int64(int(os.environ.get("SOFTBODY_FAULT", "-1")))
SYMBOL = "softbody_fault"
llvmlite.binding.add_symbol(SYMBOL, ctypes.addressof(NUMBER))  # machine code that is kept on disk finds it by its name


def is_planted(fault: int) -> bool:
    """Tell whether a fault is the one that is awake."""
    return bool(NUMBER.value == fault)


@overload(is_planted, inline="always")
def _is_planted_in_kernels(fault):  # type: ignore[no-untyped-def]  # Numba wants the signature of what it returns
    return lambda fault: _number() == fault  # type: ignore[call-arg]


@intrinsic
def _number(typing_context: Any) -> Any:  # type: ignore[misc]
    """Read NUMBER."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        module = builder.module
        known = SYMBOL in module.globals
        cell = module.globals[SYMBOL] if known else ir.GlobalVariable(module, ir.IntType(64), SYMBOL)
        return builder.load(cell)

    return types.int64(), generate
