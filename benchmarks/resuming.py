"""What was compared before: kept in the history, for a comparison to go on where it was interrupted."""

from __future__ import annotations

from dataclasses import asdict
from datetime import datetime, timezone

from benchmarks.compare import Plan, Result
from benchmarks.duel import Opening
from benchmarks.history import History, Record
from benchmarks.machine import machine_here


def keep(history: History, plan: Plan, results: dict[str, Result]) -> None:
    """Store what was measured."""
    started = datetime.now(timezone.utc).isoformat(timespec="microseconds")
    document = {**_identity(plan), "results": [asdict(result) for result in results.values()]}
    history.add([Record("comparison", started, machine_here(), document)])


def kept(history: History, plan: Plan) -> dict[str, Result]:
    """Return what the last comparison of the same two cores has measured; what failed then is tried again."""
    for record in reversed(history.records("comparison", machine_here())):
        if all(record.document.get(key) == value for key, value in _identity(plan).items()):
            return {row["name"]: _result(row) for row in record.document["results"]}
    return {}


def _identity(plan: Plan) -> dict[str, object]:
    return {"cores": [side.folder.name for side in plan.sides], "level": plan.level, "patterns": list(plan.patterns)}


def _result(row: dict[str, object]) -> Result:
    openings = [Opening(one["ratio"], tuple(one["seconds"])) for one in row["openings"]]  # type: ignore[attr-defined]
    return Result(str(row["name"]), openings, row["answers_differ"])  # type: ignore[arg-type]
