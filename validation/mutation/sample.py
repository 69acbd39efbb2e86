"""Sample of the mutants to try, and their order."""

from __future__ import annotations

import random
import zlib
from collections.abc import Iterable

from validation.mutation.core import ROOT, is_left_out
from validation.mutation.revision import changed, functions_in, sources_at, sources_now
from validation.mutation.sites import Mutant

CORE = "softbody"  # the folder


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
    """Return (file, function) of the core for all that is new, or does something else, since a revision.

    What has only moved has not changed. Raises ValueError if Git does not know the revision.
    """
    found = changed(sources_at(revision, CORE, ROOT), sources_now(CORE, ROOT), functions_in)
    files = {(path.removeprefix(f"{CORE}/"), function) for path, function in found}
    return {each for each in files if not is_left_out(each[0])}
