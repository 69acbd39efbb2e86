"""Which attempts are made, by whom, and what came of them all?"""

from __future__ import annotations

import pkgutil
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module
from math import inf
from multiprocessing.connection import wait

from tests.fuzz._process import Attempt, Outcome, Process

EXAMPLES = 20  # that are kept of what broke in a campaign


@dataclass
class Campaign:
    """What is tried again and again, with consecutive seeds."""

    module: str
    promise: str  # first line of the module's docstring
    next_seed: int
    tries_each: int = 1  # that an attempt makes
    goal: int = 0  # tries in all that are to be made before a promise is believed
    attempts: int = 0  # that have ended
    bad: int = 0
    slow: int = 0  # that had to be made again, with more time
    seconds: float = 0.0  # that they took
    examples: list[Outcome] = field(default_factory=list)

    @property
    def tries(self) -> int:
        """How many were made."""
        return self.attempts * self.tries_each

    @property
    def name(self) -> str:
        """Its module's name in the package."""
        return self.module.rpartition(".")[2]

    def add(self, outcome: Outcome) -> None:
        """Count an outcome."""
        self.attempts += 1
        self.seconds += outcome.seconds
        self.slow += outcome.slow
        if outcome.broken is not None:
            self.bad += 1
            if len(self.examples) < EXAMPLES:
                self.examples.append(outcome)


def campaigns_in(package: str, seed: int = 0) -> list[Campaign]:
    """Return the campaigns of a package: its modules whose names do not begin with an underscore."""
    names = [found.name for found in pkgutil.iter_modules(import_module(package).__path__)]
    modules = [f"{package}.{name}" for name in sorted(names) if not name.startswith("_")]
    found = [import_module(name) for name in modules]
    return [
        Campaign(
            each.__name__,
            str(each.__doc__).splitlines()[0],
            seed,
            getattr(each, "TRIES", 1),
            getattr(each, "GOAL", 0),
        )
        for each in found
    ]


def play(
    campaigns: list[Campaign],
    attempts: float = inf,
    seconds: float = inf,
    jobs: int = 1,
    limit: float = 120.0,
    each: Callable[[Campaign, Outcome | None], None] = lambda campaign, outcome: None,
) -> None:
    """Make `attempts` of each campaign, or as many as begin within `seconds`, `jobs` at once, each within `limit` [s].

    The time is shared equally. `each` is called with every outcome, and with None now and then between them. What has
    ended is counted when this is interrupted, too.
    """
    end, processes = time.monotonic() + seconds, [Process(limit) for _ in range(jobs)]
    of = {campaign.module: campaign for campaign in campaigns}
    begun = dict.fromkeys(of, 0)
    try:
        while True:
            for process in processes:
                left = [campaign for campaign in campaigns if begun[campaign.module] < attempts]
                if process.attempt or not left or time.monotonic() >= end:
                    continue
                busy = {one.attempt.campaign: one.seconds for one in processes if one.attempt}
                campaign = min(left, key=lambda one: one.seconds + busy.get(one.module, 0.0))
                process.make(Attempt(campaign.module, campaign.next_seed))
                campaign.next_seed += 1
                begun[campaign.module] += 1
            if not any(process.attempt for process in processes):
                return
            wait([process.pipe for process in processes], 0.2)
            each(campaigns[0], None)
            for process in processes:
                outcome = process.outcome() if process.attempt else None
                if outcome:
                    of[outcome.attempt.campaign].add(outcome)
                    each(of[outcome.attempt.campaign], outcome)
    finally:
        for process in processes:
            process.end()
