"""Mutants that no claim need see, each with the reason: what is in `explained.json`, by `Mutant.key`.

Nobody can tell them from the core; or, where a row says `within`, they change what is within what the core promises,
such as in which step of many something converges.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple


class Reason(NamedTuple):
    """Why no claim need see a mutant."""

    text: str
    within: bool  # it changes something, within what is promised


def explained_in(path: Path) -> dict[str, Reason]:
    """Return the reasons in a file of rows {"reason", "within", "mutants"}; raises ValueError for two of one mutant."""
    reasons: dict[str, Reason] = {}
    for row in json.loads(path.read_text(encoding="utf-8")):
        for key in row["mutants"]:
            if key in reasons:
                raise ValueError(f"{path.name} has two reasons for {key!r}: keep one")
            reasons[key] = Reason(row["reason"], row.get("within", False))
    return reasons


EXPLAINED = explained_in(Path(__file__).with_name("explained.json"))
