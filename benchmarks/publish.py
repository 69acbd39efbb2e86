"""Trends for other programs: a document, of which `reports` makes a page in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from benchmarks.calibration import Calibration
from benchmarks.exchange import write_whole
from benchmarks.history import Record
from benchmarks.running import Document
from benchmarks.steps import FEWEST
from benchmarks.trends import Trend, revision_of

SCHEMA = "softbody-trends/1"


def publish(document: Document, folder: Path) -> None:
    """Write trends.json into a folder, and have trends.html made of it; each is whole or as it was before."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise click.ClickException(f"{folder} cannot be made: {error.strerror}; choose another folder") from error
    write_whole(folder / "trends.json", json.dumps(document, indent=1, ensure_ascii=False) + "\n")
    made = subprocess.run([sys.executable, "-m", "reports.trends", str(folder)], capture_output=True, text=True)
    if made.returncode:
        why = (made.stderr.strip().splitlines() or ["it ended"])[-1]
        raise click.ClickException(f"{folder / 'trends.html'} could not be made: {why}")


def document_of(records: Sequence[Record], trends: Sequence[Trend], calibration: Calibration | None) -> Document:
    """Return the trends of runs, oldest first, and on what they were measured (schema: `reports.trends_document`)."""
    return {
        "schema": SCHEMA,
        "machine": _machine(records[-1]),
        "runs": [_run(record) for record in records],
        "fewest": 2 * FEWEST,
        "calibration": calibration
        and {
            "started": calibration.started,
            "revision": calibration.revision,
            "load": calibration.load,
            "rates": [asdict(rate) for rate in calibration.rates],
        },
        "trends": [_trend(trend) for trend in trends],
    }


def _machine(record: Record) -> dict[str, str]:
    """Return what the newest run says of the machine."""
    info = record.document["machine_info"]
    cpu = info.get("cpu") or {}
    found = {
        "processor": cpu.get("brand_raw"),
        "cores": cpu.get("count"),
        "system": f"{info.get('system')} {info.get('machine')}",
        "Python": info.get("python_version"),
        "checksum": record.machine,
    }
    return {name: str(value) for name, value in found.items() if value}


def _run(record: Record) -> dict[str, Any]:
    said = record.document["machine_info"].get("softbody") or {}
    return {
        "started": record.started,
        "revision": revision_of(record),
        "level": said.get("level"),
        "load": said.get("load"),
        "versions": said.get("versions") or {},
    }


def _trend(trend: Trend) -> dict[str, Any]:
    file, _, name = trend.name.partition("::")
    return {
        "file": file,
        "name": name,
        "row": trend.row,
        "peer": trend.peer,
        "started": trend.started,
        "values": trend.values,
        "steps": [asdict(step) for step in trend.steps],
    }
