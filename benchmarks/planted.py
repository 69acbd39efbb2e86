"""A core that is slower by a known share: it does so much more of its own work, in the kernel that steps one body.

Of `run_alone`'s steps, some are taken once more, of a copy of the state that is thrown away: the same answers, later.
"""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import replace
from pathlib import Path

import click

from benchmarks.cores import CORE, kept
from benchmarks.sides import Side

KERNEL = "stepping/step.py"
BEFORE = "    bodies, material = soft_bodies_of(model, controls, state), BARE\n"
EXTRA = """    spare = copied(state)
    move_soft_bodies(soft_bodies_of(model, controls, spare), motion, settings, h, (steps * {percent} + 50) // 100)
"""
# Benchmarks of that kernel of so many steps that a percent of them is a whole number, or nearly: within 4 % of itself.
SLOWED = ("bench_step[1]", "bench_step[2]", "bench_step[3]", "bench_many_bodies[1]")


def slower(side: Side, percent: int) -> Side:
    """Return the core of a side, slowed by some percent; raises ClickException where its kernel reads otherwise."""
    store = side.folder.parent
    with tempfile.TemporaryDirectory(dir=store) as made:
        shutil.copytree(side.folder / CORE, Path(made) / CORE, ignore=shutil.ignore_patterns("__pycache__", "*.nb?"))
        kernel = Path(made) / CORE / KERNEL
        source = kernel.read_text(encoding="utf-8")
        if source.count(BEFORE) != 1:
            raise click.ClickException(
                f"no slow-down can be planted in {CORE}/{KERNEL}: its line {BEFORE.strip()!r} is gone"
            )
        kernel.write_text(source.replace(BEFORE, EXTRA.format(percent=percent) + BEFORE), encoding="utf-8")
        folder = kept(Path(made), store)
    return replace(side, name=f"{side.name}, {percent} % slower", folder=folder)
