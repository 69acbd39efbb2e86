"""Declarations in an engine's file, read as data without importing anything: an engine may be missing."""

from __future__ import annotations

import ast
from dataclasses import dataclass, field
from pathlib import Path

from validation.record import ENGINE, LIBRARY


@dataclass(frozen=True)
class Declared:
    """What stands at the head of a file that asks an engine."""

    name: str  # of the file
    path: Path
    packages: dict[str, str] = field(default_factory=dict)  # PACKAGES: import name → the name to install it by
    kind: str = LIBRARY  # KIND of judge: ENGINE or LIBRARY
    settings: dict[str, str] = field(default_factory=dict)  # SETTINGS: what was chosen → why
    cannot: dict[str, str] = field(default_factory=dict)  # CANNOT: a question → why the engine has no answer to it
    functions: frozenset[str] = frozenset()
    leans_on: frozenset[str] = frozenset()  # files of references/ that it imports
    precision: str = "double"  # PRECISION: "single" or "double"
    title: str = ""  # first line of its docstring
    module: str | None = None  # to import it by, if it is another package's


def read_file(path: Path, name: str | None = None, module: str | None = None) -> Declared:
    """Return what a file says; raises ValueError, naming it, for what is no Python, or no table of texts."""
    try:
        file = ast.parse(path.read_text(encoding="utf-8"))
    except (SyntaxError, ValueError, OSError) as error:
        raise ValueError(f"{path} cannot be read: {error}") from None
    body = file.body
    said = {ast.unparse(node.targets[0]): node.value for node in body if isinstance(node, ast.Assign)}
    tables = {}
    for table in ("PACKAGES", "SETTINGS", "CANNOT"):
        try:
            tables[table] = ast.literal_eval(said[table]) if table in said else {}
        except ValueError:
            tables[table] = None
        if not _is_table_of_texts(tables[table]):
            raise ValueError(f'{path}: {table} is not as {{"a text": "a text"}}, which is read and never run')
    kind = ast.literal_eval(said["KIND"]) if isinstance(said.get("KIND"), ast.Constant) else LIBRARY
    if kind not in (ENGINE, LIBRARY):
        raise ValueError(f"{path}: KIND is {kind!r}; choose from {ENGINE!r} and {LIBRARY!r}")
    precision = ast.literal_eval(said["PRECISION"]) if isinstance(said.get("PRECISION"), ast.Constant) else "double"
    if precision not in ("single", "double"):
        raise ValueError(f"{path}: PRECISION is {precision!r}; choose from 'single' and 'double'")
    functions = frozenset(node.name for node in body if isinstance(node, ast.FunctionDef))
    imports = [node for node in body if isinstance(node, ast.ImportFrom) and node.module == "references"]
    return Declared(
        name=name or path.stem,
        path=path,
        packages=tables["PACKAGES"],
        kind=kind,
        settings=tables["SETTINGS"],
        cannot=tables["CANNOT"],
        functions=functions,
        leans_on=frozenset(alias.name for node in imports for alias in node.names),
        precision=precision,
        title=(ast.get_docstring(file) or "").partition("\n")[0],
        module=module,
    )


def all_in(folder: Path) -> list[Declared]:
    """Return what each file of a folder says, in order of their names."""
    return [read_file(path) for path in sorted(folder.glob("*.py")) if path.stem != "__init__"]


def _is_table_of_texts(table: object) -> bool:
    return isinstance(table, dict) and all(isinstance(text, str) for pair in table.items() for text in pair)
