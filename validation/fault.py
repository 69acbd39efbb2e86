"""What a planted fault is: a function of the core, and a change of its syntax tree, that must turn a claim red.

A change is a pattern and what takes its place, both Python. In a pattern a name that ends in "_" stands for anything,
and for the same thing wherever it comes again; everything else stands for itself. So what a fault says does not depend
on the core's layout, and seldom on the names of variables; a function that is renamed is renamed here with it.
"""

from __future__ import annotations

import ast
import copy
import textwrap
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from validation.damaged_core import add_imports

ARROW = " → "


@dataclass(frozen=True)
class Fault:
    """A change of `where`, written "find → put": the first match of `find`, or that of number `nth`, becomes `put`.

    `where` is a function or class of the core, or the dotted name of one of its constants. `find` and `put` are
    expressions or statements; `put` may be empty where `find` is a statement: it is left out.
    """

    name: str  # in words, such as "friction off by 1 %"
    where: Callable[..., Any] | str
    change: str
    nth: int = 0

    def __post_init__(self) -> None:
        """Raise ValueError for a change without an arrow."""
        if self.change.count(ARROW) != 1:
            raise ValueError(f"{self.name!r} changes {self.change!r}: write what is found{ARROW}what takes its place")

    @property
    def find(self) -> str:
        """What is looked for: Python, in which a name that ends in "_" stands for anything."""
        return self.change.partition(ARROW)[0]

    @property
    def put(self) -> str:
        """What takes its place; empty where it is left out."""
        return self.change.partition(ARROW)[2]

    @property
    def place(self) -> tuple[str, str]:
        """The module, dotted, and the name in it, dotted for a method."""
        if isinstance(self.where, str):
            module, _, name = self.where.rpartition(".")
            return module, name
        function = getattr(self.where, "py_func", self.where)
        return function.__module__, function.__qualname__

    @property
    def has_switch(self) -> bool:
        """Whether it may be in a compiled core and asleep: a constant is compiled into kernels."""
        return not isinstance(self.where, str)


def plant(fault: Fault, core: Path) -> None:
    """Damage the copy of the core that is the folder `core`; raises ValueError as `damaged` does."""
    path = _file(fault, core)
    path.write_text(damaged(fault, path.read_text(encoding="utf-8")), encoding="utf-8")


def plant_switched(faults: Mapping[int, Fault], core: Path) -> None:
    """Plant faults in the copy of the core that is the folder `core`, each asleep behind the switch of its number.

    So they are all compiled at once. Raises ValueError as `damaged` does.
    """
    by_file: dict[Path, dict[int, Fault]] = {}
    for number, fault in faults.items():
        by_file.setdefault(_file(fault, core), {})[number] = fault
    for path, here in by_file.items():
        path.write_text(switched(here, path.read_text(encoding="utf-8")), encoding="utf-8")


def damaged(fault: Fault, source: str) -> str:
    """Return the source of the fault's module with the fault in it.

    Raises ValueError, naming the fault, if there is no such place or it is as sound afterwards.
    """
    tree = ast.parse(source)
    _exchange(tree, *_change(fault, tree))
    return ast.unparse(ast.fix_missing_locations(tree)) + "\n"


def switched(faults: Mapping[int, Fault], source: str) -> str:
    """Return the source of a module with all its faults in it, each behind a switch; raises ValueError as `damaged`."""
    tree = ast.parse(source)
    changes = [(number, *_change(fault, tree)) for number, fault in faults.items()]
    for number, sound, broken in sorted(changes, key=lambda change: -len(change[1])):  # the larger around the smaller
        test = ast.parse(f"is_awake({number})", mode="eval").body
        if isinstance(sound[0], ast.expr):
            switch: ast.AST = ast.IfExp(test, broken[0], sound[0])
        else:
            switch = ast.If(test, broken, sound)
        _exchange(tree, sound, [switch])
    add_imports(tree, "from softbody.switch import is_awake")
    return ast.unparse(ast.fix_missing_locations(tree)) + "\n"


def _file(fault: Fault, core: Path) -> Path:
    """Return the file of the fault's module, in a copy of the core."""
    path = core.joinpath(*fault.place[0].split(".")[1:])
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


