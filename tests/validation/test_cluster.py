"""A cluster's workers come to the same records as processes here, lost or not; one that cannot judge is refused."""

from __future__ import annotations

import json
import os
import platform
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.validation.test_run import command, place, run, variables  # noqa: F401
from validation.cluster import differences

pytest.importorskip("distributed", reason="not run: distributed is not installed (extra: cluster)")

PATIENCE = 60.0  # seconds for what takes two or three
Start = Callable[..., subprocess.Popen[bytes]]


def wait_until(done: Callable[[], Any]) -> Any:
    """Return what `done` returns as soon as it is true."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        found = done()
        if found:
            return found
        time.sleep(0.05)
    raise TimeoutError(f"it did not come about in {PATIENCE:g} s")


@pytest.fixture
def start() -> Iterator[Start]:
    """Return a function that starts one of dask's commands in a folder; all are ended with the test."""
    begun: list[subprocess.Popen[bytes]] = []

    def begin(folder: Path, name: str, *options: str) -> subprocess.Popen[bytes]:
        call = [sys.executable, "-m", f"distributed.cli.dask_{name}", *options]
        if name == "scheduler":
            call += ["--port", "0", "--dashboard-address", ":0", "--scheduler-file", str(folder / "scheduler.json")]
        process = subprocess.Popen(
            call,
            cwd=folder,
            env=variables(),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        begun.append(process)
        return process

    yield begin
    for process in begun:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def scheduler_of(folder: Path, start: Start) -> str:
    """Start a scheduler; return its address."""
    start(folder, "scheduler")
    return address_in(folder)


def address_in(folder: Path) -> str:
    """Return the address of the scheduler that was started in a folder, as soon as it has one."""
    file = folder / "scheduler.json"
    address: str = wait_until(lambda: file.exists() and file.read_text() and json.loads(file.read_text())["address"])
    return address


def workers_of(folder: Path, address: str, start: Start, *kinds: str) -> list[subprocess.Popen[bytes]]:
    """Start a worker of each kind, with or without a nanny, and wait for all."""
    from distributed import Client

    options = "--nthreads", "1", "--no-dashboard"
    workers = [start(folder, "worker", address, *options, kind) for kind in kinds]
    with Client(address, timeout=PATIENCE, set_as_default=False) as client:
        client.wait_for_workers(len(kinds), timeout=PATIENCE)
    return workers


def with_other_claims(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the same validation, but for a claim."""
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    shutil.copytree(folder / "validation", elsewhere / "validation")
    many = elsewhere / "validation" / "checks" / "many.py"
    many.write_text(many.read_text().replace("1e-12", "1e-13"))
    return elsewhere


def records_of(folder: Path, out: str) -> list[dict[str, Any]]:
    """Return what a run has found, without times, in order of the claims."""
    claims = json.loads((folder / out / "report.json").read_text(encoding="utf-8"))["claims"]
    return [{key: value for key, value in claim.items() if key != "seconds"} for claim in claims]


def test_a_cluster_comes_to_the_same_bits_also_where_a_worker_is_lost(place, start):  # noqa: F811
    folder = place(count=9, seconds=0.4)
    assert run(folder, "--out", "here", "--jobs", "2").returncode == 0
    address = scheduler_of(folder, start)
    first, _ = workers_of(folder, address, start, "--no-nanny", "--nanny")
    ours = subprocess.Popen(
        command("--out", "cluster", "--scheduler", address), cwd=folder, env=variables(), stderr=subprocess.PIPE
    )
    journal = folder / "cluster" / "claims.jsonl"
    wait_until(lambda: journal.exists() and journal.read_bytes().count(b"\n") >= 3)
    os.killpg(first.pid, signal.SIGKILL)
    _, said = ours.communicate(timeout=PATIENCE)
    assert ours.returncode == 0, said.decode()
    assert len(records_of(folder, "here")) == 9
    assert records_of(folder, "cluster") == records_of(folder, "here")


def test_a_cluster_that_cannot_judge_is_refused_before_any_work(place, start, tmp_path_factory):  # noqa: F811
    folder = place(count=2)
    nobody = run(folder, "--out", "o", "--scheduler", "tcp://127.0.0.1:1")
    assert nobody.returncode == 5
    assert "no scheduler answers at tcp://127.0.0.1:1" in nobody.stderr
    address = scheduler_of(folder, start)
    idle = run(folder, "--out", "o", "--scheduler", address)
    assert idle.returncode == 5
    assert f"dask worker {address}" in idle.stderr
    workers_of(with_other_claims(folder, tmp_path_factory), address, start, "--no-nanny")
    other = run(folder, "--out", "o", "--scheduler", address)
    assert other.returncode == 5
    assert "has other claims or references" in other.stderr
    assert not (folder / "o" / "claims.jsonl").exists()


def test_a_run_whose_workers_are_all_lost_says_so_and_goes_on_with_others(place, start):  # noqa: F811
    folder = place(count=4, seconds=0.4)
    address = scheduler_of(folder, start)
    (only,) = workers_of(folder, address, start, "--no-nanny")
    said = folder / "said"
    with said.open("wb") as errors:
        ours = subprocess.Popen(
            command("--out", "o", "--scheduler", address), cwd=folder, env=variables(), stderr=errors
        )
    wait_until(lambda: (folder / "o" / "claims.jsonl").exists())
    os.killpg(only.pid, signal.SIGKILL)
    wait_until(
        lambda: (
            f"No worker is left, and nothing goes on until there is one: start some with `dask worker {address}"
            in said.read_text()
        )
    )
    workers_of(folder, address, start, "--no-nanny")
    assert ours.wait(PATIENCE) == 0
    assert "There are workers again." in said.read_text()
    assert {claim["verdict"] for claim in records_of(folder, "o")} == {"holds"}


def test_a_run_that_loses_its_scheduler_keeps_what_is_done_with_its_page(place, start):  # noqa: F811
    folder = place(count=6, seconds=0.4)
    scheduler = start(folder, "scheduler")
    address = address_in(folder)
    workers_of(folder, address, start, "--no-nanny")
    ours = subprocess.Popen(
        command("--out", "o", "--scheduler", address), cwd=folder, env=variables(), stderr=subprocess.PIPE
    )
    journal = folder / "o" / "claims.jsonl"
    wait_until(lambda: journal.exists() and journal.read_bytes().count(b"\n") >= 3)
    os.killpg(scheduler.pid, signal.SIGKILL)
    _, said = ours.communicate(timeout=PATIENCE)
    assert ours.returncode == 5
    # Between two claims, none is under way that could be named.
    assert re.search(rf"the scheduler at {address} was lost in the claims(, at many\.one_\d)?: ", said.decode())
    assert "--resume" in said.decode()
    verdicts = [claim["verdict"] for claim in records_of(folder, "o")]
    assert 2 <= verdicts.count("holds") < len(verdicts) == 6
    assert (folder / "o" / "index.html").exists()
    assert run(folder, "--out", "o", "--resume").returncode == 0
    assert {claim["verdict"] for claim in records_of(folder, "o")} == {"holds"}


def test_a_worker_that_comes_later_with_other_claims_stops_the_run_by_name(place, start, tmp_path_factory):  # noqa: F811
    folder = place(count=6, seconds=0.4)
    address = scheduler_of(folder, start)
    (first,) = workers_of(folder, address, start, "--no-nanny")
    ours = subprocess.Popen(
        command("--out", "o", "--scheduler", address), cwd=folder, env=variables(), stderr=subprocess.PIPE
    )
    journal = folder / "o" / "claims.jsonl"
    wait_until(lambda: journal.exists() and journal.read_bytes().count(b"\n") >= 2)
    start(
        with_other_claims(folder, tmp_path_factory),
        "worker",
        address,
        "--nthreads",
        "1",
        "--no-dashboard",
        "--no-nanny",
    )
    os.killpg(first.pid, signal.SIGKILL)
    _, said = ours.communicate(timeout=PATIENCE)
    assert ours.returncode == 5
    assert f"a worker on {platform.node()} has other claims or references" in said.decode()
    assert "Traceback" not in said.decode()


def test_a_worker_that_ends_the_process_of_a_claim_goes_on(place, start):  # noqa: F811
    folder = place(count=3)
    many = folder / "validation" / "checks" / "many.py"
    many.write_text(
        many.read_text().replace("time.sleep", "number == 1 and __import__('os')._exit(7)\n        time.sleep")
    )
    address = scheduler_of(folder, start)
    workers_of(folder, address, start, "--nanny")
    done = run(folder, "--out", "o", "--scheduler", address)
    assert done.returncode == 1
    found = {claim["id"]: (claim["verdict"], claim["why"]) for claim in records_of(folder, "o")}
    assert [verdict for verdict, _ in found.values()].count("holds") == 2
    assert "exit code 7" in found["many.one_1"][1]


def test_what_differs_is_named():
    ours = {"core": "a", "claims": "b", "python": "3.11.2", "engines": {"fcl": "1", "coal": "3"}}
    assert differences(ours, ours) == []
    theirs = {"core": "c", "claims": "d", "python": "3.12.0", "engines": {"fcl": "2", "coal": "3"}}
    assert differences(theirs, ours) == [
        "another core", "other claims or references", "Python 3.12.0", "other versions of fcl"
    ]  # fmt: skip
