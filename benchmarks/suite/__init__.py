"""What files of this folder say of their benchmarks; nothing else knows any.

A file is found by its name, `bench_….py`, and its benchmarks by those of their functions, `bench_…`.
"""

from __future__ import annotations

import importlib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import ModuleType
from typing import Any

import click

from benchmarks.goals import Goal, Growth


@dataclass(frozen=True)
class Row:
    """The words of a benchmark, as the fixture `race` explains them; a call of it may have others."""

    table: str
    of: str
    per: str
    name: str = "softbody"
    own: Collection[str] = ()


@dataclass(frozen=True)
class Benchmark:
    """All that is known of a benchmark before it runs: the decorator of its function."""

    row: Row
    sizes: Mapping[str, Sequence[Any]] = field(default_factory=dict)  # level → what the function gets there and above
    usual: bool | Collection[Any] = False  # is it compared when nobody says which, or which sizes are
    goals: Sequence[Goal | Growth] = ()

    def __call__(self, function: Any) -> Any:
        """Let a function be the benchmark."""
        function.benchmark = self
        return function


def page_of(module: ModuleType) -> tuple[str, int]:
    """Return the level from which on the page has what is in a file, and its place there: PAGE of the file."""
    return getattr(module, "PAGE", ("standard", 99))


def goals() -> list[Goal | Growth]:
    """Return the goals of all benchmarks, in the order of the page; files that cannot be imported are named."""
    modules = []
    for path in sorted(Path(__file__).parent.glob("bench_*.py")):
        try:
            modules.append(importlib.import_module(f"{__name__}.{path.stem}"))
        except ImportError as error:
            click.echo(f"{path.name} has no goals here: {error}", err=True)
    modules.sort(key=lambda module: page_of(module)[1])
    said = [value.benchmark for one in modules for name, value in vars(one).items() if name.startswith("bench_")]
    pairs = [(goal, one.row) for one in said for goal in one.goals]
    return [replace(goal, table=goal.table or row.table, name=goal.name or row.name) for goal, row in pairs]
