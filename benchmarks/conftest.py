"""How a benchmark is run: ours and its peers in turns, so that both meet the same noise."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from time import perf_counter
from typing import Any

import pytest

os.environ.setdefault("IGL_NUM_THREADS", "1")  # libigl takes all cores otherwise; ours and the others take one

ROUNDS = {"quick": 5, "standard": 7, "full": 41}

Peer = tuple[Callable[[], Any], float]  # what to call, and how many units of work one call does


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add --level, which decides how many rounds a benchmark runs."""
    parser.addoption("--level", choices=list(ROUNDS), default="standard")


@pytest.fixture
def race(benchmark: Any, request: pytest.FixtureRequest) -> Callable[..., None]:
    """Return a function that times our call and its peers in turns, round by round.

    race(ours, units, table=…, name=…, size=…, of=…, per=…, peers={name: (call, units)}): one call of `ours` does
    `units` units of work, such as particles × steps, called `per` in words; `size` counts `of`, the axis of the
    table; `errors` are how far each ends from the truth, where that is the point. Every competitor is called once
    before the clock starts. pytest-benchmark keeps our times, its `extra_info` those of the peers.
    """

    def run(
        ours: Callable[[], Any],
        units: float,
        *,
        table: str,
        name: str,
        size: int,
        of: str,
        per: str,
        peers: Mapping[str, Peer] | None = None,
        errors: Mapping[str, float] | None = None,
    ) -> None:
        rivals = dict(peers or {})
        seconds: dict[str, list[float]] = {rival: [] for rival in rivals}

        def let_the_peers_run() -> None:
            for rival, (call, _) in rivals.items():
                start = perf_counter()
                call()
                seconds[rival].append(perf_counter() - start)

        let_the_peers_run()
        for times in seconds.values():
            times.clear()
        ours()
        benchmark.extra_info.update(table=table, name=name, size=size, of=of, per=per, units=units)
        benchmark.extra_info["errors"] = dict(errors or {})
        rounds = ROUNDS[request.config.getoption("--level")]
        benchmark.pedantic(ours, setup=let_the_peers_run, rounds=rounds)
        benchmark.extra_info["peers"] = {
            rival: {"units": rivals[rival][1], "seconds": times} for rival, times in seconds.items()
        }

    return run
