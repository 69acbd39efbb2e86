"""A comparison ends when all is clear or time is up, keeps what it has, and says what it cannot compare."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from benchmarks import compare as comparing
from benchmarks.cli import ALL_WELL, SLOWER_OR_WRONG, exit_code, report
from benchmarks.compare import SESSION, Plan, Result, compare
from benchmarks.duel import Opening, UnableError, difference
from benchmarks.history import History
from benchmarks.resuming import keep, kept
from benchmarks.sides import Side
from benchmarks.verdicts import LOOKS, NO_DIFFERENCE, SLOWER
from benchmarks.worker import WorkerError

SIDES = Side("a", "aaaa", Path("cores/a")), Side("b", "bbbb", Path("cores/b"))


def plan(budget=1e9, patterns=("bench",)):
    return Plan(SIDES, Path(), "quick", patterns, budget)


class Duel:
    """Two workers whose second is slower by what `slower` says, with noise."""

    def __init__(self, slower, noise=0.005, broken=(), differ=None, events=()):
        self.slower, self.noise, self.differ = slower, noise, differ
        self.events = dict(events)  # number of the opening → what it raises
        self.unreadable = dict(broken)
        self.rng, self.opened, self.starts = np.random.default_rng(1), 0, 0

    def benchmarks(self, which="benchmarks"):
        return list(self.slower)[which == "usual" :]  # all but the first

    def broken(self):
        return self.unreadable

    def open(self, name):
        self.opened += 1
        if self.opened in self.events:
            raise self.events.pop(self.opened)
        return Opening(float(np.log1p(self.slower[name]) + self.noise * self.rng.normal()), (1.0, 1.0)), self.differ


@pytest.fixture
def run(monkeypatch):
    def run(duel, results=None, **how):
        @contextmanager
        def dueling(plan, rng):
            duel.starts += 1
            yield duel

        monkeypatch.setattr(comparing, "dueling", dueling)
        results = {} if results is None else results
        compare(plan(**how), results, lambda what: None)
        return results

    return run


def test_what_is_clear_is_not_opened_again(run):
    results = run(Duel({"bench_same": 0.0, "bench_slower": 0.1}))
    assert [result.verdict.verdict for result in results.values()] == [NO_DIFFERENCE, SLOWER]
    assert [len(result.openings) for result in results.values()] == [LOOKS[0]] * 2


def test_what_is_not_clear_is_opened_until_the_last_look_in_ever_new_processes(run):
    duel = Duel({"bench_noisy": 0.0}, noise=0.2)
    results = run(duel)
    assert len(results["bench_noisy"].openings) == LOOKS[-1]
    assert duel.starts == LOOKS[-1] // SESSION


def test_only_what_a_pattern_names_is_opened(run):
    assert list(run(Duel({"bench_pile[10]": 0.0, "bench_step[1]": 0.0}), patterns=("STEP", "none"))) == [
        "bench_step[1]"
    ]


def test_without_a_pattern_the_usual_ones_are_opened(run):
    assert list(run(Duel({"bench_pile[10]": 0.0, "bench_step[1]": 0.0}), patterns=())) == ["bench_step[1]"]


def test_when_time_is_up_what_is_there_is_kept(run):
    assert run(Duel({"bench": 0.0}), budget=0.0)["bench"].openings == []


def test_when_interrupted_what_is_there_is_kept_and_can_be_resumed(run, tmp_path):
    history, results = History(tmp_path / "history.sqlite"), {}
    with pytest.raises(KeyboardInterrupt):
        run(Duel({"bench": 0.1}, events={8: KeyboardInterrupt()}), results)
    assert len(results["bench"].openings) == 6  # the first opening compiles
    keep(history, plan(), results)
    again = kept(history, plan())
    assert again == results
    assert len(run(Duel({"bench": 0.1}), again)["bench"].openings) == LOOKS[0]
    assert kept(history, plan(patterns=("other",))) == {}


def test_a_benchmark_that_a_side_cannot_run_is_said_and_the_others_go_on(run):
    events = {1: UnableError("b cannot run it: ImportError")}
    results = run(Duel({"bench_new": 0.0, "bench_old": 0.0}, events=events))
    assert results["bench_new"].why == "b cannot run it: ImportError"
    assert results["bench_old"].verdict.clear
    assert exit_code(results, None, False) == SLOWER_OR_WRONG


def test_a_process_that_dies_stops_its_benchmark_alone(run):
    duel = Duel({"bench_a": 0.0, "bench_b": 0.0}, events={3: WorkerError("Segmentation fault")})
    results = run(duel)
    assert "Segmentation fault" in results["bench_a"].why
    assert results["bench_b"].verdict.clear


def test_files_that_cannot_be_read_stop_their_benchmarks(run):
    results = run(Duel({"x.py::bench": 0.0, "y.py::bench": 0.0}, broken={"x.py": "a cannot run it: ImportError"}))
    assert results["x.py::bench"].why.startswith("a cannot")
    assert results["y.py::bench"].verdict.clear
    with pytest.raises(WorkerError, match=r"x\.py: a cannot"):
        run(Duel({}, broken={"x.py": "a cannot run it: ImportError"}))


def test_other_answers_are_a_failure_unless_they_may_differ(run, capsys):
    results = run(Duel({"bench": 0.0}, differ=1e-3))
    assert exit_code(results, None, False) == SLOWER_OR_WRONG
    assert exit_code(results, None, True) == ALL_WELL
    report(plan(), results, None)
    said = capsys.readouterr().out
    assert "answers differ by 0.001" in said
    assert "not calibrated here" in said


@pytest.mark.parametrize(
    ("slower", "allowed", "code"), [(0.05, 0.03, 1), (0.05, 0.08, 0), (0.0, 0.0, 0), (-0.1, 0.0, 0)]
)
def test_the_exit_code_says_whether_something_is_slower_than_allowed(run, slower, allowed, code):
    assert exit_code(run(Duel({"bench": slower})), allowed, False) == code


def test_what_is_for_a_higher_level_is_no_failure():
    assert exit_code({"bench": Result("bench", why="Skipped: for level full")}, 0.0, False) == ALL_WELL


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        ([1.0, 2.0], [1.0, 2.0], None),
        ([1.0, 2.0], [1.0, 2.5], 0.25),
        ([0.0], [-0.0], 0.0),  # other bits
        ([1.0], [1.0, 2.0], float("inf")),
        ([], [], None),
    ],
)
def test_answers_differ_relative_to_their_size(a, b, expected):
    assert difference([np.array(a)], [np.array(b)]) == expected
