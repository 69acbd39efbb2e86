"""Timings and verdicts in a terminal: one row a size, one column a competitor."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from rich.markup import escape
from rich.table import Table

from benchmarks.compare import Result
from benchmarks.goals import MET, MISSED, Outcome
from benchmarks.running import Document, competitors
from benchmarks.verdicts import FASTER, SLOWER

STYLES = {SLOWER: "bold red", FASTER: "green"}


def timing_tables(document: Document) -> Iterator[Table]:
    """Yield a table of medians for each table that the races name."""
    tables: dict[str, list[dict[str, Any]]] = {}
    for race in document["benchmarks"]:
        if "table" in race["extra_info"]:
            tables.setdefault(race["extra_info"]["table"], []).append(race)
    for title, races in tables.items():
        rows = {race["extra_info"]["size"]: competitors(race) for race in races}
        names = list(dict.fromkeys(name for row in rows.values() for name in row))
        info = races[0]["extra_info"]
        table = Table(title=f"{title} [ns per {info['per']}]", title_justify="left", title_style="bold")
        table.add_column(info["of"], justify="right", no_wrap=True)
        for name in names:
            table.add_column(name, justify="right")
        for size, row in sorted(rows.items()):
            cells = [significant(1e9 * float(np.median(row[name]))) if name in row else "–" for name in names]
            table.add_row(f"{size:,}".replace(",", " "), *cells)
        yield table


def goals_table(found: Iterable[Outcome]) -> Table:
    """Return a row for each goal: what it is, and how far it is met where it is met least."""
    table = Table(title="Goals: times as fast, at least", title_justify="left", title_style="bold")
    for heading in ("table", "who", "goal", "measured", "quartiles", "at", "verdict"):
        is_number = heading in ("goal", "measured", "quartiles")
        table.add_column(heading, justify="right" if is_number else "left", overflow="fold")
    for one in found:
        measured = "–" if one.measured is None else f"{one.measured:.3g}"
        spread = "–" if one.low is None else f"{one.low:.3g} … {one.high:.3g}"
        wanted = f"{'≥' if one.is_least else '≤'} {one.wanted:.3g}"
        style = {MISSED: "bold red", MET: "green"}.get(one.verdict)
        table.add_row(
            escape(one.table), escape(one.what), wanted, measured, spread, one.where, one.verdict, style=style
        )
    return table


def significant(value: float) -> str:
    """Return three digits and more, without exponent: 12.3, 1 230 000."""
    digits = max(0, 2 - int(np.floor(np.log10(value)))) if value > 0.0 else 0
    return f"{value:,.{digits}f}".replace(",", " ")


def ratio_of(instructions: tuple[int, int] | None) -> str:
    """Return how many times as many the second core takes."""
    return f"× {instructions[1] / instructions[0]:.4f}" if instructions else "–"


def verdict_table(results: Iterable[Result], names: tuple[str, str]) -> Table:
    """Return a row for each benchmark that was compared."""
    table = Table(title=f"{names[1]} compared with {names[0]}", title_justify="left", title_style="bold")
    results = list(results)
    counted = any(result.instructions for result in results)
    more = ("instructions",) if counted else ()
    for heading in ("benchmark", "verdict", "time", "99 % interval", "noise", "openings", *names, *more):
        is_text = heading in ("benchmark", "verdict")
        table.add_column(heading, justify="left" if is_text else "right", overflow="fold")
    for result in results:
        if not result.openings:
            continue
        found = result.verdict
        seconds = np.median([opening.seconds for opening in result.openings], axis=0)
        table.add_row(
            escape(result.name),
            found.verdict + ("" if found.clear else " *"),
            f"× {found.ratio:.3f}",
            f"{found.low:.3f} … {found.high:.3f}" if found.high < np.inf else "–",
            f"{100.0 * found.noise:.1f} %",
            str(found.openings),
            *(f"{1e3 * one:.3g} ms" for one in seconds),
            *([ratio_of(result.instructions)] if counted else []),
            style=STYLES.get(found.verdict),
        )
    return table
