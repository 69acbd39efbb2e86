"""Every claim can fail: damage the core under it, and it turns red.

Each fault, in the tables of `faults/`, is one edit to a copy of the core. The claims named with it are judged on
the damaged copy by the real command, in a process of their own, and must fail; on the sound core they hold.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest
import tomllib

from validation.check import all_checks
from validation.engines import missing

ROOT = Path(__file__).parents[2]
FOLDER = Path(__file__).with_name("faults")


class Fault(NamedTuple):
    """One edit: the first `right` in `file` becomes `wrong`, and the claims in `red` must fail."""

    file: str
    right: str
    wrong: str
    red: tuple[str, ...]


def planted_faults() -> dict[str, Fault]:
    """Return every fault of the tables in `faults/`, by name."""
    tables = [tomllib.loads(path.read_text(encoding="utf-8")) for path in sorted(FOLDER.glob("*.toml"))]
    rows = [row for table in tables for row in table["fault"]]
    faults = {row["name"]: Fault(row["file"], row["right"], row["wrong"], tuple(row["red"])) for row in rows}
    assert len(faults) == len(rows), "two faults have the same name"
    return faults


FAULTS = planted_faults()


def verdicts_on(folder: Path, claims: tuple[str, ...]) -> dict[str, str]:
    """Judge claims on the core that lies in `folder`; return their verdicts."""
    command = [sys.executable, "-m", "validation", "--level", "quick", "--no-timings", "--jobs", "1", "--out", "out"]
    for claim in claims:
        command += ["-k", claim]
    # The working folder comes first on the path: the core is the copy there, everything else the repository's.
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=600)
    assert done.returncode == 1, done.stderr
    report = json.loads((folder / "out" / "report.json").read_text(encoding="utf-8"))
    return {claim["id"]: claim["verdict"] for claim in report["claims"] if claim["id"] in claims}


@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_turns_its_claims_red(name: str, tmp_path: Path) -> None:
    fault = FAULTS[name]
    absent = missing(tuple(engine for claim in fault.red for engine in all_checks()[claim].engines))
    if absent:
        pytest.skip(f"{absent[0]} is not installed")
    copy = tmp_path / "softbody"
    shutil.copytree(ROOT / "softbody", copy, ignore=shutil.ignore_patterns("__pycache__"))
    source = (copy / fault.file).read_text(encoding="utf-8")
    assert fault.right in source, f"{fault.file} no longer holds {fault.right!r}: plant the fault elsewhere"
    (copy / fault.file).write_text(source.replace(fault.right, fault.wrong, 1), encoding="utf-8")
    assert verdicts_on(tmp_path, fault.red) == dict.fromkeys(fault.red, "fails")


def test_every_claim_has_a_planted_fault() -> None:
    covered = {claim for fault in FAULTS.values() for claim in fault.red}
    assert covered == set(all_checks())
