"""What became of each mutant: rows that are kept, one JSON line each, as mutants end, and their summary."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from validation.mutation.explained import Reason
from validation.mutation.sites import Mutant
from validation.record import write_whole

# What a mutant can come to. Only KILLED is told by what a claim measured.
KILLED, CRASHED, HUNG, SURVIVED, STILLBORN = "killed", "crashed", "hung", "survived", "stillborn"
ENOUGH = 3  # claims that a mutant may crash before it is said to do nothing else


@dataclass
class Fate:
    """What has become of a mutant so far, and what was tried on it."""

    mutant: Mutant
    verdict: str = SURVIVED
    by: str | None = None  # the claim that told
    why: str | None = None
    level: str | None = None  # at which it told
    form: str | None = None  # "interpreted" or "compiled"
    core: str | None = None  # digest of the core in which it was tried last
    seconds: float = 0.0  # of the processor, in claims
    crashes: int = 0  # claims that crashed
    tried: list[str] = field(
        default_factory=list
    )  # claims that came by: "quick sat.depth 0a1b2c3d", the last of their file
    changed: list[str] = field(default_factory=list)  # those of which it changed a bit, and that hold nevertheless

    @property
    def is_over(self) -> bool:
        """Whether nothing more needs to be tried."""
        return self.verdict in (KILLED, HUNG, STILLBORN) or self.crashes >= ENOUGH

    def claims(self) -> list[str]:
        """Return the claims that were tried, without repetitions."""
        return list(dict.fromkeys(each.split()[1] for each in self.tried))


class Ledger:
    """The fates of mutants, in a file of JSON lines; the last line of a mutant counts.

    What was seen of a mutant is said of every core in which its function does what it did then.
    """

    def __init__(self, path: Path, core: str, seed: int, resume: bool) -> None:
        """Begin a file, or go on with one; raises ValueError if that one is of another seed. `core` is its digest."""
        self._path, self._core = path, core
        self._fates: dict[str, Fate] = {}
        self._done: dict[str, set[str]] = {}  # claims that were tried on a mutant, or do not come by
        self.slow: set[str] = set()  # claims that take long interpreted
        path.parent.mkdir(parents=True, exist_ok=True)
        if not (resume and path.exists()):
            write_whole(path, json.dumps({"seed": seed}) + "\n")
            return
        rows = [_row(line) for line in path.read_text(encoding="utf-8").splitlines()]
        if not rows or rows[0] != {"seed": seed}:
            raise ValueError(f"{path} is of another seed: begin anew, without --resume")
        for row in rows[1:]:
            self._take(row)

    def _take(self, row: dict[str, Any]) -> None:
        if "slow" in row:
            self.slow.add(row["slow"])
        elif "done" in row:
            self._take_done(row["done"], row["mutants"])
        elif "mutant" in row:
            fate = Fate(**row | {"mutant": Mutant(**row["mutant"])})
            self._fates[fate.mutant.identity] = fate

    def _append(self, row: dict[str, Any]) -> None:
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(row, ensure_ascii=False) + "\n")

    def fate_of(self, mutant: Mutant) -> Fate:
        """Return what is known of a mutant."""
        return self._fates.setdefault(mutant.identity, Fate(mutant))

    def note(self, fate: Fate) -> None:
        """Keep what has become of a mutant in this core."""
        fate.core = self._core
        self._append(asdict(fate))

    def is_slow(self, claim: str) -> None:
        """Keep that a claim takes long interpreted."""
        self.slow.add(claim)
        self._append({"slow": claim})

    def is_done(self, claims: Iterable[str], mutants: Iterable[Mutant]) -> None:
        """Keep that of some claims all that come by some mutants were tried on them."""
        row: dict[str, Any] = {"done": sorted(claims), "mutants": [each.identity for each in mutants]}
        self._take_done(row["done"], row["mutants"])
        self._append(row)

    def _take_done(self, claims: list[str], mutants: list[str]) -> None:
        for key in mutants:
            self._done.setdefault(key, set()).update(claims)

    def known(self, fate: Fate) -> set[str]:
        """Return the claims that were tried on a mutant, or do not come by."""
        return self._done.get(fate.mutant.identity, set()).union(fate.tried)


def _row(line: str) -> dict[str, Any]:
    """Return a line's row; nothing if the run that wrote it was cut off in its middle."""
    try:
        row: dict[str, Any] = json.loads(line)
    except json.JSONDecodeError:
        return {}
    return row


def write_summary(
    fates: Iterable[Fate], explained: Mapping[str, Reason], heading: Mapping[str, Any], out: Path
) -> None:
    """Write the totals, and all that survived, as JSON.

    `mutants` counts those that compile; each is `killed` (by what a claim measured), `crashed`, `hung`, `equivalent`
    (nobody can tell it from the core), `within` (it changes what is within what is promised) or `survived`. `seen_at`
    are those that turn a claim red, by the level that was first to see them; `earlier` are those that were tried on
    another core, in a function that does the same now.
    """
    rows = list(fates)
    counts = {name: sum(_state(fate, explained) == name for fate in rows) for name in STATES}
    stillborn = counts.pop(STILLBORN)
    survivors = [fate for fate in rows if _state(fate, explained) == SURVIVED]
    summary = {
        "mutants": len(rows) - stillborn,
        **counts,
        "stillborn": stillborn,
        "seen_at": dict(Counter(fate.level for fate in rows if fate.verdict in SEEN)),
        "earlier": sum(fate.core not in (None, heading["core"]) for fate in rows),
        **heading,
        "survivors": [_survivor(fate) for fate in survivors],
        "explained": [
            {"mutant": fate.mutant.key, "reason": explained[fate.mutant.key].text, "state": state}
            for fate in rows
            if (state := _state(fate, explained)) in (EQUIVALENT, WITHIN)
        ],
    }
    write_whole(out, json.dumps(summary, indent=1, ensure_ascii=False) + "\n")


EQUIVALENT, WITHIN = "equivalent", "within"
SEEN = (KILLED, CRASHED, HUNG)
STATES = (*SEEN, EQUIVALENT, WITHIN, SURVIVED, STILLBORN)


def _state(fate: Fate, explained: Mapping[str, Reason]) -> str:
    reason = explained.get(fate.mutant.key) if fate.verdict == SURVIVED else None
    if reason is None:
        return fate.verdict
    return WITHIN if reason.within else EQUIVALENT


def counted(fates: Iterable[Fate], explained: Mapping[str, Reason]) -> dict[str, int]:
    """Return how many mutants came to what."""
    states = [_state(fate, explained) for fate in fates]
    return {name: states.count(name) for name in STATES}


def share_seen(counts: Mapping[str, int]) -> float:
    """Return the share of the mutants that turn a claim red, of all that compile and that nobody has explained."""
    seen = sum(counts[name] for name in SEEN)
    return seen / (seen + counts[SURVIVED]) if seen + counts[SURVIVED] else 1.0


def survivors_of(fates: Iterable[Fate], explained: Mapping[str, Reason]) -> Iterator[Fate]:
    """Yield the mutants that no claim has seen, and that nobody has explained."""
    return (fate for fate in fates if _state(fate, explained) == SURVIVED)


def _survivor(fate: Fate) -> dict[str, Any]:
    one = fate.mutant
    return {
        "file": f"softbody/{one.file}",
        "line": one.line,
        "function": one.function,
        "operator": one.operator,
        "before": one.before,
        "after": one.after,
        "key": one.key,
        "claims": fate.claims(),
        "changed": fate.changed,
    }
