"""Is who waits for kernels told what for, once, and nobody else?"""

import io
import logging
import time

import pytest

from softbody.compiler import notice


@pytest.fixture(autouse=True)
def impatient(monkeypatch):
    monkeypatch.setattr(notice, "AFTER", 0.01)
    monkeypatch.setattr(notice, "_is_said", False)


def wait(seconds):
    with notice.told_if_long():
        time.sleep(seconds)


def test_a_long_wait_is_told_once_to_the_log(caplog):
    caplog.set_level(logging.INFO, "softbody")
    wait(0.2)
    wait(0.2)
    assert [record.getMessage() for record in caplog.records] == [notice.TEXT]


def test_a_short_wait_is_not_told(caplog, monkeypatch):
    monkeypatch.setattr(notice, "AFTER", 0.2)
    caplog.set_level(logging.INFO, "softbody")
    wait(0.0)
    time.sleep(0.4)
    assert not caplog.records


def test_on_a_terminal_it_is_printed(monkeypatch, caplog):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    caplog.set_level(logging.INFO, "softbody")
    wait(0.2)
    assert terminal.getvalue() == f"{notice.TEXT}\n"
    assert not caplog.records
