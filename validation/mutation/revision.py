"""Contents of the repository at a revision, and what reads differently since, wherever it stands now."""

from __future__ import annotations

import ast
import copy
import io
import subprocess
import tarfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path

from validation.damaged_core import ROOT
from validation.mutation.sites import functions_of, what_it_does

Definition = tuple[str, str]  # its dotted name, and a text that is another one once it does something else


def number_of_head(root: Path = ROOT) -> int:
    """Return a number that each commit has for itself; raises ValueError where Git knows of none."""
    try:
        asked = subprocess.run(["git", "rev-parse", "HEAD"], cwd=root, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        raise ValueError("Git knows no commit here to draw by; give --seed") from error
    return int(asked.stdout[:8], 16)


def sources_at(revision: str, folder: str, root: Path) -> dict[str, str]:
    """Return the Python sources that a folder held at a revision, by path; none if there was no such folder.

    Raises ValueError if Git does not know the revision.
    """
    asked = ["git", "rev-parse", "--verify", "--quiet", f"{revision}^{{commit}}"]
    if subprocess.run(asked, cwd=root, capture_output=True).returncode:
        raise ValueError(f"Git knows no revision {revision!r}; name a commit, a branch or a tag")
    packed = subprocess.run(["git", "archive", "--format=tar", revision, folder], cwd=root, capture_output=True)
    if packed.returncode:
        return {}
    with tarfile.open(fileobj=io.BytesIO(packed.stdout)) as archive:
        members = [each for each in archive if each.isfile() and each.name.endswith(".py")]
        return {each.name: _text(archive, each) for each in members}


def sources_now(folder: str, root: Path) -> dict[str, str]:
    """Return the Python sources that a folder holds, by path."""
    paths = sorted(root.joinpath(folder).rglob("*.py"))
    return {path.relative_to(root).as_posix(): path.read_text(encoding="utf-8") for path in paths}


def functions_in(source: str) -> Iterator[Definition]:
    """Yield the functions and methods of a module, and what they do."""
    for name, function in functions_of(ast.parse(source)):
        yield name, what_it_does(function)


def definitions_in(source: str) -> Iterator[Definition]:
    """Yield the functions, classes and constants of a module, and of its classes."""
    yield from functions_in(source)
    yield from _values_in(ast.parse(source), "")


def changed(
    before: Mapping[str, str], now: Mapping[str, str], parts: Callable[[str], Iterable[Definition]]
) -> set[tuple[str, str]]:
    """Return (path, name) of each part that no module had before, by this name and doing the same.

    So what has only moved to another file, or stands in a file of another name, has not changed.
    """
    known = {part for source in before.values() for part in parts(source)}
    return {(path, part[0]) for path, source in now.items() for part in parts(source) if part not in known}


def _values_in(tree: ast.AST, prefix: str) -> Iterator[Definition]:
    """Yield the classes and constants below a module or a class."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ClassDef):
            yield prefix + node.name, ast.dump(_without_words(node))
            yield from _values_in(node, f"{prefix}{node.name}.")
        elif isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value is not None:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            stored = [each for target in targets for each in ast.walk(target) if isinstance(each, ast.Name)]
            for each in stored:
                yield prefix + each.id, ast.dump(node.value)
        elif isinstance(node, (ast.If, ast.Try)):
            yield from _values_in(node, prefix)


def _without_words(node: ast.ClassDef) -> ast.ClassDef:
    """Return a class without docstrings."""
    bare = copy.deepcopy(node)
    for each in ast.walk(bare):
        if isinstance(each, (ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(each) is not None:
            del each.body[0]
    return bare


def _text(archive: tarfile.TarFile, member: tarfile.TarInfo) -> str:
    file = archive.extractfile(member)
    assert file is not None
    return file.read().decode("utf-8")
