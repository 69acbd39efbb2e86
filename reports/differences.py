"""Differences between two reports: claims one by one, and timings by their ratios to peers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from reports.notation import number
from reports.verdicts import is_count, verdict, why
from validation.record import BROKEN, FAILS, HOLDS, NOT_RUN, ClaimRecord, Report, Timing

# Both have the same seed, hence the same cases: that the largest error doubles is no chance of the draw. Below a tenth
# of the tolerance there is room for it, and rounding moves small errors by such factors when sums change their order.
CLOSER, NEAR = 2.0, 0.1
# Two runs differ by more than their rounds do. Of one revision with itself, at level quick, on the machine where this
# was tried, 4 of 462 timings were "slower" by twice the quartile ranges of both, and 29 by once.
SPREADS = 2.0

FAILS_NOW, NOT_RUN_NOW, WIDENED, CLOSER_NOW = "fails now", "not run now", "wider tolerance", "closer to its tolerance"
HOLDS_NOW, NEW, GONE = "holds now", "new", "gone"
KINDS = (FAILS_NOW, NOT_RUN_NOW, WIDENED, CLOSER_NOW, HOLDS_NOW, NEW, GONE)

Row = tuple[str, str, int]  # table, name and size of a timing


@dataclass(frozen=True)
class Change:
    """What has become of a claim."""

    kind: str
    id: str
    what: str  # in words


@dataclass(frozen=True)
class SlowDown:
    """A timing of ours that is slower relative to all peers."""

    row: Row
    ratio: float  # of our time, now to before, by the peer that shows the least of it
    peers: list[str]


def changes(before: Report, now: Report) -> list[Change]:
    """Return what has become of claims, the worst first; those that are as they were are left out."""
    old, new = ({claim.id: claim for claim in report.claims} for report in (before, now))
    found = [change_of(old.get(name), new.get(name)) for name in dict.fromkeys([*old, *new])]
    return sorted((change for change in found if change), key=lambda change: KINDS.index(change.kind))


def change_of(old: ClaimRecord | None, new: ClaimRecord | None) -> Change | None:
    """Return what has become of one claim, or None if it is as it was. One that fails is that, even if it is new."""
    if new is None:
        return Change(GONE, old.id, f"it was: {verdict(old)}") if old else None
    was, now = verdict(old) if old else None, verdict(new)
    if now == FAILS and was != FAILS:
        return Change(FAILS_NOW, new.id, why(new) or "")
    if old is None:
        return Change(NEW, new.id, now)
    if now != was:
        return Change(NOT_RUN_NOW if now in (NOT_RUN, BROKEN) else HOLDS_NOW, new.id, why(new) or f"it was: {was}")
    if now != HOLDS:
        return None
    if new.tolerance > old.tolerance:
        return Change(WIDENED, new.id, f"{number(old.tolerance)} → {number(new.tolerance)} {new.unit}")
    shares = share_of_tolerance(old), share_of_tolerance(new)
    if shares[1] > max(NEAR, CLOSER * shares[0]):
        least, most = map(number, shares)
        return Change(CLOSER_NOW, new.id, f"{least} → {most} of {number(new.tolerance)} {new.unit}")
    return None


def share_of_tolerance(claim: ClaimRecord) -> float:
    """Return the largest error over the tolerance; 0 where nothing is measured, or cases are counted."""
    return 0.0 if claim.value is None or is_count(claim) else claim.value / claim.tolerance


def slow_downs(before: Report, now: Report) -> tuple[list[SlowDown], int]:
    """Return our timings that are slower, relative to all peers that both have, and how many could be compared.

    A peer that is slower or faster for a reason of its own says nothing of ours: hence all of them.
    """
    old, new = peers_of(before), peers_of(now)
    found, count = [], 0
    for row in old:
        shared = [name for name in old[row] if name in new.get(row, ())]
        count += bool(shared)
        rises = [old[row][name][0] - new[row][name][0] for name in shared]
        spreads = [old[row][name][1] + new[row][name][1] for name in shared]
        if shared and all(rise > SPREADS * spread for rise, spread in zip(rises, spreads)):
            found.append(SlowDown(row, math.exp(min(rises)), shared))
    return sorted(found, key=lambda one: -one.ratio), count


def peers_of(report: Report) -> dict[Row, dict[str, tuple[float, float]]]:
    """Return, for each timing of ours, the ratio and its quartile range of each peer that is not the core itself.

    Both are logarithms.
    """
    return {
        (ours.table, ours.name, ours.size): {
            peer.name: (math.log(peer.ratio), math.log(peer.high_ratio / peer.low_ratio))
            for peer in theirs
            if peer.ratio and peer.low_ratio and peer.high_ratio and not peer.own
        }
        for ours, theirs in _races(report.timings)
    }


def _races(timings: list[Timing]) -> Iterator[tuple[Timing, list[Timing]]]:
    """Yield each row of ours with the rows of its peers, which follow it."""
    starts = [k for k, timing in enumerate(timings) if timing.ratio is None]
    for start, end in zip(starts, [*starts[1:], len(timings)]):
        yield timings[start], timings[start + 1 : end]
