"""No circle of imports in a package, and no reach into what another object keeps to itself.

Imports for type checking and within functions count, too.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("softbody", "references", "validation", "benchmarks", "reports")

PUBLIC_ALL_THE_SAME = {"_asdict", "_field_defaults", "_fields", "_make", "_replace"}  # of every NamedTuple
# A fault names the function that it damages; nothing is called there.
NAMES_OF_SOURCE = "Fault"
# What Python and other packages keep to themselves, and offer in no other form → why it is used.
NUMBAS = "softbody.compiler.compile_once, and what it imports, is about Numba's internals, and says for which versions"
ALLOWED = {
    "import _FunctionCompiler": NUMBAS,
    "self.part._numba_type_": NUMBAS,
    "library._reload_init": NUMBAS,
    "library._get_module_for_linking": NUMBAS,
    "other._values": NUMBAS,
    "codegen._library_class": NUMBAS,
    "CompileResult._rebuild": NUMBAS,
    "global_compiler_lock._lock": "its `acquire` is Python: what a handler raises in it leaves it locked",
    "view._getvalue": "the only way that Numba's extension API has to return a structure that an intrinsic has filled",
    "os._exit": "the documented end of a fork: no handler and no buffer of its parent's runs twice",
    "multiprocessing.current_process()._config": "daemons may have no children, and `daemon` cannot be set any more",
    "items[name]._initrequest": "how plug-ins of pytest make an item ready to be run again",
}


@cache
def trees(package: str) -> dict[str, tuple[bool, ast.Module]]:
    """Return by name each module's syntax tree, and whether it is a package itself."""
    found = {}
    for path in sorted((ROOT / package).rglob("*.py")):
        is_package = path.name == "__init__.py"
        parts = (path.parent if is_package else path.with_suffix("")).relative_to(ROOT).parts
        found[".".join(parts)] = is_package, ast.parse(path.read_text(encoding="utf-8"))
    return found


def imports(name: str, is_package: bool, tree: ast.Module, modules: set[str]) -> set[str]:
    """Return those of `modules` that a module names in its imports, itself apart."""
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            here = name.split(".") if is_package else name.split(".")[:-1]
            above = here[: len(here) - node.level + 1] if node.level else []
            source = ".".join([*above, *([node.module] if node.module else [])])
            for alias in node.names:
                inner = f"{source}.{alias.name}"
                found.add(inner if inner in modules else source)
    return (found & modules) - {name}


def circles(graph: dict[str, set[str]]) -> list[list[str]]:
    """Return one shortest way round for each knot of modules that reach each other."""
    reach = {start: reached_from(start, graph) for start in graph}
    left, found = set(graph), []
    while left:
        start = min(left)
        knot = {other for other in reach[start] if start in reach[other]} | {start}
        left -= knot
        if start in reach[start]:
            found.append(min((way_round(one, graph) for one in sorted(knot)), key=len))
    return found


def reached_from(start: str, graph: dict[str, set[str]]) -> set[str]:
    """Return what can be reached in one step or more."""
    reached: set[str] = set()
    waiting = [start]
    while waiting:
        new = graph[waiting.pop()] - reached
        reached |= new
        waiting += new
    return reached


def way_round(start: str, graph: dict[str, set[str]]) -> list[str]:
    """Return the shortest way from a module that lies on a circle back to it."""
    ways = [[start]]
    seen: set[str] = set()
    for way in ways:  # grows meanwhile
        for other in sorted(graph[way[-1]] - seen):
            if other == start:
                return [*way, start]
            seen.add(other)
            ways.append([*way, other])
    raise AssertionError(f"{start} lies on no circle")


def reaches(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield the line and the text of each reach into an underscore name of another object or module."""
    named = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == NAMES_OF_SOURCE
        for inner in ast.walk(node)
    }
    used = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and id(node) not in named}
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and is_private(node.attr):
            if id(node) not in named and not is_own(node.value):
                yield node.lineno, ast.unparse(node)
        elif isinstance(node, ast.ImportFrom):
            private = [alias.name for alias in node.names if is_private(alias.name)]
            yield from ((node.lineno, f"import {name}") for name in private if name in used or not named)


def is_private(name: str) -> bool:
    """Tell whether a name is kept by its owner to itself."""
    is_one = name.startswith("_") and not name.startswith("__")
    return is_one and name not in PUBLIC_ALL_THE_SAME


def is_own(owner: ast.expr) -> bool:
    """Tell whether it is the object or class itself that a method is of."""
    if isinstance(owner, ast.Call):
        return isinstance(owner.func, ast.Name) and owner.func.id == "super"
    return isinstance(owner, ast.Name) and owner.id in {"self", "cls"}


@pytest.mark.parametrize("package", PACKAGES)
def test_no_modules_import_each_other_in_a_circle(package: str) -> None:
    modules = trees(package)
    graph = {name: imports(name, *module, set(modules)) for name, module in modules.items()}
    found = [" → ".join(way) for way in circles(graph)]
    assert not found, "move what both need to a module that both import: " + "; ".join(found)


@pytest.mark.parametrize("package", PACKAGES)
def test_nothing_reaches_into_underscore_names_of_others(package: str) -> None:
    every = ((name, *reach) for name, (_, tree) in trees(package).items() for reach in reaches(tree))
    found = [f"{name}:{line}: {what}" for name, line, what in every if what not in ALLOWED]
    assert not found, "give what is reached for a public name:\n" + "\n".join(found)


def test_every_reach_that_is_allowed_is_made() -> None:
    made = {what for package in PACKAGES for _, tree in trees(package).values() for _, what in reaches(tree)}
    assert made >= ALLOWED.keys()


def test_circles_are_found_for_type_checking_and_within_functions() -> None:
    sources = {
        "p": "",
        "p.a": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from p.b import B",
        "p.b": "def f():\n    from . import c",
        "p.c": "import p.a",
        "p.d": "from p.a import A",
    }
    parsed = {name: imports(name, name == "p", ast.parse(text), set(sources)) for name, text in sources.items()}
    assert circles(parsed) == [["p.a", "p.b", "p.c", "p.a"]]


def test_reaches_are_told_from_what_is_ones_own() -> None:
    own = "self._a\ncls._b\nsuper()._c\nx._replace()\nx.__doc__\nFault('', m._d)"
    assert not list(reaches(ast.parse(own)))
    others = "from p import _e\nself.f._g\nh()._i"
    assert sorted(reaches(ast.parse(others))) == [(1, "import _e"), (2, "self.f._g"), (3, "h()._i")]
