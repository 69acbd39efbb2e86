"""Planted faults that are news: changed in the core where they are planted, or in what is said of them."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from pathlib import Path

from validation.check import CLAIMS, Check
from validation.damaged_core import ROOT
from validation.fault import Fault
from validation.mutation.revision import changed, definitions_in, sources_at, sources_now
from validation.mutation.sites import functions_of, what_it_does

CORE, CHECKS = "softbody", CLAIMS.replace(".", "/")  # the folders
JUDGED_BY = ("engines", "least", "tolerance", "unit")  # what a claim says of itself that decides whether it holds

Declaration = tuple[str, str, str]  # a claim's name, what it does, and a fault that it names


def changed_faults(checks: Mapping[str, Check], revision: str) -> set[Fault]:
    """Return the faults whose place, wording or claims are new or others since a revision.

    A place is a function, class or constant of the core. What has only moved to another file has not changed. Raises
    ValueError if Git does not know the revision.
    """
    places = changed(sources_at(revision, CORE, ROOT), sources_now(CORE, ROOT), definitions_in)
    edited = {(_module(path), name) for path, name in places}
    before, now = all_declarations(sources_at(revision, CHECKS, ROOT)), all_declarations(sources_now(CHECKS, ROOT))
    known = {each for said in before.values() for each in said}
    found = set()
    for check in checks.values():
        # (There is nothing of a plug-in, which is not ours.)
        said = now.get(f"{check.compare.__module__.replace('.', '/')}.py", [])
        here = [each for each in said if each[0] == check.compare.__name__]
        found |= {fault for fault, each in zip(check.faults, here) if each not in known}
        found |= {fault for fault in check.faults if fault.place in edited}
    return found


def all_declarations(sources: Mapping[str, str]) -> dict[str, list[Declaration]]:
    """Return what files of claims declare, by their paths; a fault may be named in one and used in another."""
    trees = {path: ast.parse(source) for path, source in sources.items()}
    elsewhere: dict[str, str] = {}
    for tree in trees.values():
        for name, wording in _named(tree).items():
            elsewhere[name] = elsewhere.get(name, "") + wording
    return {path: list(declarations(tree, elsewhere)) for path, tree in trees.items()}


def declarations(tree: ast.Module, elsewhere: Mapping[str, str]) -> Iterator[Declaration]:
    """Yield what a file of claims declares, claim by claim, and fault by fault in their order.

    `elsewhere`: the wordings of what is named in any file.
    """
    named = {**elsewhere, **_named(tree)}
    for name, function in functions_of(tree):
        for call in function.decorator_list:
            said = {each.arg: each.value for each in call.keywords} if isinstance(call, ast.Call) else {}
            faults = said.get("faults")
            if isinstance(faults, ast.Tuple):
                does = what_it_does(function) + "".join(ast.dump(said[each]) for each in JUDGED_BY if each in said)
                for fault in faults.elts:
                    known = named.get(fault.id, fault.id) if isinstance(fault, ast.Name) else _wording(fault)
                    yield name, does, known


def _named(tree: ast.Module) -> dict[str, str]:
    """Return the wordings of what a file gives names to."""
    return {
        node.targets[0].id: _wording(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)
    }


def _wording(node: ast.expr) -> str:
    """Return what a fault says, but for its place: a module that is named otherwise changes nothing."""
    if not isinstance(node, ast.Call):
        return ast.dump(node)
    return "".join(ast.dump(each) for k, each in enumerate([*node.args, *node.keywords]) if k != 1)


def _module(path: str) -> str:
    """Return the dotted name of a file's module."""
    return ".".join(Path(path).with_suffix("").parts).removesuffix(".__init__")
