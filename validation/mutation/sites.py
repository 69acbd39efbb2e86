"""Sites where a module of the core can be mutated, and into what: every operator's, in order.

A mutant is one small change of the syntax tree inside one function: an operator, a comparison, a condition, a sign, a
number, an index, the order of arguments or answers, a statement that is left out. What is made keeps its type as far as
the tree tells, so that kernels with it compile. No sites: what Numba decides while it compiles (`is None`), texts,
`raise` and all that it says, annotations, defaults, and constants of modules where they are defined (they are mutated
where they are used). Sums that only change their order, such as swapped arguments of `add`, are no mutants.
"""

from __future__ import annotations

import ast
import copy
import hashlib
import inspect
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any


@dataclass(frozen=True)
class Mutant:
    """One change of one function; `key` stays when lines are moved, or other functions are changed."""

    file: str  # below the core's folder, such as "collision/law.py"
    function: str  # dotted, for a method
    operator: str
    before: str  # source
    after: str  # source; empty where a statement is left out
    line: int
    occurrence: int = 0  # of the same change in the same function, from 0 on
    text: str = ""  # digest of what its function does

    @property
    def key(self) -> str:
        """What names this mutant in records and among those that are explained."""
        change = f"{self.before} -> {self.after or 'nothing'}"
        return f"{self.file}:{self.function}: {change}" + (f" #{self.occurrence}" if self.occurrence else "")

    @property
    def identity(self) -> str:
        """What another mutant has once its function does something else."""
        return f"{self.key} @{self.text}"


Found = tuple[str, ast.AST, "ast.AST | None"]  # the operator's name, a node, and what takes its place, if anything

ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.FloorDiv,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
}
OPPOSITE: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
}
COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
TWINS = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum", "any": "all", "all": "any"}
VECTORS = {"add": "mutant_sub", "sub": "mutant_add"}  # of softbody.linalg.vec: sums of 3-vectors are calls
SYMMETRIC = {"add", "dot", "multiply", "min", "max", "combined"}  # swapped arguments change no bit
ALIKE = {"float", "int", "Vec", "Quaternion"}  # types of which two arguments or answers may change places


def mutants_in(
    file: str, tree: ast.Module, names: Mapping[str, Any]
) -> Iterator[tuple[Mutant, ast.AST, ast.AST | None]]:
    """Yield every mutant of a module's tree, the node that changes, and what takes its place; None: nothing does.

    `names` are those of the module, imported: they tell which names are numbers, and what functions take.
    """
    seen: Counter[Mutant] = Counter()
    for name, function in functions_of(tree):
        text = digest_of(what_it_does(function))
        for operator, node, put in _Sites(function, names).found():
            after = "" if put is None else _source(put)
            one = Mutant(file, name, operator, _source(node), after.replace("mutant_", ""), 0, text=text)
            if one.before == one.after:
                continue
            yield replace(one, line=getattr(node, "lineno", 0), occurrence=seen[one]), node, put
            seen[one] += 1


