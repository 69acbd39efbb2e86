"""Is what guards cost measured beside what it says, and on the same states?"""

import re

import pytest
from click.testing import CliRunner

from benchmarks import guarding
from benchmarks.cli import main


def test_the_command_tells_what_each_costs_in_a_world():
    done = CliRunner().invoke(main, ["guards", "-k", "a ball of 42", "--rounds", "3"], catch_exceptions=False)
    assert done.exit_code == 0
    lines = done.output.splitlines()
    assert [line.split(":")[0].partition(", ")[2] for line in lines] == [
        "nothing, which tells the noise",
        "guards in a run",
        "guards of steps one by one",
        "listening, in the shortest run worth it",
    ]
    assert all(
        re.search(r": [+-]\d+\.\d\d % \([+-]\d+\.\d\d … [+-]\d+\.\d\d\) of [\d.e+]+ µs a step", line) for line in lines
    )


def test_sides_that_do_not_do_the_same_are_an_error():
    def more(world, h, steps):
        world.step(h, steps + 1)

    with pytest.raises(AssertionError, match="the answers are not the same"):
        guarding.cost("a ball", "more", lambda: guarding.ball(1), (guarding.guarded, more), (5, 2), 2)
