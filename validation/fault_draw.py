"""Some planted faults of all, drawn so that over many seeds all have their turn, and each draw compiles few kernels."""

from __future__ import annotations

import random
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from validation.check import Check
from validation.claim_groups import WORLDS, group_of
from validation.fault import Fault

Faults = dict[Fault, tuple[str, ...]]  # and the claims that are to see them
Pair = tuple[str, Fault]  # a claim, and a fault that it names
Groups = dict[str, list[Pair]]


@dataclass(frozen=True)
class Draw:
    """What is drawn, each fault with claims of the draw alone; of how many pairs of a fault and a claim; and where."""

    faults: Faults
    of: int
    groups: tuple[str, ...]

    @property
    def pairs(self) -> int:
        """How many pairs of a fault and a claim are drawn."""
        return sum(map(len, self.faults.values()))


def draw(faults: Mapping[Fault, Iterable[str]], checks: Mapping[str, Check], count: int, seed: int) -> Draw:
    """Draw so many pairs of a fault and a claim that names it, or all if they are fewer.

    What costs is to compile the kernels that claims need, once a draw. So half are of one kind of world, and the others
    of claims without worlds; both come file by file, as claims of a file need the same kernels. The same seed draws the
    same.
    """
    groups: Groups = {}
    for fault, claims in faults.items():
        for claim in claims:
            groups.setdefault(group_of(checks[claim]), []).append((claim, fault))
    worlds = {name: group for name, group in groups.items() if name.startswith(WORLDS)}
    others = [pair for name, group in groups.items() if name not in worlds for pair in group]
    rng, total = random.Random(seed), sum(map(len, groups.values()))
    if count >= total:
        return Draw({fault: tuple(claims) for fault, claims in faults.items()}, total, tuple(groups))
    chosen = _of_one(worlds, count // 2 if others else count, rng)
    chosen += _by_file(others, rng)[: count - len(chosen)]
    drawn: Faults = {}
    for claim, fault in chosen:
        drawn[fault] = (*drawn.get(fault, ()), claim)
    return Draw(drawn, total, tuple(dict.fromkeys(group_of(checks[claim]) for claim, _ in chosen)))


def _of_one(groups: Groups, count: int, rng: random.Random) -> list[Pair]:
    """Return so many of one group; a group comes the more often the larger it is, if it is larger than that."""
    if not groups or count == 0:
        return []
    group = rng.choices(list(groups.values()), [max(count, len(group)) for group in groups.values()])[0]
    return _by_file(group, rng)[:count]


def _by_file(pairs: Sequence[Pair], rng: random.Random) -> list[Pair]:
    """Return pairs file by file, and claim by claim, as each costs some seconds; all in any order."""
    ranks: dict[str, float] = {}
    for claim, fault in pairs:
        for each in (_file(claim), claim, fault.name):
            ranks.setdefault(each, rng.random())
    return sorted(pairs, key=lambda pair: (ranks[_file(pair[0])], ranks[pair[0]], ranks[pair[1].name]))


def _file(claim: str) -> str:
    return claim.rpartition(".")[0]
