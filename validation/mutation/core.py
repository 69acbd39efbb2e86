"""A copy of the core with many mutants in it, each asleep behind a switch, so that all are compiled at once."""

from __future__ import annotations

import ast
import importlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from validation.damaged_core import ROOT, add_imports, copy_core
from validation.mutation.sites import Mutant, mutants_in

# Not mutated, and why.
LEFT_OUT = {
    "compiler/jit.py": "how kernels are compiled",
    "compiler/compile_once.py": "how kernels are compiled",
    "compiler/plain_numba.py": "how kernels are compiled",
    "compiler/cache_file.py": "how machine code is kept",
    "compiler/core_cache.py": "how machine code is kept",
    "compiler/core_digest.py": "how machine code is kept",
    "compiler/shipped_code.py": "how machine code is kept",
    "compiler/notice.py": "what is said while kernels are compiled",
    "compiler/simd.py": "the interpreted form of lanes, which no kernel that is compiled runs",
    "compiler/simd_types.py": "writes LLVM's code while kernels are compiled, before a switch can be thrown",
    "compiler/threads.py": "how long threads sleep",
    "render/": "what pictures look like is a matter of taste, and tests see the rest",
    "view/": "what is on the screen moves nothing, and tests see what its controls do",
    "extras.py": "which libraries there are",
    "cli/warmup.py": "compiles ahead of time; computes nothing",
    "__main__.py": "the command line",
    "scenes/": "their numbers are a matter of taste",
}


def is_left_out(file: str) -> bool:
    """Tell whether a file, below the core's folder, is not mutated."""
    return any(file == each or (each.endswith("/") and file.startswith(each)) for each in LEFT_OUT)


def all_mutants(core: Path = ROOT / "softbody") -> Iterator[Mutant]:
    """Yield every mutant of the core, file by file."""
    for path in sorted(core.rglob("*.py")):
        file = path.relative_to(core).as_posix()
        if not is_left_out(file):
            for mutant, _, _ in mutants_in(file, ast.parse(path.read_text(encoding="utf-8")), names_of(file)):
                yield mutant


def names_of(file: str) -> Mapping[str, Any]:
    """Return the names of a module of the core."""
    module = ".".join(("softbody", *Path(file).with_suffix("").parts)).removesuffix(".__init__")
    return vars(importlib.import_module(module))


def write_core(mutants: Mapping[int, Mutant], folder: Path) -> None:
    """Make `folder`/softbody a copy of the core with numbered mutants in it, all asleep.

    Raises ValueError for a mutant that the core has no place for.
    """
    core = copy_core(folder)
    by_file: dict[str, dict[str, int]] = {}
    for number, mutant in mutants.items():
        by_file.setdefault(mutant.file, {})[mutant.key] = number
    for file, numbers in by_file.items():
        path = core / file
        path.write_text(mutated(file, path.read_text(encoding="utf-8"), numbers, names_of(file)), encoding="utf-8")


def mutants_at(folder: Path, file: str, line: int) -> set[int]:
    """Return the numbers of the mutants in a line of a mutated core, or, if it has none, of its function."""
    tree = ast.parse((folder / "softbody" / file).read_text(encoding="utf-8"))
    around = [node for node in ast.walk(tree) if isinstance(node, ast.stmt) and _spans(node, line)]
    around.sort(key=lambda node: (node.end_lineno or 0) - node.lineno)
    for node in around:  # from the smallest on
        numbers = {
            call.args[0].value
            for call in ast.walk(node)
            if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "noted_awake"
            if isinstance(call.args[0], ast.Constant)
        }
        if numbers:
            return numbers  # type: ignore[return-value]
    return set()


def _spans(node: ast.stmt, line: int) -> bool:
    return node.lineno <= line <= (node.end_lineno or node.lineno)


def mutated(file: str, source: str, numbers: Mapping[str, int], names: Mapping[str, Any]) -> str:
    """Return the source of a module with mutants in it, by key and number, each behind its switch.

    Raises ValueError for a key of which there is no mutant.
    """
    tree = ast.parse(source)
    changes: dict[int, list[tuple[int, ast.AST | None]]] = {}
    known = set()
    for mutant, node, put in mutants_in(file, tree, names):
        if mutant.key in numbers:
            changes.setdefault(id(node), []).append((numbers[mutant.key], put))
            known.add(mutant.key)
    lost = next(iter(numbers.keys() - known), None)
    if lost is not None:
        raise ValueError(f"there is no such mutant: {lost}")
    tree = _Switches(changes).visit(tree)
    add_imports(tree, *_imports(tree))
    return ast.unparse(ast.fix_missing_locations(tree)) + "\n"


class _Switches(ast.NodeTransformer):
    """Puts a switch in place of each node that changes."""

    def __init__(self, changes: Mapping[int, list[tuple[int, ast.AST | None]]]) -> None:
        self._changes = changes

    def visit(self, node: ast.AST) -> Any:
        """Return the node with the switches inside it, and around it its own."""
        changes = self._changes.get(id(node), [])
        result: Any = self.generic_visit(node)
        for number, put in changes:
            test = ast.Call(ast.Name("noted_awake", ast.Load()), [ast.Constant(number)], [])
            if isinstance(node, ast.stmt):
                result = ast.If(test, [put or ast.Pass()], [result])  # type: ignore[list-item]
            else:
                result = ast.IfExp(test, put, result)  # type: ignore[arg-type]
        return result


def _imports(tree: ast.Module) -> Iterator[str]:
    used = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    yield "from softbody.switch import noted_awake"
    for name in ("add", "sub"):
        if f"mutant_{name}" in used:
            yield f"from softbody.linalg.vec import {name} as mutant_{name}"
