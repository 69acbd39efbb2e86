"""How a benchmark is run: ours and its peers in turns, so that both meet the same noise."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable
from time import perf_counter
from typing import Any

import pytest

from benchmarks.machine import circumstances
from benchmarks.race import Race
from benchmarks.serving import SERVER
from benchmarks.suite import page_of

os.environ.setdefault("IGL_NUM_THREADS", "1")  # libigl takes all cores otherwise; ours and the others take one

ROUNDS = {"quick": 5, "standard": 7, "full": 41}


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add --level, which decides on sizes and on how many rounds a benchmark runs, and --page."""
    parser.addoption("--level", choices=list(ROUNDS), default="standard")
    parser.addoption("--page", action="store_true", help="only what the page has at the level")


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Run a benchmark on its sizes at the level: all arguments of its function but `race` and `level` are of them."""
    sizes = metafunc.function.benchmark.sizes
    names = [name for name in inspect.signature(metafunc.function).parameters if name not in ("race", "level")]
    if sizes:
        said = [sizes[level] for level in levels_of(metafunc.config) if level in sizes]
        metafunc.parametrize(",".join(names), said[-1] if said else ())


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Function]) -> None:
    """Put benchmarks in the order of the page, and leave out what it has not, if that is asked for."""
    items.sort(key=lambda item: page_of(item.module)[1])
    if config.getoption("--page"):
        items[:] = [item for item in items if page_of(item.module)[0] in levels_of(config)]


def levels_of(config: pytest.Config) -> list[str]:
    """Return the level at which benchmarks run, and before it those below."""
    return list(ROUNDS)[: list(ROUNDS).index(config.getoption("--level")) + 1]


def pytest_benchmark_update_machine_info(config: pytest.Config, machine_info: dict[str, Any]) -> None:
    """Write what bears on the timings into pytest-benchmark's document."""
    machine_info["softbody"] = circumstances(config.getoption("--level"))


@pytest.fixture
def level(request: pytest.FixtureRequest) -> str:
    """Return the level at which the benchmarks run."""
    return str(request.config.getoption("--level"))


@pytest.fixture
def race(benchmark: Any, request: pytest.FixtureRequest, level: str) -> Callable[..., None]:
    """Return a function that times our call and its peers in turns, round by round.

    race(ours, units, size=…, peers={name: (call, units)}): one call of `ours`, which is `name` in the `table`, does
    `units` units of work, such as particles × steps, called `per` in words; `size` counts `of`, the axis of the
    table; `peers` may be a function that makes them; `errors` are how far each ends from the truth, where that is the
    point; `own` names those that are the core, too: they are no yardstick for it. `restore` puts back what the calls
    change, before every round, and `answer` says what ours has computed, where it does not return it. `threads` is how
    many ours takes; `clock` how much motion [s] a unit of work is, where it is some. Words are those of the decorator,
    unless the call has others.
    """

    def run(ours: Callable[[], Any], units: float, **what: Any) -> None:
        one = Race(ours, units, **(vars(request.function.benchmark.row) | what))
        server = request.config.stash.get(SERVER, None)
        if server is not None:  # a comparison of revisions: rounds are run as they are asked for
            server.serve(one)
        else:
            time_in_turns(one, benchmark, ROUNDS[level])

    return run


def time_in_turns(race: Race, benchmark: Any, rounds: int) -> None:
    """Run the rounds; pytest-benchmark keeps our times, its `extra_info` those of the peers.

    Every competitor is called once before the clock starts.
    """
    rivals = race.rivals()
    seconds: dict[str, list[float]] = {rival: [] for rival in rivals}

    def let_the_peers_run() -> None:
        race.restore()
        for rival, (call, _) in rivals.items():
            start = perf_counter()
            call()
            seconds[rival].append(perf_counter() - start)
        race.restore()

    let_the_peers_run()
    for times in seconds.values():
        times.clear()
    race.ask()
    benchmark.extra_info.update({key: getattr(race, key) for key in ("table", "name", "size", "of", "per", "units")})
    benchmark.extra_info["errors"] = dict(race.errors)
    benchmark.extra_info["own"] = list(race.own)
    benchmark.extra_info["clock"] = race.clock
    benchmark.pedantic(race.ours, setup=let_the_peers_run, rounds=rounds)
    benchmark.extra_info["peers"] = {
        rival: {"units": rivals[rival][1], "seconds": times} for rival, times in seconds.items()
    }
