"""What is on disk while a run goes on: claims.jsonl, a line of JSON a claim that has ended, from which it can go on.

The first line says which run it is: level, seed, and digests of the core and of the claims. A line that was cut off,
by a kill or a full disk, is the last one, and counts as not written.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from types import TracebackType
from typing import IO, Any

from validation import plug_ins
from validation.plain_text import plain
from validation.record import ClaimRecord, finite, from_json

try:
    import fcntl
except ImportError:  # not on Windows: there, two runs at once in one folder are not noticed
    fcntl = None  # type: ignore[assignment]

NAME, KEPT_NAME = "claims.jsonl", "claims.before.jsonl"
SCHEMA = "softbody-claims/1"
WORDS = {
    "subject": "about {}",
    "level": "of level {}",
    "seed": "of seed {}",
    "core": "of another core ({:.12})",
    "claims": "of other claims or references ({:.12})",
    "engines": "judged by other versions of {}",
}


class CannotRunHereError(Exception):
    """Another run is writing there, or there is nothing to go on from, or it is of another run."""


def identity(level: str, seed: int, subject: str | None = None) -> dict[str, Any]:
    """Return all that decides the records of a run."""
    from softbody.compiler.core_digest import CORE_DIGEST
    from validation.engines import versions

    return {
        "schema": SCHEMA,
        "subject": subject,
        "level": level,
        "seed": seed,
        "core": CORE_DIGEST,
        "claims": digest_of("validation", "references", *plug_ins.packages()),
        "engines": versions(),
    }


def digest_of(*packages: str) -> str:
    """Return a hash, in hexadecimal, of the sources of packages."""
    digest = hashlib.sha256()
    for package in packages:
        spec = find_spec(package)
        for folder in map(Path, spec.submodule_search_locations or [spec.origin or ""] if spec else ()):
            for path in sorted(folder.rglob("*.py")) if folder.is_dir() else [folder]:
                digest.update(f"{package}/{path.relative_to(folder).as_posix()}".encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()


class Journal:
    """The claims of a run that have ended, on disk as soon as they have."""

    def __init__(self, folder: Path, run: dict[str, Any], resume: bool, say: Callable[[str], None]) -> None:
        """Open the journal of a folder: that of an unfinished run if `resume`, else a new one.

        What an unfinished run has left is kept under another name. Raises CannotRunHereError, saying why; OSError.
        """
        self.path = folder / NAME
        self.records: dict[tuple[str, int], ClaimRecord] = {}  # by claim and seed
        if resume and not self.path.exists():
            raise CannotRunHereError(f"{self.path} does not exist: no run was cut short there; run without --resume")
        self._file: IO[bytes] = self.path.open("r+b" if self.path.exists() else "w+b", buffering=0)
        try:
            if fcntl is not None:
                try:
                    fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except OSError:
                    raise CannotRunHereError(f"another run is writing to {folder}; choose another --out") from None
            head, lines, whole = self._read()
            if resume:
                self._take(head, lines, run)
                self._file.seek(whole)
                self._file.truncate()
            else:
                if lines:
                    kept = folder / KEPT_NAME
                    kept.write_bytes(self.path.read_bytes())
                    say(f"A run was cut short here after {len(lines)} claims; they are kept in {kept}.")
                self._file.seek(0)
                self._file.truncate()
                self._write(run)
        except BaseException:
            self._file.close()
            raise

    def _read(self) -> tuple[Any, list[Any], int]:
        """Return the first line, those that follow, and where the last whole one ends [bytes]."""
        data = self._file.read()
        whole = data.rfind(b"\n") + 1
        found = []
        for line in data[:whole].split(b"\n")[:-1]:
            try:
                found.append(json.loads(line))
            except (ValueError, RecursionError):  # no JSON, or nested deeper than anybody writes
                found.append(None)
        return (found[0] if found else None), found[1:], whole

    def _take(self, head: Any, lines: list[Any], run: dict[str, Any]) -> None:
        """Take over the claims of the same run; raises CannotRunHereError."""
        if not isinstance(head, dict) or head.get("schema") != SCHEMA:
            raise CannotRunHereError(f"{self.path} is no journal of a run; run without --resume")
        for name, words in WORDS.items():
            was = head.get(name)
            if was != run.get(name):
                told = words.format(
                    ", ".join(others(was, run[name]))
                    if name == "engines"
                    else plain("the core" if was is None else was)
                )
                raise CannotRunHereError(f"{self.path} is {told}: its claims may differ; run without --resume")
        for number, line in enumerate(lines, 2):
            try:
                record = from_json(ClaimRecord, line)
            except ValueError as error:
                raise CannotRunHereError(
                    f"{self.path}, line {number}, is damaged: {error}; run without --resume"
                ) from None
            self.records[record.id, record.seed] = record

    def add(self, record: ClaimRecord) -> None:
        """Write a claim that has ended; raises OSError."""
        self._write(finite(asdict(record)))
        self.records[record.id, record.seed] = record

    def _write(self, data: dict[str, Any]) -> None:
        line = json.dumps(data, ensure_ascii=False).encode() + b"\n"
        while line:  # a disk that is nearly full takes a part, and raises when it is asked for the rest
            line = line[os.write(self._file.fileno(), line) :]
        os.fsync(self._file.fileno())

    def remove(self) -> None:
        """Remove the file: the run is complete, and report.json has it all."""
        self.path.unlink(missing_ok=True)

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._file.close()


def others(was: Any, now: dict[str, str | None]) -> list[str]:
    """Return the engines whose versions differ."""
    before = was if isinstance(was, dict) else {}
    return [name for name in sorted({*before, *now}) if before.get(name) != now.get(name)]
