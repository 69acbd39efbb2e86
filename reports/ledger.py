"""Ledger of a record: who was right, how often, and how everybody was set, over all claims."""

from __future__ import annotations

from dataclasses import dataclass

from validation.record import Report, Setting


@dataclass
class Answerer:
    """How somebody stood before exact arithmetic and closed forms, in all claims together."""

    who: str
    claims: int = 0
    n: int = 0  # answers
    wrong: int = 0

    @property
    def rate(self) -> float | None:
        """The share of wrong answers."""
        return self.wrong / self.n if self.n else None


def answerers_of(report: Report) -> list[Answerer]:
    """Return everybody who answered, the most reliable first."""
    found: dict[str, Answerer] = {}
    for claim in report.claims:
        for standing in (one for arbitration in claim.arbitrations for one in arbitration.standings):
            who = found.setdefault(standing.who, Answerer(standing.who))
            who.claims += 1
            who.n += standing.n
            who.wrong += standing.wrong
    return sorted(found.values(), key=lambda one: (one.rate or 0.0, -one.n))


def settings_of(report: Report) -> dict[str, list[Setting]]:
    """Return how engines were set, engine by engine."""
    engines: dict[str, list[Setting]] = {}
    for setting in report.settings:
        engines.setdefault(setting.engine, []).append(setting)
    return engines
