"""Switch that wakes one damage and notes which was reached. Copied into a damaged core as `softbody/switch.py`.

Kernels read and write two places of the process, which their machine code, also that from the disk, knows by name.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import llvmlite.binding
from llvmlite import ir
from numba.core import types
from numba.extending import lower_builtin, type_callable

MOST = 1 << 16  # damages in one core
AWAKE = ctypes.c_int64(-1)
REACHED = (ctypes.c_int8 * MOST)()
AWAKE_SYMBOL, REACHED_SYMBOL = "softbody_awake", "softbody_reached"
llvmlite.binding.add_symbol(AWAKE_SYMBOL, ctypes.addressof(AWAKE))
llvmlite.binding.add_symbol(REACHED_SYMBOL, ctypes.addressof(REACHED))


def is_awake(number: int) -> bool:
    """Tell whether a damage, a fault or a mutant, is the one that is awake."""
    return bool(AWAKE.value == number)


def noted_awake(number: int) -> bool:
    """Tell the same, and note that the damage was reached: kernels take twice as long to compile."""
    REACHED[number] = 1
    return is_awake(number)


@type_callable(is_awake)  # type: ignore[untyped-decorator]
@type_callable(noted_awake)  # type: ignore[untyped-decorator]
def _resolve(context: Any) -> Callable[[Any], Any]:
    return lambda number: types.boolean


@lower_builtin(is_awake, types.Integer)  # type: ignore[untyped-decorator]
def _generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    awake = _place(builder.module, ir.IntType(64), AWAKE_SYMBOL)
    return builder.icmp_signed("==", builder.load(awake), _number(builder, arguments))


@lower_builtin(noted_awake, types.Integer)  # type: ignore[untyped-decorator]
def _generate_noted(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    reached = _place(builder.module, ir.ArrayType(ir.IntType(8), MOST), REACHED_SYMBOL)
    start = ir.Constant(ir.IntType(64), 0)
    builder.store(ir.Constant(ir.IntType(8), 1), builder.gep(reached, [start, _number(builder, arguments)]))
    return _generate(context, builder, signature, arguments)


def _number(builder: Any, arguments: Any) -> Any:
    return builder.sext(arguments[0], ir.IntType(64)) if arguments[0].type.width < 64 else arguments[0]


def _place(module: Any, kind: Any, symbol: str) -> Any:
    return module.globals[symbol] if symbol in module.globals else ir.GlobalVariable(module, kind, symbol)
