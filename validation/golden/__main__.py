"""Golden test of the core's bits: `python -m validation.golden` compares; `--write` keeps those of now.

Worlds of all kinds are stepped, and the hashes of what they are then compared with `hashes.json`. A change that only
moves code must not change one; a change of what is computed does, and is then judged by the claims.

Bits are those of x86-64, with Numba's compiler and the mathematical library of the day: other versions may round
otherwise and be as good. So this is no claim and no test: it is compared only when somebody asks, before and after, on
one machine.
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
import warnings
from importlib.metadata import version
from pathlib import Path
from time import process_time
from typing import Any

import numba
import numpy as np

from softbody import World
from validation.golden.cases import Case, cases
from validation.golden.make import sha

HASHES = Path(__file__).parent / "hashes.json"


def main() -> int:
    """Return 0 if all is as it was, or was written; 1 if anything differs."""
    parser = argparse.ArgumentParser(prog="python -m validation.golden", description=__doc__.partition("\n")[0])
    parser.add_argument("--write", action="store_true", help=f"keep what is computed now in {HASHES.name}")
    parser.add_argument(
        "-k", metavar="TEXT", default="", help="only worlds whose name contains TEXT; others stay as they are"
    )
    given = parser.parse_args()
    kept = json.loads(HASHES.read_text())
    if given.write and given.k and kept["made with"] != made_with():
        parser.error(f"the others in {HASHES.name} were made with {kept['made with']}; leave out -k")
    warnings.simplefilter("ignore")  # of the scenes' own
    wanted = {name: case for name, case in cases().items() if given.k in name}
    found = computed(wanted)
    seconds = f"{process_time():.0f} s of the processor"
    if given.write:
        worlds = kept["worlds"] | found if given.k else found
        HASHES.write_text(json.dumps({"made with": made_with(), "worlds": worlds}, indent=1) + "\n")
        print(f"{HASHES.name}: {len(found)} worlds, {seconds}")
        return 0
    before = {name: told for name, told in kept["worlds"].items() if given.k in name}
    for what, now in made_with().items():
        if kept["made with"].get(what) != now:
            print(f"{what} is {now}, and was {kept['made with'].get(what)}: bits may differ for that")
    wrong = differences(found, before, wanted)
    print("\n".join([*wrong, f"{len(found)} worlds, {len(wrong)} differences, {seconds}"]))
    return 1 if wrong else 0


def outcome(case: Case) -> dict[str, Any] | None:
    """Return what a world is after its steps; None where there are fewer threads than it asks for."""
    if case.threads > numba.config.NUMBA_NUM_THREADS:  # type: ignore[attr-defined]
        return None
    world = case.build()
    world.step(case.h, case.steps)
    return told(world)


def computed(wanted: dict[str, Case]) -> dict[str, Any]:
    """Return the outcomes of cases, and say on the way how far that is: the first time kernels are compiled."""
    found = {}
    for number, (name, case) in enumerate(wanted.items(), 1):
        print(f"\r{number}/{len(wanted)} {name:<60}", end="", file=sys.stderr, flush=True)
        said = outcome(case)
        if said is not None:
            found[name] = said
    print(f"\r{'':<70}\r", end="", file=sys.stderr)
    return found


def told(world: World) -> dict[str, Any]:
    """Return the bits of a world: of its state, its contacts, its energies, and of all that it would save."""
    saved = {name: value for name, value in world.snapshot().items() if name != "format"}
    points = {name: value for name, value in vars(world.contact_points()).items() if isinstance(value, np.ndarray)}
    return {
        "steps": world.steps,
        "time": world.time.hex(),
        "state": world.state_hash(),
        "stable step": world.stable_time_step().hex(),
        "contacts": {"count": len(points["a"]), **{name: sha(value) for name, value in points.items()}},
        "energies": {name: float(value).hex() for name, value in world.energies()._asdict().items()},
        "asleep": sum(body.is_asleep for body in (*world.soft_bodies, *world.boxes)),
        "snapshot": sha(np.array([f"{name} {sha(value)}" for name, value in sorted(saved.items())])),
    }


def differences(found: dict[str, Any], before: dict[str, Any], wanted: dict[str, Case]) -> list[str]:
    """Return in a line each what is not as it was."""
    wrong = [f"{name}: is new; --write keeps it" for name in found if name not in before]
    wrong += [f"{name}: is no case any more" for name in before if name not in wanted]
    for name in found.keys() & before.keys():
        now, then = _flat(found[name]), _flat(before[name])
        changed = [what for what in (now | then) if now.get(what) != then.get(what)]
        wrong += [f"{name}: {what} is {now.get(what)}, and was {then.get(what)}" for what in changed]
    return wrong


def _flat(told: dict[str, Any]) -> dict[str, Any]:
    """Return what is told, of parts one by one."""
    flat: dict[str, Any] = {}
    for name, value in told.items():
        flat |= {f"{name}: {key}": each for key, each in value.items()} if isinstance(value, dict) else {name: value}
    return flat


def made_with() -> dict[str, str]:
    """Return what bits may depend on, besides the core."""
    libraries = {name: version(name) for name in ("numpy", "numba", "llvmlite")}
    return {"machine": platform.machine(), "libc": " ".join(platform.libc_ver()), **libraries}


if __name__ == "__main__":
    sys.exit(main())
