"""Which mutants are tried, and in which order?"""

from __future__ import annotations

import ast
import random
import subprocess
import zlib
from collections.abc import Iterable

from validation.mutation.core import ROOT, is_left_out
from validation.mutation.sites import Mutant, functions_of, what_it_does


def in_fair_order(mutants: Iterable[Mutant], seed: int) -> list[Mutant]:
    """Return mutants so that the first n, for any n, are an even sample of all: each file has its share.

    Within a file the order is random. The same seed gives the same order, and files that change do not disturb others.
    """
    by_file: dict[str, list[Mutant]] = {}
    for mutant in mutants:
        by_file.setdefault(mutant.file, []).append(mutant)
    places = []
    for file, here in by_file.items():
        rng = random.Random(f"{seed} {zlib.crc32(file.encode())}")
        rng.shuffle(here)
        offset = rng.random()
        places += [((k + offset) / len(here), file, k, mutant) for k, mutant in enumerate(here)]
    return [mutant for *_, mutant in sorted(places, key=lambda place: place[:3])]


def changed_functions(revision: str) -> set[tuple[str, str]]:
    """Return (file, function) of the core for all that is new, or reads differently, since a revision.

    Raises ValueError if Git does not know the revision.
    """
    core, changed = ROOT / "softbody", set()
    asked = ["git", "rev-parse", "--verify", "--quiet", f"{revision}^{{commit}}"]
    known = subprocess.run(asked, cwd=ROOT, capture_output=True)
    if known.returncode:
        raise ValueError(f"Git knows no revision {revision!r}; name a commit, a branch or a tag")
    for path in sorted(core.rglob("*.py")):
        file = path.relative_to(core).as_posix()
        if is_left_out(file):
            continue
        name = f"{revision}:softbody/{file}"
        shown = subprocess.run(["git", "show", name], cwd=ROOT, capture_output=True, text=True)
        before = _bodies(shown.stdout) if shown.returncode == 0 else {}
        now = _bodies(path.read_text(encoding="utf-8"))
        changed |= {(file, function) for function, body in now.items() if before.get(function) != body}
    return changed


def _bodies(source: str) -> dict[str, str]:
    """Return what each function of a module does."""
    return {name: what_it_does(function) for name, function in functions_of(ast.parse(source))}
