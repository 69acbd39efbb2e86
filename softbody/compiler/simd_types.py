"""Eight reals as one Numba value: a vector of LLVM's. What each function means is said in `softbody.compiler.simd`."""

# ruff: noqa: D103 (a second docstring would have to be kept the same)

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic, lower_builtin, models, register_model, type_callable

LANES = 8


class LanesType(types.Type):
    """Numba's type of eight reals."""

    def __init__(self, real: types.Float) -> None:
        self.real = real
        super().__init__(f"Lanes({real})")


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    """One register, or several where a processor's are narrower."""

    def __init__(self, manager: Any, kind: LanesType) -> None:
        super().__init__(manager, kind, ir.VectorType(manager.lookup(kind.real).get_value_type(), LANES))


def _common_type(kinds: tuple[types.Type, ...]) -> LanesType | None:
    """Return the type of the lanes among the operands, if all the others are the same, or reals."""
    lanes = next((kind for kind in kinds if isinstance(kind, LanesType)), None)
    return lanes if all(kind == lanes or isinstance(kind, types.Float) for kind in kinds) else None


def _define(operation: Callable[[Any, Any], Any], instruction: str) -> None:
    """Teach Numba what an operator does with lanes."""

    @type_callable(operation)  # type: ignore[untyped-decorator]
    def resolve(context: Any) -> Callable[[types.Type, types.Type], LanesType | None]:
        def typer(a: types.Type, b: types.Type) -> LanesType | None:
            return _common_type((a, b))

        return typer

    def lower(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        vector = context.get_value_type(signature.return_type)
        return getattr(builder, instruction)(*(_in_all(builder, one, vector) for one in arguments))

    for operands in ((LanesType, LanesType), (LanesType, types.Float), (types.Float, LanesType)):
        lower_builtin(operation, *operands)(lower)


for _operation, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _define(_operation, _instruction)


def _in_all(builder: Any, value: Any, vector: ir.VectorType) -> Any:
    """Return `value`, rounded to their precision, in every lane, or what is in its lanes if it is a vector."""
    is_vector = isinstance(value.type, ir.VectorType)
    given, wanted = value.type.element if is_vector else value.type, vector if is_vector else vector.element
    if isinstance(vector.element, ir.FloatType) and isinstance(given, ir.DoubleType):
        value = builder.fptrunc(value, wanted)
    elif isinstance(vector.element, ir.DoubleType) and isinstance(given, ir.FloatType):
        value = builder.fpext(value, wanted)
    if is_vector:
        return value
    spread = ir.Constant(vector, ir.Undefined)
    for lane in range(LANES):
        spread = builder.insert_element(spread, value, _int(lane))
    return spread


def _int(value: int, bits: int = 32) -> ir.Constant:
    return ir.Constant(ir.IntType(bits), value)


def _first_of(context: Any, builder: Any, kind: types.Array, array: Any, i: Any) -> Any:
    """Return the pointer to entry i of an array, of eight that are there (which Numba's bounds checks make sure of)."""
    rows = context.make_array(kind)(context, builder, array)
    if context.enable_boundscheck:
        (length,) = cgutils.unpack_tuple(builder, rows.shape, 1)
        cgutils.do_boundscheck(context, builder, i, length)
        cgutils.do_boundscheck(context, builder, builder.add(i, _int(LANES - 1, 64)), length)
    return builder.gep(rows.data, [i])


def _is_row(array: types.Type, entry: Any = types.Float) -> bool:
    """Tell whether a type is that of arrays (n,) of reals, or of other kinds of entries, without gaps."""
    return isinstance(array, types.Array) and array.ndim == 1 and array.layout == "C" and isinstance(array.dtype, entry)


@intrinsic
def load_lanes(typing_context: Any, array: Any, i: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = signature.args[0]
        first = _first_of(context, builder, kind, *arguments)
        vector = context.get_value_type(signature.return_type)
        loaded = builder.load(builder.bitcast(first, vector.as_pointer()))
        loaded.align = kind.dtype.bitwidth // 8
        return loaded

    return (LanesType(array.dtype)(array, types.intp), generate) if _is_row(array) else None


@intrinsic
def store_lanes(typing_context: Any, array: Any, i: Any, lanes: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = signature.args[0]
        first = _first_of(context, builder, kind, *arguments[:2])
        value = _in_all(builder, arguments[2], context.get_value_type(LanesType(kind.dtype)))
        stored = builder.store(value, builder.bitcast(first, value.type.as_pointer()))
        stored.align = kind.dtype.bitwidth // 8
        return context.get_dummy_value()

    if _is_row(array) and isinstance(lanes, LanesType):
        return types.void(array, types.intp, lanes), generate
    return None


@intrinsic
def gather_lanes(typing_context: Any, array: Any, index: Any, i: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        gathered = ir.Constant(context.get_value_type(signature.return_type), ir.Undefined)
        # Single loads: the processor's own gather instruction is slower than they are (Zen 4 and 5: 16 against 12 ns).
        for lane, place in enumerate(_places(context, builder, signature, arguments)):
            gathered = builder.insert_element(gathered, builder.load(place), _int(lane))
        return gathered

    return (LanesType(array.dtype)(array, index, types.intp), generate) if _is_indexed(array, index) else None


def _is_indexed(array: types.Type, index: Any) -> bool:
    """Tell whether one type is that of reals, and the other of indices, as `gather_lanes` needs them."""
    return _is_row(array) and _is_row(index, types.Integer) and index.dtype == types.uint32


def _places(context: Any, builder: Any, signature: Any, arguments: Any) -> list[Any]:
    """Return pointers to the entries of an array that an index names, the first three arguments of `gather_lanes`."""
    rows = context.make_array(signature.args[0])(context, builder, arguments[0])
    first = _first_of(context, builder, signature.args[1], arguments[1], arguments[2])
    places = []
    for lane in range(LANES):
        place = builder.zext(builder.load(builder.gep(first, [_int(lane, 64)])), ir.IntType(64))
        if context.enable_boundscheck:
            (length,) = cgutils.unpack_tuple(builder, rows.shape, 1)
            cgutils.do_boundscheck(context, builder, place, length)
        places.append(builder.gep(rows.data, [place]))
    return places


@intrinsic
def scatter_lanes(typing_context: Any, array: Any, index: Any, i: Any, lanes: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        value = _in_all(builder, arguments[3], context.get_value_type(LanesType(signature.args[0].dtype)))
        for lane, place in enumerate(_places(context, builder, signature, arguments)):
            builder.store(builder.extract_element(value, _int(lane)), place)
        return context.get_dummy_value()

    if _is_indexed(array, index) and isinstance(lanes, LanesType):
        return types.void(array, index, types.intp, lanes), generate
    return None


@intrinsic
def spread(typing_context: Any, value: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _in_all(builder, arguments[0], context.get_value_type(signature.return_type))

    return (LanesType(value)(value), generate) if isinstance(value, types.Float) else None


@intrinsic
def square_root(typing_context: Any, lanes: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        vector = arguments[0].type
        name = f"llvm.sqrt.v{LANES}{vector.element.intrinsic_name}"
        root = cgutils.get_or_insert_function(builder.module, ir.FunctionType(vector, [vector]), name)
        return builder.call(root, arguments)

    return lanes(lanes), generate


@intrinsic
def where_less(typing_context: Any, a: Any, b: Any, yes: Any, no: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        vector = context.get_value_type(signature.return_type)
        a, b, yes, no = (_in_all(builder, one, vector) for one in arguments)
        return builder.select(builder.fcmp_ordered("<", a, b), yes, no)

    lanes = _common_type((a, b, yes, no))
    return None if lanes is None else (lanes(a, b, yes, no), generate)


@intrinsic
def bits_at_most(typing_context: Any, a: Any, b: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        vector = context.get_value_type(lanes)
        a, b = (_in_all(builder, one, vector) for one in arguments)
        bits = builder.bitcast(builder.fcmp_ordered("<=", a, b), ir.IntType(LANES))
        return builder.zext(bits, ir.IntType(64))

    lanes = _common_type((a, b))
    return None if lanes is None else (types.int64(a, b), generate)


@intrinsic
def lowest_bit(typing_context: Any, bits: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.cttz(arguments[0], _int(1, 1))

    return (types.int64(types.int64), generate) if isinstance(bits, types.Integer) else None


@intrinsic
def first_lanes(typing_context: Any, lanes: Any, number: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        value, count = arguments
        numbers = ir.VectorType(ir.IntType(64), LANES)
        counts = _in_all(builder, count, numbers)
        is_first = builder.icmp_signed("<", ir.Constant(numbers, list(range(LANES))), counts)
        return builder.select(is_first, value, ir.Constant(value.type, [0.0] * LANES))

    return lanes(lanes, types.intp), generate


@intrinsic
def in_double(typing_context: Any, lanes: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _in_all(builder, arguments[0], context.get_value_type(signature.return_type))

    return LanesType(types.float64)(lanes), generate


@intrinsic
def in_single(typing_context: Any, lanes: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _in_all(builder, arguments[0], context.get_value_type(signature.return_type))

    return LanesType(types.float32)(lanes), generate


@intrinsic
def least_lane(typing_context: Any, lanes: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        least, *others = (builder.extract_element(arguments[0], _int(lane)) for lane in range(LANES))
        for one in others:
            least = builder.select(builder.fcmp_ordered("<", one, least), one, least)
        return least

    return lanes.real(lanes), generate


@intrinsic
def sum_of_lanes(typing_context: Any, lanes: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        terms = [builder.extract_element(arguments[0], _int(lane)) for lane in range(LANES)]
        while len(terms) > 1:
            terms = [builder.fadd(a, b) for a, b in zip(terms[::2], terms[1::2])]
        return terms[0]

    return lanes.real(lanes), generate
