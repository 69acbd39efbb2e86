"""Run the project's own tests: those of logic without the compiler, then all others with it.

Most of the time of a test that steps a world goes into compiling that kind of world; its bits are the same without. So
tests with the mark `interpreted` run as plain Python (NUMBA_DISABLE_JIT=1) in a pass of their own; where a whole file
has it, the mark `compiled` takes single ones out. Arguments are pytest's, for both passes:

    python -m tests -k joint
"""

from __future__ import annotations

import argparse
import contextlib
import os
import signal
import subprocess
import sys

PASSES = (  # which tests, in which environment
    ("interpreted and not compiled", {"NUMBA_DISABLE_JIT": "1"}),
    ("not interpreted or compiled", {}),
)
DEFAULTS = ["-n", "auto", "--dist", "worksteal"]
FAILED, INTERRUPTED, NO_TESTS = 1, 2, 5  # exit codes of pytest
PATIENCE = 10.0  # [s] that a pass has to end by itself, before it is told that it was interrupted


def main(arguments: list[str]) -> int:
    """Run both passes; return the gravest exit code, which is that of no tests only if neither has any."""
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("-m", dest="mark", default="")
    parser.add_argument("-x", "--exitfirst", dest="stops", action="store_true")
    asked, _ = parser.parse_known_args(arguments)
    codes = []
    for mark, environment in PASSES:
        selection = f"({asked.mark}) and ({mark})" if asked.mark else mark
        codes.append(_ended([*DEFAULTS, *arguments, "-m", selection], os.environ | environment))
        if codes[-1] not in (0, FAILED, NO_TESTS) or (codes[-1] == FAILED and asked.stops):
            break
    return max((code for code in codes if code != NO_TESTS), default=NO_TESTS)


def _ended(arguments: list[str], environment: dict[str, str]) -> int:
    """Run pytest to its end, also after Ctrl-C; return its exit code."""
    process = subprocess.Popen([sys.executable, "-m", "pytest", *arguments], env=environment)
    try:
        code = process.wait()
    except KeyboardInterrupt:  # the terminal tells both processes, a script perhaps this one only
        with contextlib.suppress(KeyboardInterrupt, subprocess.TimeoutExpired):
            return process.wait(PATIENCE) or INTERRUPTED
        process.send_signal(signal.SIGINT)
        return process.wait() or INTERRUPTED
    return code if code >= 0 else 128 - code  # ended by a signal, as a shell says it


if __name__ == "__main__":
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as it is for what a script starts in the background
        signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.exit(main(sys.argv[1:]))
