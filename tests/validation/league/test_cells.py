"""A cell says how wrong an engine is, and what its steps cost; whatever an engine does, it is said and not raised."""

from __future__ import annotations

import time
from types import SimpleNamespace

import numpy as np
import pytest

from validation import effort
from validation.check import Check, Comparison, Run
from validation.effort import Effort
from validation.league.cells import ANSWERED, Asked, CannotTryError, Cell, efforts, play, refined, weigh
from validation.record import FAILS, NOT_RUN
from validation.subject import CLAIMS, Boxes, SubjectClaim, checks_of

ONE = Boxes(np.ones((1, 3)), np.ones(1), np.zeros((1, 3)), np.eye(4)[:1], np.zeros((1, 3)), np.zeros((1, 3)))


@pytest.mark.parametrize(
    ("question", "factor", "answer"),
    [
        ((0.01, 1000, 1000), 4.0, (0.0025, 4000, 4000)),
        ((0.01, 1000, 1000), 0.25, (0.04, 250, 250)),
        ((0.01, 10, 10), 0.25, (0.05, 2, 2)),
        ((0.01, 100, 4), 0.25, (0.04, 25, 1)),
        ((0.01, 100, 4), 1.0, (0.01, 100, 4)),
    ],
)
def test_a_question_with_other_steps_ends_at_the_same_time(question, factor, answer):
    step, steps, every = refined(*question, factor)
    assert (step, steps, every) == pytest.approx(answer)
    assert step * steps == pytest.approx(question[0] * question[1])
    assert steps // every == question[1] // question[2], "as many frames"


def test_a_motion_that_is_looked_at_at_each_step_has_no_longer_steps():
    with pytest.raises(CannotTryError, match="each 2"):
        refined(0.01, 100, 2, 0.25)


def test_what_an_engine_works_is_counted_by_second_of_its_world_and_its_first_step_is_not():
    calls = []

    def engine(boxes, step, steps, every):
        calls.append((step, steps, effort.iterations(10), effort.finer()))
        if len(calls) == 1:
            time.sleep(0.05)  # it compiles
        with effort.spending():
            until = time.process_time() + 1e-3 * steps
            while time.process_time() < until:
                pass

    asked = Asked(engine, "move_boxes", Effort(steps=2.0, iterations=3.0))
    asked(ONE, 0.1, 5, 5)
    asked(ONE, 0.1, 5, 5)
    assert calls == [(0.05, 1, 30, 2.0), (0.05, 10, 30, 2.0), (0.05, 10, 30, 2.0)]
    assert effort.iterations(10) == 10, "as usual again"
    assert asked.costs == pytest.approx([0.02, 0.02], rel=0.5)


def claim(unit: str = "relative") -> SubjectClaim:
    words = {"family": "", "claim": "", "section": "", "piece": "", "reference": "", "engines": (), "because": ""}
    return SubjectClaim(Check(id="a.b", unit=unit, tolerance=0.1, compare=None, **words), "gas_volume", None, 0)  # type: ignore[arg-type]


def test_an_error_is_the_worst_and_bias_and_scatter_are_of_all():
    cell = Cell("a.b", "x", 1.0, 1.0)
    weigh(cell, claim(), Comparison([1.0, 2.0, 4.0], [1.0, 1.0, 1.0], 2.0))
    assert (cell.state, cell.n, cell.error, cell.median) == (ANSWERED, 3, 1.5, 0.5)
    assert cell.bias == pytest.approx(2.0 / 3.0)
    assert cell.scatter == pytest.approx(np.std([0.0, 0.5, 1.5]))


def test_yes_or_no_is_the_share_that_is_wrong():
    cell = Cell("a.b", "x", 1.0, 1.0)
    weigh(cell, claim("disagreements"), Comparison(np.array([True, False]), np.array([True, True])))
    assert (cell.error, cell.bias) == (0.5, None)


def test_an_answer_that_is_no_number_fails():
    cell = Cell("a.b", "x", 1.0, 1.0)
    weigh(cell, claim(), Comparison([1.0, np.nan], [1.0, 1.5]))
    assert cell.state == FAILS
    assert cell.why == "1 of 2 answers are not finite"


@pytest.mark.parametrize(
    ("raised", "state", "why"),
    [
        (RuntimeError("no\x1b[2J licence"), FAILS, "raised RuntimeError: no\\x1b[2J licence"),
        (SystemExit(0), FAILS, "raised SystemExit: 0"),
        (ModuleNotFoundError("No module named 'acme'"), NOT_RUN, "No module named 'acme'"),
    ],
)
def test_what_an_engine_raises_is_in_its_cell(monkeypatch, raised, state, why):
    def answer(*_):
        raise raised

    import validation.subjects.igl as adapter

    monkeypatch.setattr(adapter, "points_in_mesh", answer)
    told = play("inside.anywhere", "igl", "quick", 1, 1.0, 1.0)
    assert (told["state"], told["why"], told["error"], told["costs"]) == (state, why, None, [])


def test_engines_try_as_usual_first_and_no_effort_twice():
    checks_of("softbody")
    for name in ("boxes.fly", "gas.rest", "inside.anywhere"):
        tried = list(efforts(CLAIMS[name], "standard"))
        assert tried[0] == Effort()
        assert len(set(tried)) == len(tried)
    assert len(list(efforts(CLAIMS["inside.anywhere"], "full"))) == 1


def test_a_task_is_the_same_for_all_engines_and_at_every_effort(monkeypatch):
    checks_of("igl")
    seen = []

    def ask(points, *_):
        seen.append(points)
        return np.zeros(len(points), bool)

    for _ in range(2):
        CLAIMS["inside.anywhere"].compare(Run("quick", 1, "inside.anywhere"), ask)
    assert np.array_equal(seen[0], seen[2])


def test_an_engine_is_known_by_what_its_adapter_answers():
    told = play("boxes.fly", "softbody", "quick", 1, 1.0, 1.0)
    cell = SimpleNamespace(**told)
    assert cell.state == ANSWERED
    assert cell.error < 1e-12
    assert 0.0 < cell.costs[0] <= cell.costs[1] <= cell.costs[2]
