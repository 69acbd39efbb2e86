"""What was measured before: one SQLite file, a row a run. The row holds pytest-benchmark's own document, compressed.

So nothing is lost between the two, and damage is noticed: the compression carries a checksum. A row that is damaged is
skipped and said; a file that is no history any more is put aside, and a new one begun.
"""

from __future__ import annotations

import hashlib
import json
import sqlite3
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import click

from benchmarks.machine import checksum
from benchmarks.running import Document

PATIENCE = 60.0  # [s] to wait for another writer
TABLE = """CREATE TABLE IF NOT EXISTS record (
    digest TEXT PRIMARY KEY,  -- of the document: what is there already is not added again
    kind TEXT NOT NULL,       -- run, or calibration
    started TEXT NOT NULL,    -- ISO 8601
    machine TEXT NOT NULL,    -- its checksum
    document BLOB NOT NULL    -- JSON, compressed by zlib
)"""

Said = Callable[[str], None]


@dataclass(frozen=True)
class Record:
    """One row."""

    kind: str
    started: str
    machine: str
    document: Document


class History:
    """The file at a path, which need not be there yet; `said` hears of damage."""

    def __init__(self, path: Path, said: Said = lambda line: click.echo(line, err=True)) -> None:
        self.path, self.said = path, said

    def add(self, records: Iterable[Record]) -> int:
        """Store records, all or none; return how many are new. Raises ClickException, for one on a full disk."""
        rows = [(_digest(record.document), *_columns(record), _packed(record.document)) for record in records]
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with self._opened() as database:
                database.execute("BEGIN IMMEDIATE")  # a second writer waits here
                count = sum(
                    database.execute("INSERT OR IGNORE INTO record VALUES (?, ?, ?, ?, ?)", row).rowcount
                    for row in rows
                )
                database.execute("COMMIT")
        except (sqlite3.Error, OSError) as error:
            raise click.ClickException(
                f"nothing was added to {self.path}, and nothing in it is lost: {error}; free some room, or choose "
                "another file with --history"
            ) from error
        return count

    def records(self, kind: str = "run", machine: str | None = None) -> list[Record]:
        """Return what was stored, oldest first, of one machine or of all."""
        if not self.path.exists():
            return []
        try:
            with self._opened() as database:
                rows = list(
                    database.execute("SELECT kind, started, machine, document FROM record ORDER BY started, digest")
                )
        except (sqlite3.Error, OSError) as error:
            raise click.ClickException(
                f"{self.path} cannot be read: {error}; choose another file with --history"
            ) from error
        return [one for one in self._sound(rows) if one.kind == kind and machine in (None, one.machine)]

    def _sound(self, rows: list[tuple[Any, ...]]) -> Iterator[Record]:
        for kind, started, machine, packed in rows:
            try:
                yield Record(kind, started, machine, json.loads(zlib.decompress(packed)))
            except (zlib.error, ValueError, TypeError):
                self.said(f"{self.path}: the record of {started} is damaged, and left out")

    @contextmanager
    def _opened(self) -> Iterator[sqlite3.Connection]:
        """Open the database, which is sound then."""
        if not self._is_sound():
            self._begin_anew()
        with closing(self._connect()) as database:
            yield database

    def _is_sound(self) -> bool:
        try:
            with closing(self._connect()) as database:
                database.execute(TABLE)
                return bool(database.execute("PRAGMA quick_check").fetchone()[0] == "ok")
        except sqlite3.OperationalError:  # locked, full, no permission: not damage
            raise
        except sqlite3.DatabaseError:
            return False

    def _begin_anew(self) -> None:
        """Put a damaged file aside, and begin a new one with the rows that can still be read."""
        rows = list(self._readable())
        aside = self.path.with_name(f"{self.path.name}.damaged-{datetime.now(timezone.utc):%Y%m%dT%H%M%S%f}")
        self.path.replace(aside)
        with closing(self._connect()) as database:
            database.execute(TABLE)
            database.executemany("INSERT OR IGNORE INTO record VALUES (?, ?, ?, ?, ?)", rows)
        self.said(
            f"{self.path} is damaged: it is put aside as {aside.name}; {len(rows)} records could be read and are kept"
        )

    def _readable(self) -> Iterator[tuple[Any, ...]]:
        with suppress(sqlite3.DatabaseError), closing(self._connect()) as database:
            yield from database.execute("SELECT digest, kind, started, machine, document FROM record NOT INDEXED")

    def _connect(self) -> sqlite3.Connection:
        return sqlite3.connect(self.path, timeout=PATIENCE, isolation_level=None)


def run_record(document: Document) -> Record:
    """Return the record of pytest-benchmark's document; raises ClickException if it is none."""
    try:
        for race in document["benchmarks"]:
            race["fullname"], race["stats"]["data"][0]
        return Record("run", str(document["datetime"]), checksum(document["machine_info"]), document)
    except (KeyError, TypeError, IndexError, AttributeError) as error:
        raise click.ClickException(
            f"this is no document of pytest-benchmark with all rounds in it: {error!r} is missing; write it with "
            "--benchmark-json, or --benchmark-save-data"
        ) from error


def _columns(record: Record) -> tuple[str, str, str]:
    return record.kind, record.started, record.machine


def _packed(document: Document) -> bytes:
    return zlib.compress(json.dumps(document, sort_keys=True).encode(), 9)


def _digest(document: Document) -> str:
    return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()
