"""Import and export of what was measured: JSON lines, and pytest-benchmark's own JSON."""

from __future__ import annotations

import json
import os
from pathlib import Path

import click

from benchmarks.history import History, Record, run_record


def export(records: list[Record], path: Path) -> int:
    """Write runs to a file: every run a line (.jsonl), or the newest alone as pytest-benchmark has it (.json)."""
    if not records:
        raise click.ClickException("there is nothing to export; `python -m benchmarks run` measures something")
    if path.suffix == ".jsonl":
        text, count = "".join(json.dumps(record.document) + "\n" for record in records), len(records)
    elif path.suffix == ".json":
        text, count = json.dumps(records[-1].document, indent=1), 1
    else:
        raise click.UsageError(
            f"{path}: end it with .jsonl for every run, or .json for the newest as pytest-benchmark has it"
        )
    write_whole(path, text)
    return count


def import_file(path: Path, history: History) -> int:
    """Add what `export`, or pytest-benchmark, has written; return how many runs are new. Bad lines are said."""
    text = path.read_text(encoding="utf-8")
    records = []
    for number, line in enumerate(text.splitlines() if path.suffix == ".jsonl" else [text], 1):
        try:
            records.append(run_record(json.loads(line)))
        except (ValueError, click.ClickException) as error:
            history.said(f"{path}, line {number}: left out, {getattr(error, 'message', error)}")
    return history.add(records)


def write_whole(path: Path, text: str) -> None:
    """Write a file whole or not at all."""
    temporary = path.with_name(f".{path.name}.part")
    try:
        with temporary.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise click.ClickException(f"{path} cannot be written: {error.strerror}") from error
