"""Is it told how far a run is, where there is a terminal with rich and where there is none?"""

import io
import sys

import pytest

from softbody.cli import progress


@pytest.fixture
def clock(monkeypatch):
    """A clock that is set."""
    now = [100.0]
    monkeypatch.setattr(progress, "monotonic", lambda: now[0])
    return now


@pytest.mark.parametrize("missing", [True, False])
def test_lines_come_now_and_then_with_the_time_left(capsys, monkeypatch, clock, missing):
    if missing:
        monkeypatch.setitem(sys.modules, "rich.console", None)
    with progress.reporter(1000, 100) as tell:
        for k in range(101, 301):
            clock[0] += 0.125
            tell(k)
    told = capsys.readouterr()
    assert told.out == ""
    # A frame takes an eighth of a second: after 5 s, 860 are left.
    assert told.err.splitlines()[0] == "frame 140 of 1000, 0:01:48 left"
    assert len(told.err.splitlines()) == 5


def test_a_terminal_has_a_bar(monkeypatch):
    pytest.importorskip("rich")
    screen = io.StringIO()
    screen.isatty = lambda: True
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "100")
    with progress.reporter(10, 2) as tell:
        tell(7)
    assert "7/10" in screen.getvalue()
