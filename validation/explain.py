"""Explanation of a claim in full: everything that is declared of it, to read on a terminal."""

from __future__ import annotations

import inspect
import textwrap

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from validation.check import LEAST, Check
from validation.record import KINDS


def explanation(check: Check) -> RenderableType:
    """Return what is declared of a claim."""
    rows = Table.grid(padding=(0, 2))
    rows.add_column(style="bold", no_wrap=True)
    rows.add_column(overflow="fold")
    for name, text in facts_of(check):
        rows.add_row(name, Text(text))
    detail = [Text(), Text(check.detail)] if check.detail else []
    return Group(Text(check.claim, style="bold"), *detail, Text(), rows)


def facts_of(check: Check) -> list[tuple[str, str]]:
    """Return names and texts of all that is declared of a claim."""
    facts = [
        ("claim", check.id),
        ("family", check.family),
        ("paper", f"§{check.section}"),
        ("piece", check.piece),
        ("judged by", check.reference),
        ("kind of judge", f"{check.kind}: {KINDS.get(check.kind, '')}"),
        ("needs", ", ".join(check.engines) or "no engine"),
        ("tolerance", f"{check.tolerance:g} {check.unit}: {check.because}"),
    ]
    if check.least != LEAST:
        facts.append(("compares", f"{check.least} cases at least"))
    if check.erratum is not None:
        facts.append((f"erratum {check.erratum.id}", f"printed: {check.erratum.prints}; right: {check.erratum.right}"))
    for fault in check.faults:
        change = f"{fault.find}\nbecomes\n{fault.put or '(nothing)'}"
        facts.append(("planted fault", f"{fault.name}, in {'.'.join(fault.place)}\n{textwrap.indent(change, '  ')}"))
    code = inspect.unwrap(check.compare).__code__
    return [*facts, ("declared in", f"{code.co_filename}:{code.co_firstlineno}")]
