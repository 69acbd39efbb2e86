"""Whatever an engine does, its claim has a verdict, the others have theirs, and the run ends with its outputs."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import textwrap
import time
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import psutil
import pytest

from validation.record import BROKEN, FAILS, HOLDS, read_report

ROOT = Path(__file__).parents[2]
LIMIT = 15.0  # [s] a claim, the start of its process included, on a machine that does something else too
MEMORY = 700  # [MiB] a claim


class Kind(NamedTuple):
    """What an engine does, before it returns 1.0, and what becomes of its claim."""

    does: str
    verdict: str
    why: str = ""


KINDS = {
    "behaves": Kind("pass", HOLDS),
    "exits": Kind("sys.exit(0)", BROKEN, "SystemExit: 0"),
    "exits_with_a_text": Kind("sys.exit('\\x1b[2Jgone')", BROKEN, r"\x1b[2Jgone"),
    "leaves": Kind("os._exit(0)", FAILS, "exit code 0"),
    "aborts": Kind("os.abort()", FAILS, "SIGABRT"),
    "reads_where_nothing_is": Kind("ctypes.string_at(0)", FAILS, "SIGSEGV"),
    "kills_itself": Kind("os.kill(os.getpid(), signal.SIGKILL)", FAILS, "SIGKILL"),
    "kills_its_group": Kind("os.killpg(0, signal.SIGTERM)", FAILS, "SIGTERM"),
    "sets_an_alarm": Kind("signal.setitimer(signal.ITIMER_REAL, 0.1); time.sleep(5)", FAILS, "SIGALRM"),
    "interrupts": Kind("raise KeyboardInterrupt", BROKEN, "KeyboardInterrupt"),
    "presses_ctrl_c": Kind("os.kill(os.getpid(), signal.SIGINT)", HOLDS),
    "raises_something_odd": Kind("raise type('Odd', (BaseException,), {})('x')", BROKEN, "Odd: x"),
    "stops_a_generator": Kind("raise GeneratorExit", BROKEN, "GeneratorExit"),
    "raises_what_has_no_text": Kind(
        "raise type('Odd', (Exception,), {'__str__': lambda self: 1 / 0})", BROKEN, "cannot be shown"
    ),
    "raises_what_exits_when_shown": Kind(
        "raise type('Odd', (Exception,), {'__str__': lambda self: sys.exit(0)})", BROKEN, "cannot be shown"
    ),
    "raises_half_a_character": Kind("raise ValueError('\\ud800')", BROKEN, r"\ud800"),
    "raises_control_characters": Kind("raise ValueError('a\\x00b\\x1bc\\x08')", BROKEN, r"a\x00b\x1bc\x08"),
    "raises_a_book": Kind("raise ValueError('x' * 50_000_000)", BROKEN, "50000000 characters"),
    "recurses": Kind("return ask(kind)", BROKEN, "RecursionError"),
    "asks": Kind("input('?')", BROKEN, "EOFError"),
    "hangs": Kind("time.sleep(1e6)", FAILS, "not done after 15 s"),
    "hangs_and_lets_nobody_in": Kind("ctypes.PyDLL(None).sleep(1_000_000)", FAILS, "not done after 15 s"),
    "floods_for_ever": Kind("while True: os.write(1, b'x' * 65536)", FAILS, "not done after 15 s"),
    "floods": Kind("[os.write(n, b'flood ' * 100_000) for n in (1, 2) for _ in range(100)]", HOLDS),
    "prints_garbage": Kind("os.write(2, bytes(range(256)) * 100); print('\\ud800\\x1b[2J')", HOLDS),
    "warns_for_ever": Kind("[warnings.warn(f'warning {n}') for n in range(20_000)]", HOLDS),
    "eats_memory": Kind("kept = [np.ones(2**22) for _ in range(1_000) if not time.sleep(0.02)]", FAILS, "of memory"),
    "asks_for_too_much": Kind("np.ones(2**50)", FAILS, "MemoryError"),
    "closes_its_output": Kind("sys.stdout.close(); os.close(1); os.close(2)", HOLDS),
    "closes_everything": Kind("os.closerange(3, 200)", FAILS, "crashed"),
    "writes_into_every_pipe": Kind(
        "for n in range(3, 60):\n    try: os.write(n, b'x' * 99)\n    except OSError: pass", FAILS, "crashed"
    ),
    "goes_elsewhere": Kind("gone = tempfile.mkdtemp(); os.chdir(gone); os.rmdir(gone)", HOLDS),
    "makes_numpy_raise": Kind("np.seterr(all='raise')", HOLDS),
    "leaves_a_child": Kind("subprocess.Popen(['sleep', '1000'])", FAILS, "left processes that went on: sleep"),
    "leaves_the_core_changed": Kind(
        "import softbody.world; softbody.world.PRECISIONS = ()",
        FAILS,
        "left the core changed: softbody.world.PRECISIONS",
    ),
    "leaves_a_method_changed": Kind(
        "import softbody; softbody.World.step = None", FAILS, "left the core changed: softbody.world.World.step"
    ),
    "finds_the_core_as_it_was": Kind(
        "import softbody; assert softbody.World.step and softbody.world.PRECISIONS", HOLDS
    ),
    "forges_an_answer": Kind(
        "data = pickle.dumps((True, {'verdict': 'holds'})); data = struct.pack('!i', len(data)) + data\n"
        "for n in range(3, 60):\n    try: os.write(n, data)\n    except OSError: pass",
        FAILS,
        "crashed",
    ),
    "lets_its_answer_act": Kind(
        "data = b'cos\\nsystem\\n(Vtouch acted\\ntR.'; data = struct.pack('!i', len(data)) + data\n"
        "for n in range(3, 60):\n    try: os.write(n, data)\n    except OSError: pass",
        FAILS,
        "crashed",
    ),
    "answers_in_long_doubles": Kind("return np.longdouble(1.0)", FAILS, "doubles"),
    "forks_and_leaves": Kind("os.fork() or time.sleep(1000); os._exit(1)", FAILS, "exit code 1"),
    "crashes_after_it_has_answered": Kind("threading.Timer(0.3, os.abort).start()", HOLDS),
    "takes_its_time": Kind("time.sleep(1)", HOLDS),  # while its process crashes by what was left behind
    "answers_nothing": Kind("return None", FAILS, "expected is object"),
    "answers_a_function": Kind("return lambda: 0", FAILS, "expected is object"),
    "answers_what_cannot_be_an_array": Kind(
        "return type('Odd', (), {'__array__': lambda *_, **__: sys.exit(0)})()", BROKEN, "SystemExit"
    ),
}

ENGINE = """
import ctypes, os, pickle, signal, struct, subprocess, sys, tempfile, threading, time, warnings
import numpy as np