def _change(fault: Fault, tree: ast.Module) -> tuple[list[Any], list[Any]]:
    """Return the nodes of a tree that a fault is about, one expression or a row of statements, and what they become."""
    scope = _definition(tree, fault.place[1].split("."))
    if scope is None:
        raise ValueError(f"{fault.name!r}: there is no {'.'.join(fault.place)}; name the function that it is in now")
    pattern, replacement = _statements(fault.find), _statements(fault.put)
    if _is_expression(pattern) and _is_expression(replacement):
        pattern, replacement = [pattern[0].value], [replacement[0].value]
    match = next(islice(_matches(scope, pattern), fault.nth, None), None)
    if match is None:
        raise ValueError(f"{fault.name!r}: {'.'.join(fault.place)} holds no {fault.find!r}; plant the fault elsewhere")
    sound, found = match
    broken = [_Fill(found).visit(copy.deepcopy(node)) for node in replacement] or [ast.Pass()]
    if [ast.dump(node) for node in broken] == [ast.dump(node) for node in sound]:
        raise ValueError(f"{fault.name!r} changes nothing: {fault.find!r} is first met where it is {fault.put!r}")
    return sound, broken


def _exchange(tree: ast.AST, old: list[Any], new: list[Any]) -> None:
    """Put nodes in place of others, which stand in the tree in this order."""
    for holder in ast.walk(tree):
        for field, value in ast.iter_fields(holder):
            if value is old[0]:
                setattr(holder, field, new[0])
                return
            for k, node in enumerate(value if isinstance(value, list) else ()):
                if node is old[0]:
                    value[k : k + len(old)] = new
                    return


def _definition(tree: ast.AST, path: list[str]) -> ast.AST | None:
    """Return the function, class or assignment of a dotted name."""
    for part in path:
        for node in ast.iter_child_nodes(tree):
            stored = [each for each in ast.walk(node) if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)]
            names = [each.id for each in stored] if isinstance(node, ast.Assign) else [getattr(node, "name", None)]
            if part in names:
                tree = node
                break
        else:
            return None
    return tree


def _statements(source: str) -> list[Any]:
    return list(ast.parse(textwrap.dedent(source)).body)


def _is_expression(code: list[Any]) -> bool:
    return len(code) == 1 and isinstance(code[0], ast.Expr)


def _matches(scope: ast.AST, pattern: list[Any]) -> Iterator[tuple[list[Any], dict[str, ast.AST]]]:
    """Yield what matches the pattern, top to bottom: the nodes, and what names stand for."""
    for _, value in ast.iter_fields(scope):
        rows = value if isinstance(value, list) else [value]
        for index, node in enumerate(rows):
            if not isinstance(node, ast.AST):
                continue
            found: dict[str, ast.AST] = {}
            if _same(pattern, rows[index : index + len(pattern)], found):
                yield rows[index : index + len(pattern)], found
            yield from _matches(node, pattern)


def _same(pattern: Any, node: Any, found: dict[str, ast.AST]) -> bool:
    """Tell whether a tree is the pattern, with names that stand for something; notes in `found` what they stand for."""
    if isinstance(pattern, ast.Name) and pattern.id.endswith("_"):
        return isinstance(node, ast.expr) and ast.unparse(found.setdefault(pattern.id, node)) == ast.unparse(node)
    if isinstance(pattern, ast.AST):
        fields = [field for field in pattern._fields if field != "ctx"]
        return type(pattern) is type(node) and all(_same(getattr(pattern, f), getattr(node, f), found) for f in fields)
    if isinstance(pattern, list) and isinstance(node, list):
        return len(pattern) == len(node) and all(_same(a, b, found) for a, b in zip(pattern, node))
    return type(pattern) is type(node) and bool(pattern == node)


class _Fill(ast.NodeTransformer):
    """Puts in place of names what they stand for."""

    def __init__(self, found: dict[str, ast.AST]) -> None:
        self.found = found

    def visit_Name(self, node: ast.Name) -> ast.AST:
        return copy.deepcopy(self.found.get(node.id, node))
