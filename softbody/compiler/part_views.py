"""A part of a row as one Numba value. What the function means is said in `softbody.compiler.parts`.

Numba would slice and then reshape: two calls, with errors that cannot happen, a hundred lines of LLVM's for each part.
"""

# ruff: noqa: D103 (a second docstring would have to be kept the same)

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import impl_ret_borrowed
from numba.extending import intrinsic


@intrinsic
def part_of(typing_context: Any, row: Any, spans: Any, part: Any, shape: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        whole, table = (context.make_array(one)(context, builder, each) for one, each in zip((row, spans), arguments))
        first, end = (_entry(context, builder, spans, table, [arguments[2], _size(column)]) for column in range(2))
        if context.enable_boundscheck:
            (length,) = cgutils.unpack_tuple(builder, whole.shape, 1)
            cgutils.do_boundscheck(context, builder, end, builder.add(length, _size(1)))
        sides = cgutils.unpack_tuple(builder, arguments[3])
        # Bytes from each entry to the next, along the last axis first.
        strides = [whole.itemsize]
        for side in reversed(sides):
            strides.insert(0, builder.mul(strides[0], side))
        entries = builder.sdiv(strides[0], whole.itemsize)
        view = context.make_array(signature.return_type)(context, builder)
        context.populate_array(
            view,
            data=builder.gep(whole.data, [first]),
            shape=[builder.sdiv(builder.sub(end, first), entries), *sides],
            strides=strides,
            itemsize=whole.itemsize,
            meminfo=whole.meminfo,
            parent=whole.parent,
        )
        return impl_ret_borrowed(context, builder, signature.return_type, view._getvalue())

    if not (_is_contiguous(row, 1) and _is_contiguous(spans, 2) and isinstance(shape, types.BaseTuple)):
        return None
    sides = types.UniTuple(types.intp, len(shape))
    return row.copy(ndim=1 + len(shape))(row, spans, types.intp, sides), generate


def _is_contiguous(array: Any, axes: int) -> bool:
    """Tell whether a type is that of arrays of as many axes, without gaps."""
    return isinstance(array, types.Array) and array.ndim == axes and array.layout == "C"


def _entry(context: Any, builder: Any, kind: Any, array: Any, place: list[Any]) -> Any:
    """Return an entry of an array (which is there, as Numba's bounds checks make sure)."""
    checked = context.enable_boundscheck
    return builder.load(cgutils.get_item_pointer(context, builder, kind, array, place, boundscheck=checked))


def _size(value: int) -> ir.Constant:
    return ir.Constant(ir.IntType(64), value)
