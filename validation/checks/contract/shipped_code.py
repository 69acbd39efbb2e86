"""Claims about machine code that comes with a wheel."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from softbody import scenes
from softbody.cli.warmup import BALL, KINDS, Kind
from softbody.compiler import core_cache, shipped_code
from validation.answers import Answers
from validation.check import Comparison, NotHereError, Run, check
from validation.fault import Fault
from validation.installed import family_here, install, use

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

TIMES = 6  # that a world is looked at
BALL_ON_GROUND = """
import softbody
world = softbody.World()
world.add_ground(restitution=0.5)
ball = softbody.icosphere(2, radius=0.3)
world.add_soft_body(ball, mass=0.5, stiffness=80.0, gas=10.0, position=(0.0, 0.0, 0.5), velocity=(1.0, 0.0, -2.0))
"""
SCENE = """
import softbody
world = softbody.scenes.{}.build()
"""
WATCH = """
hashes = []
for _ in range({}):
    world.run(0.1)
    hashes.append(world.state_hash())
print(*hashes)
"""


@check(
    section="beyond the paper",
    piece="softbody.compiler.shipped_code",
    reference="Numba's events; the same scene, compiled for this processor by the process that judges",
    kind="invariant",
    unit="disagreements",
    faults=(
        Fault(
            "what came along is not looked for", core_cache._ByCore._load_from_elsewhere, "load_shipped(a_, b_) → None"
        ),
        Fault("what was kept is not found", shipped_code.load_shipped, "file.load(a_) → None"),
        Fault("code for other processors only", shipped_code._folder, "needs <= has → needs > has"),
    ),
)
def nothing_compiles(run: Run) -> Comparison:
    """A wheel's machine code steps as the host's and nothing compiles.

    A copy of the core brings the code of a family of processors, and can keep nothing. A ball's bits are those of code
    for this very processor, six times. At the full level that is all kinds of worlds, and all scenes.
    """
    family, answers = family_here(), Answers()
    if family is None:
        raise NotHereError("no family of processors is known whose code this one could run: wheels are pure here")
    kinds: tuple[Kind, ...] = (Kind(*BALL),)
    worlds = {"a ball": BALL_ON_GROUND}
    if run.level == "full":
        kinds, worlds = KINDS, worlds | {scene: SCENE.format(scene) for scene in scenes.__all__}
    with tempfile.TemporaryDirectory() as folder:
        install(kinds, family, Path(folder))
        for name, world in worlds.items():
            program = world + WATCH.format(TIMES)
            here: dict[str, Any] = {"print": lambda *said: None}
            used = use(program, Path(folder))
            exec(program, here)
            same = [mine == its for mine, its in zip(used.printed.split(), here["hashes"], strict=True)]
            answers.extend(same, [True] * TIMES, kind=f"{name}: bits")
            answers.add(not used.compiled, True, kind=f"{name}: {' '.join(used.compiled) or 'nothing'} compiled")
    return answers.comparison()
