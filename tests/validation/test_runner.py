"""Workers take lane after lane, so that nothing is compiled twice, and help each other in the end."""

from __future__ import annotations

import os
import time

from validation.runner import run_tasks
from validation.worker import Task


def who(seconds: float) -> int:
    """Take so long, and say which process did it."""
    time.sleep(seconds)
    return os.getpid()


def told(lanes: list[list[str]], jobs: int) -> tuple[list[str], dict[str, int]]:
    """Return what began and what ended, in order, and by which process each task was done."""
    said: list[str] = []
    done = {}
    tasks = [[Task(name, who, (0.4,), 60.0) for name in lane] for lane in lanes]
    for ended in run_tasks(tasks, jobs, lambda name: said.append(f"begin {name}")):
        assert ended.how is None, ended.why
        said.append(f"end {ended.task.name}")
        done[ended.task.name] = ended.answer
    return said, done


def test_a_lane_is_shared_when_its_first_task_has_ended() -> None:
    said, done = told([["a", "b", "c", "d", "e"]], 2)
    assert said[:2] == ["begin a", "end a"]
    assert sorted(done) == ["a", "b", "c", "d", "e"]
    assert len(set(done.values())) == 2


def test_lanes_that_wait_come_first() -> None:
    said, done = told([["a", "b", "c", "d"], ["x"], ["y"]], 2)
    assert said[:2] == ["begin a", "begin x"]
    assert done["a"] != done["x"] == done["y"]
    begun = [line for line in said if line.startswith("begin")]
    assert begun.index("begin y") < begun.index("begin d")
    assert len({done[name] for name in "abcd"}) == 2, "who was idle helped"


def test_one_worker_does_all_in_order() -> None:
    said, done = told([["a", "b"], ["x"]], 1)
    assert said == [f"{what} {name}" for name in "abx" for what in ("begin", "end")]
    assert len(set(done.values())) == 1