def functions_of(tree: ast.AST, prefix: str = "") -> Iterator[tuple[str, ast.FunctionDef]]:
    """Yield the functions and methods of a module with their dotted names; what is inside one belongs to it."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef):
            yield prefix + node.name, node
        elif isinstance(node, ast.ClassDef):
            yield from functions_of(node, f"{prefix}{node.name}.")
        elif isinstance(node, (ast.If, ast.Try)):
            yield from functions_of(node, prefix)


def what_it_does(function: ast.FunctionDef) -> str:
    """Return a text that is another one when a function does something else, whatever its docstring says."""
    first = 1 if ast.get_docstring(function) is not None else 0
    return ast.dump(function.args) + "".join(ast.dump(each) for each in function.body[first:])


def digest_of(text: str) -> str:
    """Return what is another text once a text has changed."""
    return hashlib.sha256(text.encode()).hexdigest()[:8]


def _source(node: ast.AST) -> str:
    return ast.unparse(node)


class _Sites:
    """The sites of one function."""

    def __init__(self, function: ast.FunctionDef, names: Mapping[str, Any]) -> None:
        self._function = function
        self._names = names
        self._whole = _whole_names(function)

    def found(self) -> Iterator[Found]:
        """Yield them, top to bottom."""
        body = self._function.body
        first = 1 if ast.get_docstring(self._function) is not None else 0
        assigned = {each.arg for each in ast.walk(self._function.args) if isinstance(each, ast.arg)}
        for statement in body[first:]:
            yield from self._statement(statement, assigned)

    def _statement(self, node: ast.stmt, assigned: set[str]) -> Iterator[Found]:
        """Yield the sites of a statement; `assigned` are names that have a value before it, and gains its own."""
        if isinstance(node, (ast.Raise, ast.Assert, ast.Import, ast.ImportFrom, ast.Pass)):
            if isinstance(node, ast.Raise):
                yield "statement left out", node, None
            return
        if isinstance(node, (ast.If, ast.While)):
            yield from self._condition(node.test)
        if isinstance(node, (ast.Break, ast.Continue)):
            yield "statement left out", node, None
        if isinstance(node, ast.AugAssign):
            yield "statement left out", node, None
            other: type[ast.operator] | None = OPPOSITE.get(type(node.op))
            if other is ast.Div and self._is_whole(node.target):
                other = None
            if other is not None and not _is_text(node.value):
                yield "arithmetic", node, _with(node, op=other())
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            yield "statement left out", node, None
        if isinstance(node, ast.Assign) and len(node.targets) == 1:
            target = node.targets[0]
            again = isinstance(target, ast.Name) and target.id in assigned
            stored = isinstance(target, (ast.Subscript, ast.Attribute)) and self._function.name != "__init__"
            if again or stored:
                yield "statement left out", node, None
        if isinstance(node, ast.Return) and isinstance(node.value, ast.Tuple):
            yield from self._swapped_answers(node.value)
        for field in node._fields:
            value = getattr(node, field)
            if isinstance(node, ast.AnnAssign) and field == "annotation":
                continue
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.stmt):
                    yield from self._statement(child, assigned)
                elif isinstance(child, ast.expr) and not (
                    isinstance(getattr(child, "ctx", None), ast.Store) and isinstance(child, (ast.Name, ast.Tuple))
                ):
                    yield from self._expression(child)
                elif isinstance(child, ast.withitem):
                    yield from self._expression(child.context_expr)
        assigned |= {
            each.id for each in ast.walk(node) if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)
        }

    def _condition(self, test: ast.expr) -> Iterator[Found]:
        opposite = isinstance(test, ast.Compare) and isinstance(test.ops[0], (ast.Eq, ast.NotEq, ast.In, ast.NotIn))
        if not (_is_settled(test) or opposite or isinstance(test, (ast.UnaryOp, ast.Constant))):
            yield "condition negated", test, ast.UnaryOp(ast.Not(), copy.deepcopy(test))

    def _expression(self, node: ast.expr) -> Iterator[Found]:
        """Yield the sites of an expression, from outside to inside."""
        if isinstance(node, (ast.JoinedStr, ast.Lambda)) or _is_settled(node):
            return
        if isinstance(node, ast.BinOp):
            yield from self._arithmetic(node)
        elif isinstance(node, ast.Compare):
            for k, each in enumerate(node.ops):
                if type(each) in COMPARISONS:
                    ops = [*node.ops[:k], COMPARISONS[type(each)](), *node.ops[k + 1 :]]
                    yield "comparison", node, _with(node, ops=ops)
        elif isinstance(node, ast.BoolOp):
            yield "and, or", node, _with(node, op=ast.Or() if isinstance(node.op, ast.And) else ast.And())
        elif isinstance(node, ast.IfExp):
            yield from self._condition(node.test)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.Not)):
            yield "sign" if isinstance(node.op, ast.USub) else "condition negated", node, copy.deepcopy(node.operand)
        elif isinstance(node, ast.Constant):
            yield from _number(node, node.value)
        elif isinstance(node, ast.Name):
            value = self._names.get(node.id)
            if node.id.strip("_").isupper() and isinstance(value, (int, float)) and not isinstance(value, bool):
                yield from _constant(node, value)
        elif isinstance(node, ast.Call):
            yield from self._call(node)
        elif isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Load):
            yield from _index(node)
            yield from self._expression(node.value)
            for child in _entries(node.slice):
                if not isinstance(child, ast.Constant) and not (isinstance(child, ast.Slice) and _is_shape(node.value)):
                    yield from self._expression(child)
            return
        for child in _inner(node):
            yield from self._expression(child)

    def _arithmetic(self, node: ast.BinOp) -> Iterator[Found]:
        if any(_is_text(side) or isinstance(side, (ast.Tuple, ast.List)) for side in (node.left, node.right)):
            return
        other: type[ast.operator] | None = ARITHMETIC.get(type(node.op))
        if isinstance(node.op, ast.Mult):
            other = ast.Add if self._is_whole(node.left) or self._is_whole(node.right) else ast.Div
        if other is not None:
            yield "arithmetic", node, _with(node, op=other())

    def _call(self, node: ast.Call) -> Iterator[Found]:
        name = node.func.id if isinstance(node.func, ast.Name) else getattr(node.func, "attr", "")
        if name in TWINS:
            func = copy.deepcopy(node.func)
            setattr(func, "id" if isinstance(func, ast.Name) else "attr", TWINS[name])
            yield "min, max", node, _with(node, func=func)
        called = self._names.get(name) if isinstance(node.func, ast.Name) else None
        function = getattr(called, "py_func", called)
        if name in VECTORS and getattr(function, "__module__", "") == "softbody.linalg.vec":
            yield "arithmetic", node, _with(node, func=ast.Name(VECTORS[name], ast.Load()))
        if name not in SYMMETRIC and inspect.isfunction(function) and not node.keywords:
            kinds = [one.annotation for one in inspect.signature(function).parameters.values()]
            # (Arguments beyond those that have a name are of one kind, and there is no telling which.)
            for k, (one, two) in enumerate(zip(node.args[: len(kinds)], node.args[1 : len(kinds)])):
                if kinds[k] == kinds[k + 1] and kinds[k] in ALIKE and _source(one) != _source(two):
                    yield "arguments swapped", node, _with(node, args=[*node.args[:k], two, one, *node.args[k + 2 :]])

    def _swapped_answers(self, node: ast.Tuple) -> Iterator[Found]:
        returns = self._function.returns
        kinds: list[str] = []
        if isinstance(returns, ast.Name) and returns.id in ("Vec", "Quaternion"):
            kinds = ["float"] * len(node.elts)
        elif isinstance(returns, ast.Subscript) and isinstance(returns.slice, ast.Tuple):
            kinds = [_source(each) for each in returns.slice.elts]
        for k, (one, two) in enumerate(zip(node.elts, node.elts[1:])):
            if (
                kinds[k : k + 1] == kinds[k + 1 : k + 2]
                and kinds
                and kinds[k] in ALIKE
                and _source(one) != _source(two)
            ):
                yield "answers swapped", node, _with(node, elts=[*node.elts[:k], two, one, *node.elts[k + 2 :]])

    def _is_whole(self, node: ast.AST) -> bool:
        """Tell whether an expression is a whole number, as far as the tree tells."""
        if isinstance(node, ast.Constant):
            return isinstance(node.value, int)
        if isinstance(node, ast.Name):
            known = self._names.get(node.id)
            return node.id in self._whole or (node.id.strip("_").isupper() and isinstance(known, int))
        if isinstance(node, ast.BinOp):
            return not isinstance(node.op, ast.Div) and (self._is_whole(node.left) or self._is_whole(node.right))
        if isinstance(node, ast.Subscript):
            return isinstance(node.value, ast.Attribute) and node.value.attr == "shape"
        return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("len", "int")


def _whole_names(function: ast.FunctionDef) -> set[str]:
    """Return names of a function that are whole numbers: such arguments, and what counts, is counted to, or indexes."""
    names = {
        each.arg
        for each in ast.walk(function.args)
        if isinstance(each, ast.arg) and each.annotation is not None and _source(each.annotation) == "int"
    }
    for node in ast.walk(function):
        if isinstance(node, ast.Call) and _source(node.func) in ("range", "prange"):
            names |= {each.id for counted in node.args for each in _plain_names(counted)}
        if isinstance(node, ast.Subscript):
            names |= {each.id for each in _plain_names(node.slice)}
        if isinstance(node, ast.For) and isinstance(node.iter, ast.Call) and isinstance(node.target, ast.Name):
            names.add(node.target.id)
        value = node.value if isinstance(node, ast.Assign) else None
        if isinstance(value, ast.BinOp) and isinstance(value.op, (ast.FloorDiv, ast.Mod)):
            names |= {each.id for target in node.targets for each in ast.walk(target) if isinstance(each, ast.Name)}  # type: ignore[attr-defined]
        if isinstance(value, ast.Subscript) and _source(value.value).endswith(".shape"):
            names |= {each.id for target in node.targets for each in ast.walk(target) if isinstance(each, ast.Name)}  # type: ignore[attr-defined]
    return names


def _plain_names(node: ast.expr) -> Iterator[ast.Name]:
    """Yield the names that an expression is computed from, but for what is looked up or called with them."""
    if isinstance(node, ast.Name):
        yield node
    elif not isinstance(node, (ast.Subscript, ast.Call, ast.Attribute)):
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.expr):
                yield from _plain_names(child)


def _inner(node: ast.expr) -> Iterator[ast.expr]:
    """Yield the expressions that an expression is made of, but for names of functions, arguments and types."""
    if isinstance(node, ast.Slice):
        yield from (each for each in (node.lower, node.upper, node.step) if each is not None)
        return
    for field, value in ast.iter_fields(node):
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.keyword):
                if child.arg not in ("dtype", "axis", "stacklevel", "keepdims"):
                    yield child.value
            elif isinstance(child, ast.comprehension):
                yield child.iter
                yield from child.ifs
            elif isinstance(child, ast.expr) and not (
                isinstance(node, ast.Call) and field == "func" and _is_name(child)
            ):
                yield child


def _is_name(node: ast.expr) -> bool:
    return isinstance(node, ast.Name)


def _is_settled(node: ast.expr) -> bool:
    """Tell whether a condition asks what Numba must know when it compiles: whether it is None, and its type."""
    for each in ast.walk(node):
        if isinstance(each, ast.Compare) and any(isinstance(op, (ast.Is, ast.IsNot)) for op in each.ops):
            return isinstance(node, (ast.Compare, ast.BoolOp, ast.UnaryOp))
        if isinstance(each, ast.Call) and isinstance(each.func, ast.Name) and each.func.id in ("isinstance", "hasattr"):
            return isinstance(node, (ast.Call, ast.BoolOp, ast.UnaryOp))
    return False


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, (str, bytes)))


def _number(node: ast.Constant, value: object) -> Iterator[Found]:
    """Yield what a number becomes: 0 ↔ 1, whole numbers one more, and reals one per cent more."""
    if isinstance(value, bool):
        yield "number", node, ast.Constant(not value)
    elif isinstance(value, int):
        yield "number", node, ast.Constant(value + 1 if value != 1 else 0)
    elif isinstance(value, float):
        yield "number", node, ast.Constant(1.0 if value == 0.0 else value * 1.01)


def _index(node: ast.Subscript) -> Iterator[Found]:
    """Yield what becomes of `a[1]` and `a[i, 1]`: the entry before, and of the first one the second.

    The whole of `a[1]` changes: of a tuple Numba wants an index that is known when it compiles.
    """
    if _is_shape(node.value):
        return
    entries = _entries(node.slice)
    for k, entry in enumerate(entries):
        if isinstance(entry, ast.Constant) and type(entry.value) is int:
            other = ast.Constant(entry.value - 1 if entry.value > 0 else 1)
            several = ast.Tuple([*entries[:k], other, *entries[k + 1 :]], ast.Load())
            yield "index", node, _with(node, slice=several if len(entries) > 1 else other)


def _is_shape(node: ast.expr) -> bool:
    """Tell whether this is the shape of an array, a tuple of which Numba wants to know the length."""
    return _source(node).endswith("shape")


def _entries(index: ast.expr) -> list[ast.expr]:
    """Return the entries of an index."""
    return index.elts if isinstance(index, ast.Tuple) else [index]


def _constant(node: ast.Name, value: float) -> Iterator[Found]:
    factor: ast.expr = ast.Constant(1) if isinstance(value, int) else ast.Constant(1.01)
    operator: ast.operator = ast.Add() if isinstance(value, int) else ast.Mult()
    yield "number", node, ast.BinOp(ast.Name(node.id, ast.Load()), operator, factor)


def _with(node: Any, **fields: Any) -> Any:
    """Return a copy of a node with other fields."""
    return type(node)(
        **{name: copy.deepcopy(fields.get(name, getattr(node, name, None))) for name in node._fields},
    )
