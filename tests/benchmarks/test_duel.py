"""Two workers in lock step: the ratio is that of their times, and whoever fails or answers otherwise is named."""

from __future__ import annotations

import math
import random
from pathlib import Path

import numpy as np
import pytest

from benchmarks.duel import Duel, UnableError
from benchmarks.race import Race, arrays_of
from benchmarks.serving import times_of
from benchmarks.sides import Side
from benchmarks.worker import WorkerError


class FakeWorker:
    """A worker whose calls take `seconds`, and whose answers are `first` and then `last`."""

    def __init__(self, name, seconds=0.02, first=1.0, last=None, why=None, fails=False, has=("bench",), core=None):
        self.side = Side(name, name, Path(name))
        self.seconds, self.why, self.fails = seconds, why, fails
        self.answers = [[np.array(first)], [np.array(first if last is None else last)]]
        self.replies = [{"benchmarks": list(has), "broken": {}, "core": core or f"{name}/softbody/__init__.py"}]

    def tell(self, message):
        if isinstance(message, tuple):  # open
            times = 9.0 * self.seconds, self.seconds
            ready = {"answer": self.answers[0], "times": times, "threads": 1}
            self.replies.append({"why": self.why} if self.why else ready)
        elif message is None:  # close
            self.replies += [{"answer": self.answers[1]}, {"why": None}]
        else:
            self.replies.append({"why": "ValueError"} if self.fails else (9.0 * self.seconds, message * self.seconds))

    def hear(self):
        return self.replies.pop(0)


def duel(a=None, b=None):
    return Duel([FakeWorker("a", **(a or {})), FakeWorker("b", **(b or {}))], random.Random(1))


def test_the_ratio_is_that_of_the_processor_s_time():
    opening, differ = duel({"seconds": 0.002}, {"seconds": 0.003}).open("bench")
    assert opening.ratio == pytest.approx(math.log(1.5))
    assert opening.seconds == pytest.approx((0.002, 0.003))
    assert differ is None


def test_a_duel_can_be_opened_again():
    both = duel()
    assert both.open("bench") == both.open("bench")
    assert all(worker.replies == [] for worker in both.workers)


def test_answers_that_differ_are_measured():
    assert duel({"first": 2.0}, {"first": 2.5}).open("bench")[1] == 0.25


@pytest.mark.parametrize(
    ("a", "b", "said"),
    [
        ({}, {"why": "ImportError"}, "^b cannot run it: ImportError"),
        ({"why": "Skipped: x"}, {"why": "Skipped: x"}, "^Skipped: x"),
        ({"has": ()}, {}, "^a has no such benchmark"),
    ],
)
def test_a_side_that_cannot_run_it_is_named_and_the_other_closed(a, b, said):
    both = duel(a, b)
    with pytest.raises(UnableError, match=said):
        both.open("bench")
    assert all(worker.replies == [] for worker in both.workers)


@pytest.mark.parametrize(
    ("b", "said"), [({"fails": True}, "b fails: ValueError"), ({"last": 1.5}, "b answers differently when asked again")]
)
def test_a_side_that_fails_in_the_middle_is_named(b, said):
    with pytest.raises(WorkerError, match=said):
        duel({}, b).open("bench")


def test_a_worker_with_another_core_is_refused():
    with pytest.raises(WorkerError, match="was to be taken from b, not elsewhere"):
        duel({}, {"core": "elsewhere"})


def race_of(ours, **more):
    return Race(ours, 1, table="t", name="n", size=1, of="o", per="p", **more)


def test_every_call_starts_from_what_was_put_back():
    state, seen = [0], []

    def call():
        state[0] += 1
        seen.append(state[0])

    clock, cpu = times_of(race_of(call, restore=lambda: state.__setitem__(0, 0)), 5)
    assert seen == [1] * 5
    assert clock > 0.0
    assert cpu > 0.0


def test_an_answer_is_what_is_returned_or_asked_for():
    assert race_of(lambda: (1, np.arange(2))).ask()[1].tolist() == [0, 1]
    assert race_of(lambda: None, answer=lambda: 3.0).ask() == [3.0]
    with pytest.raises(ValueError, match="answer="):
        race_of(lambda: None).ask()
    with pytest.raises(TypeError, match="type str cannot be compared"):
        arrays_of("text")
