"""Planted faults and mutants that claims were seen to detect, as `make faults` and `make mutants` left them.

Both say which core they were tried on: what was seen on another one is not said of this one.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from softbody.compiler.core_digest import core_digest
from validation.record import PlantedFault, Sensitivity

FAULTS, MUTANTS = "faults.json", "mutants.json"


def sensitivity(folder: Path) -> Sensitivity:
    """Return what is known of this core in `folder`, and why not more is."""
    faults, why_no_faults = _left_in(folder / FAULTS, "make faults")
    mutants, why_no_mutants = _left_in(folder / MUTANTS, "make mutants")
    found = Sensitivity(faults_why=why_no_faults, mutants_why=why_no_mutants)
    if faults:
        rows = faults["faults"]
        found.faults = [
            PlantedFault(row["name"], row["place"], list(row["claims"]), row["verdict"], row["off"]) for row in rows
        ]
    if mutants:
        for name in ("mutants", "killed", "crashed", "hung", "equivalent", "within", "earlier"):
            setattr(found, name, int(mutants[name]))
        found.seen_at = dict(mutants["seen_at"])
        found.survivors = [f"{row['file']}:{row['line']} {row['key'].split(':', 1)[1]}" for row in mutants["survivors"]]
    return found


def _left_in(path: Path, command: str) -> tuple[dict[str, Any] | None, str | None]:
    """Return what a file says of this core, or None and why."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None, f"not tried: {command}"
    except (OSError, ValueError) as error:
        return None, f"{path.name} cannot be read ({error}): {command} again"
    if not isinstance(data, dict) or data.get("core") != core_digest():
        return None, f"tried on another core: {command} again"
    return data, None
