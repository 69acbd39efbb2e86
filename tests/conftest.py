"""What every test shares: Hypothesis that draws the same examples each time, and Ctrl-C that is heard.

Slow tests come first, so that no worker waits for one at the end.
"""

import signal
from itertools import chain

import pytest
from hypothesis import HealthCheck, settings

# Files, or tests of a file, that take longest, for one worker of two and for the other: where one compiles, the other
# starts processes, so that both seldom compile the same.
SLOW = (
    "tests/softbody/compiler/test_interrupts.py",
    "tests/test_fuzz.py",
    "tests/test_examples.py",
    "tests/validation/test_misbehaviour.py",
    "tests/test_pages.py",
    "tests/softbody/view/test_serving.py",
    "tests/softbody/test_world.py",
    "tests/validation/test_cluster.py",
    "tests/softbody/compiler/test_jit.py",
    "tests/benchmarks/test_cli.py",
    "tests/softbody/stepping/test_substeps.py",
    "tests/validation/test_run.py",
    "tests/softbody/dynamics/test_particle_ground.py",
    "tests/validation/test_cli.py",
)

# A first call compiles for seconds, and a busy machine is slow: neither is an error.
settings.register_profile("softbody", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("softbody")


def pytest_configure() -> None:
    """Hear Ctrl-C: what a script starts in the background ignores it, and so would every process it starts."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(trylast=True)  # of the tests that are selected
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Put slow tests at the head of each worker's share, which is a row of consecutive ones."""
    workers = getattr(config, "workerinput", {}).get("workercount", 1)
    ranks = [[item for item in items if item.nodeid.startswith(name)] for name in SLOW]
    first = [list(chain(*ranks[worker::workers])) for worker in range(workers)]
    known = {item for share in first for item in share}
    rest = [item for item in items if item not in known]
    shares, begin = [], 0
    for worker, share in enumerate(first):
        end = max(begin, round(len(items) * (worker + 1) / workers) - sum(map(len, first[: worker + 1])))
        shares += share + rest[begin : end if worker < workers - 1 else None]
        begin = end
    items[:] = shares