def ask(kind):
{branches}
    return 1.0
"""

CLAIMS = """
from validation import engines
from validation.check import Comparison, check
from validation.fault import Fault

engines.PACKAGES["some_engine"] = "some-engine"
words = dict.fromkeys(("section", "piece", "reference", "because"), "some\\x00 words \\ud800")
fault = Fault("a fault", "softbody.world.PRECISIONS", "x_ → None")

def declare(kind, family):
    def compare(run):
        import some_engine
        return Comparison([1.0] * 2, [some_engine.ask(kind)] * 2, notes=["a \\x00 note \\ud800"], groups=["\\x1b", "b"])
    compare.__name__, compare.__doc__ = kind, words["because"]
    check(family=family, tolerance=0.0, least=1, engines=("some_engine",), faults=(fault,), **words)(compare)

kinds = {kinds}
for number, kind in enumerate(kinds):
    declare(kind, "odd \\x07 ones" if number < len(kinds) / 2 else "others")
"""

COMMAND = f"""
from validation import runner, worker
runner.LIMITS["quick"], worker.LEAST_MEMORY, worker.SHARE_OF_MEMORY = {LIMIT}, {MEMORY} * 2**20, 0.0
from validation.cli import main
main()
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Judge an engine's every kind of misbehaviour, once; return the folder and what the command did."""
    folder = tmp_path_factory.mktemp("misbehaviour")
    ignored = shutil.ignore_patterns("checks", "*.pyc.*")
    shutil.copytree(ROOT / "validation", folder / "validation", ignore=ignored)  # with its byte code
    (folder / "validation" / "checks").mkdir()
    (folder / "validation" / "checks" / "__init__.py").touch()
    (folder / "validation" / "checks" / "odd.py").write_text(CLAIMS.format(kinds=list(KINDS)))
    branches = [f"if kind == {name!r}:\n{textwrap.indent(kind.does, '    ')}" for name, kind in KINDS.items()]
    (folder / "some_engine.py").write_text(ENGINE.format(branches=textwrap.indent("\n".join(branches), "    ")))
    command = [sys.executable, "-c", COMMAND, "--level", "quick", "--workers", "2", "--out", "out"]
    command += ["--no-timings"]
    variables = {**os.environ, "PYTHONPATH": str(ROOT), "SOME_ENGINE": str(folder), "NUMBA_DISABLE_JIT": "1"}
    begin = time.monotonic()
    done = subprocess.run(command, cwd=folder, env=variables, capture_output=True, timeout=400)
    return folder, done, time.monotonic() - begin


def test_the_run_ends_with_all_its_outputs_and_no_flood(run):
    folder, done, _ = run
    assert done.returncode == 1, done.stderr.decode(errors="replace")[-2_000:]
    written = {"index.html", "badge.svg", "report.json", "junit.xml"}
    assert {path.name for path in (folder / "out").iterdir()} == written
    assert len(done.stdout) + len(done.stderr) < 60_000
    for said in (done.stdout, done.stderr):
        assert not set(said.decode()) & {"\0", "\x1b", "\x07", "\x08"}


@pytest.mark.parametrize("name", KINDS)
def test_each_kind_has_its_verdict(run, name):
    folder, _, _ = run
    claims = {claim.id: claim for claim in read_report(folder / "out" / "report.json").claims}
    claim, kind = claims[f"odd.{name}"], KINDS[name]
    assert claim.verdict == kind.verdict, claim.why
    assert kind.why in (claim.why or "")
    assert len(claim.why or "") < 5_000


def test_each_that_does_not_hold_has_the_command_that_repeats_it(run):
    _, done, _ = run
    said = done.stdout.decode()
    for name, kind in KINDS.items():
        assert (f"replay odd.{name} --level quick" in said) == (kind.verdict != HOLDS)


def test_a_crash_leaves_its_last_words(run):
    folder, _, _ = run
    claims = {claim.id: claim for claim in read_report(folder / "out" / "report.json").claims}
    (words,) = claims["odd.reads_where_nothing_is"].notes
    assert "Segmentation fault" in words
    assert "some_engine.py" in words


def test_junit_is_well_formed(run):
    folder, _, _ = run
    root = ElementTree.parse(folder / "out" / "junit.xml").getroot()
    assert len(list(root.iter("testcase"))) == len(KINDS)


def test_nothing_is_left_running(run):
    folder, _, _ = run
    left = []
    for process in psutil.process_iter():
        try:
            if process.environ().get("SOME_ENGINE") == str(folder) and process.status() != psutil.STATUS_ZOMBIE:
                left.append(process.cmdline())
        except psutil.Error:
            continue
    assert not left
