"""Core that a name stands for: a revision, or "." for the working tree, laid out in a folder.

The folder holds `softbody` alone. Benchmarks and peers are those of the working tree, for both sides.
"""

from __future__ import annotations

import io
import shutil
import subprocess
import tarfile
import tempfile
from dataclasses import dataclass
from pathlib import Path

import click

from benchmarks.cores import CORE, kept


@dataclass(frozen=True)
class Side:
    """One core of a comparison."""

    name: str  # as the user said
    revision: str  # commit, with "+" for a working tree that differs from it
    folder: Path  # that has it


def checked_out(name: str, root: Path, store: Path) -> Side:
    """Return the core of a revision of the repository at `root`, laid out below `store`."""
    store.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=store) as made:
        revision = _copy_tree(root, Path(made)) if name == "." else _unpack(name, root, Path(made))
        if not (Path(made) / CORE / "__init__.py").exists():
            raise click.UsageError(f"{name} has no {CORE}/: choose a revision that has one")
        folder = kept(Path(made), store)
    return Side(name, revision, folder)


def _copy_tree(root: Path, into: Path) -> str:
    shutil.copytree(root / CORE, into / CORE, ignore=shutil.ignore_patterns("__pycache__", "*.nb?"))
    return revision_of(root)


def _unpack(name: str, root: Path, into: Path) -> str:
    found = git(root, "rev-parse", "--verify", "--quiet", "--end-of-options", f"{name}^{{commit}}")
    if found.returncode:
        raise click.UsageError(f"there is no revision {name!r} here; `git log --oneline` lists some")
    commit = found.stdout.decode().strip()
    archive = git(root, "archive", "--format=tar", commit, CORE)
    if not archive.returncode:
        with tarfile.open(fileobj=io.BytesIO(archive.stdout)) as tar:
            if hasattr(tarfile, "data_filter"):  # since 3.11.4
                tar.extraction_filter = tarfile.data_filter
            tar.extractall(into)
    return commit[:12]


def revision_of(root: Path) -> str:
    """Return the commit of a working tree, with "+" if it has changes; "unknown" where there is no repository."""
    done = git(root, "describe", "--always", "--abbrev=12", "--dirty=+", "--exclude=*")
    return done.stdout.decode().strip() or "unknown"


def git(root: Path, *arguments: str) -> subprocess.CompletedProcess[bytes]:
    """Run git on a repository."""
    try:
        return subprocess.run(["git", "-C", str(root), *arguments], capture_output=True)
    except FileNotFoundError as error:
        raise click.ClickException("git is not installed; comparing revisions needs it") from error
