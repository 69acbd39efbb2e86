"""Claims that mistakes in a scene file are told by the line that they are in."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator
from datetime import date
from pathlib import Path
from typing import Any

from softbody import SceneError
from softbody.scenes import from_file, scene_file, scene_keys, toml_lines
from softbody.scenes.scene_file import _Reading, read_scene
from validation.answers import Answers
from validation.check import Comparison, Run, check
from validation.checks.contract.cases import error_of
from validation.checks.contract.scene_files import (
    DRAWS,
    GOOD,
    LISTS,
    NOWHERE,
    WITH,
    Rng,
    Table,
    drawn,
    put,
    text_of,
    toml,
    written_parts,
)
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

Lines = list[tuple[int, tuple[str, ...]]]  # of a file, with what is to be named there
Told = dict[str, tuple[str, ...]]  # by the key that it is told at, "" for the table's: what is named, @ for the table
# What is said where a key is missing, if not that.
OTHERWISE = {("box", "mass"): "a box has a mass [kg], or static", ("suspension", "points"): "needs a box, or points"}
OTHERWISE |= {("soft_body", "gas"): "gas, or pressure, is missing"}

Mistake = tuple[str, str, Table, Told]  # in words, the table, all that is in it


def wrong_for(value: Any, key: str, rng: Rng) -> Any:
    """Return a value of another kind than one that a key may have."""
    others: list[Any] = [date(1979, 5, 27), {"a": 1}, [[[1, 2], [3]]]]
    if isinstance(value, (str, bool)) and key != "self_contact":
        others.append(7)
    if type(value) in (int, float) and key != "self_contact":
        others.append(True)
    if isinstance(value, list) and isinstance(value[0], float):
        others.append([True, *value[1:]])
    return drawn(others, rng)


def unknown(table: str, key: str, hint: str) -> Mistake:
    """Return the mistake of a key that there is not."""
    first: Table = {"end": {"box": 0, "at": NOWHERE}, "shape file": {"file": "whole.off"}}
    where, content, inside = put(table, first.get(table, {}) | {key: 1})
    return f"{table}: {hint}", where, content, {inside or key: ("@", f"there is no {key!r}", hint)}


def mistakes_of_keys(rng: Rng) -> Iterator[Mistake]:
    """Yield what may be wrong with any key: a value of another kind, a letter too few, that it is not there."""
    for table, keys in DRAWS.items():
        wrong = {key: wrong_for(drawn(draw, rng), key, rng) for key, draw in keys.items()}
        for key in keys:
            where, content, inside = put(table, WITH.get(f"{table} {key}", {}) | {key: wrong[key]})
            yield f"{table}: {key} of another kind", where, content, {inside or key: ("@", f"{key} is")}
            if len(key) > 3:
                k = int(rng.integers(1, len(key) - 1))
                yield unknown(table, key[:k] + key[k + 1 :], f"did you mean {key!r}?")
        yield unknown(table, "xyzzy", "choose from")
        for key in GOOD.get(table, {}):
            left = {each: value for each, value in GOOD[table].items() if each != key}
            missing = OTHERWISE.get((table, key), f"{key} is missing")
            yield f"{table}: no {key}", table, left, {"": ("@", missing)}
        if table in GOOD:
            yield f"{table}: all of another kind", table, wrong, {key: ("@", f"{key} is") for key in keys}


def mistakes_of_their_own() -> Iterator[Mistake]:
    """Yield mistakes that are of one key, or between some."""
    size, still, spin, there = {"size": [1.0, 1.0, 1.0]}, {"static": True}, [0.0, 0.0, 1.0], {"at": NOWHERE}
    for content in ({"mass": 1.0, **still}, {**still, "kinematic": True}, {"static": False}):
        yield "one of three", "box", size | content, {"": ("@", "mass", "static", "kinematic")}
    both = GOOD["soft_body"] | {"pressure": 1.0}
    yield "gas and pressure", "soft_body", both, {"": ("@", "either gas [J] or pressure [Pa]")}
    for key in ("velocity", "angular_velocity"):
        yield f"static, with {key}", "box", {**size, **still, key: spin}, {key: ("@", f"{key} is not", "static")}
    for end, words in (
        ({"box": 99, **there}, ("there is no box 99",)),
        ({"soft_body": 99, **there}, ("there is no soft_body 99",)),
        ({"box": "ldi", **there}, ("there is no box 'ldi'", "did you mean 'lid'?")),
        ({"soft_body": "lid", **there}, ("there is no soft_body 'lid'",)),
        ({"box": 0, "particle": 0}, ("give a place", "of a soft body there may be particle")),
        ({"box": 0, "soft_body": 0, **there}, ("give a place",)),
        ({"box": 0}, ("give a place",)),
    ):
        yield f"joint: {words[0]}", "joint", {**GOOD["joint"], "b": end}, {"b": ("@.b", *words)}
    yield "two places", "joint", {**GOOD["joint"], "b": spin}, {"a": ("@", "a and b are two places")}
    nobody = {"b": {"soft_body": 0, "particle": 99}}
    yield "no such particle", "joint", GOOD["joint"] | nobody, {"b": ("@", "particle of b is 99")}
    yield "inside nobody", "box", GOOD["box"] | {"inside": 99}, {"inside": ("@", "there is no soft_body 99")}
    hung = GOOD["suspension"]
    yield "hung in nobody", "suspension", hung | {"soft_body": 99}, {"soft_body": ("@", "there is no soft_body 99")}
    yield "two kinds", "suspension", hung | {"box": "lid"}, {"": ("@", "needs a box, or points")}
    for table in ("box", "suspension", "joint"):
        yield f"{table}: a name twice", table, {"name": "lid", **GOOD[table]}, {"name": ("@", "'lid'", "box[0]")}
    for change, key, named in (
        ({"fixed_above": 50.0}, "fixed_above", "fixed_above is 50.0 m"),
        ({"fixed_below": -50.0}, "fixed_below", "fixed_below is -50.0 m"),
        ({"fixed": [6]}, "fixed", "fixed vertex 6"),
        ({"stiffness": [1.0] * 11}, "stiffness", "12 edges"),
        ({"rest_length": [1.0] * 11}, "rest_length", "12 edges"),
        ({"tear_at": [2.0] * 11}, "tear_at", "12 edges"),
        ({"tear_at": [2.0] * 11 + [1.0]}, "tear_at", "tear_at of edge 11 is 1.0"),
        ({"shape": {"name": "torsu"}}, "shape", "did you mean 'torus'?"),
        ({"shape": {"name": "torus", "file": "whole.off"}}, "shape", "shape is"),
        ({"shape": {"radius": 1.0}}, "shape", "shape is"),
        ({"shape": {"name": "torus", "minor_radius": 1.0}}, "shape", "major_radius"),
    ):
        yield f"soft_body: {named}", "soft_body", GOOD["soft_body"] | change, {key: ("@", named)}
    no_file = {"shape": {"file": "nothing.off"}}
    yield "no mesh file", "soft_body", GOOD["soft_body"] | no_file, {"shape": ("@.shape", "nothing.off cannot be read")}
    for colour in ("pressure", "strain", "speed"):
        yield f"{colour} without a range", "film", {"colour": colour}, {"colour": ("@", colour, "colour_range")}
    yield "a range the wrong way", "film", {"colour_range": [2.0, 1.0]}, {"colour_range": ("@", "greatest of")}
    for step, word in ((0.01, "stable"), (0.5, "≤ 0.0166667 [s]")):
        yield "a long step", "run", {"seconds": 1.0, "time_step": step}, {"time_step": ("@: time_step", word)}
    yield "no such table", "wrold", {"threads": 1}, {"": ("'wrold'", "did you mean 'world'?")}
    yield "no such list of tables", "bxo", GOOD["box"], {"": ("'bxo'", "did you mean 'box'?")}


FIRST = {"box": [GOOD["box"] | {"name": "lid"}], "soft_body": [GOOD["soft_body"] | {"stiffness": 1e5}]}


def with_mistakes(chosen: list[Mistake], rng: Rng) -> tuple[str, Lines]:
    """Return a scene file with mistakes, and the line of each."""
    text, lines, counts = text_of(FIRST), Lines(), {"box": 1, "soft_body": 1, "suspension": 0, "joint": 0, "bxo": 0}
    for _, name, content, words in chosen:
        where = f"{name}[{counts[name]}]" if name in counts else name
        text += "\n# another" * int(rng.integers(3)) + (f"\n[[{name}]]" if name in counts else f"\n[{name}]")
        at = {"": text.count("\n") + 1}
        for key in rng.permutation(list(content)):
            at[str(key)] = text.count("\n") + 2
            value = toml(content[key])
            text += f"\n{key} = " + (value.replace(", ", ",\n") if value.startswith("[") else value)
        counts |= {name: counts[name] + 1} if name in counts else {}
        lines += [(at[key], tuple(word.replace("@", where) for word in named)) for key, named in words.items()]
    return text, lines


def files_with_mistakes(rng: Rng) -> Iterator[tuple[str, str, Lines]]:
    """Yield scene files: what is wrong, the text, and what is to be told."""
    pool = [*mistakes_of_keys(rng), *mistakes_of_their_own()]
    for mistake in pool:
        yield mistake[0], *with_mistakes([mistake], rng)
    for _ in range(20):
        chosen = enumerate(pool[k] for k in rng.permutation(len(pool))[:15])
        apart = {each[1] if each[1] not in LISTS else k: each for k, each in chosen}
        yield "several at once", *with_mistakes([*apart.values()], rng)
    for nobody in ("# nothing", "box = []"):
        yield "no bodies", f"{nobody}\n\n[run]\nseconds = 1.0", [(1, ("there are no bodies",))]
    for row in ("mass =", "mass = 1 kg", "[[box]", "gas = 2.0"):
        text = text_of(FIRST) + "\n" * int(rng.integers(1, 9)) + row + "\n"
        yield f"no TOML: {row}", text, [(0, ("is no TOML", f"(at line {len(text.splitlines())},"))]


def told_of(path: Path, text: str) -> list[tuple[int, str]]:
    """Return what is told of a scene file: lines and messages; 0 for what has none."""
    path.write_text(text)
    error = error_of(Exception, from_file, path)
    rows = str(error).split("\n") if isinstance(error, SceneError) else []
    found = [re.fullmatch(rf"{re.escape(str(path))}:(\d+): (.+)", row) for row in rows]
    return [(int(match[1]), match[2]) if match else (0, row) for match, row in zip(found, rows)]


def is_told(found: list[tuple[int, str]], lines: Lines) -> bool:
    """Tell whether all lines are told, each by what is to be named there, and no others."""
    return sorted(at for at, _ in found) == sorted(line for line, _ in lines) and all(
        any(at == line and all(word in what for word in words) for at, what in found) for line, words in lines
    )


@check(
    section="beyond the paper",
    piece="softbody.scenes.from_file",
    reference="the documentation; lines that were counted as they were written",
    engines=("trimesh",),
    kind="specification",
    faults=(
        Fault("all at the line of what it is in", _Reading._telling, "a_ if inside is not None else b_ → a_"),
        Fault("unknown keys at the line of their table", _Reading._names, "(*at, name) → at"),
        Fault("the outermost line there is", toml_lines.line_of, "range(len(path), 0, -1) → range(1, len(path) + 1)"),
        Fault("lines counted from 0 on", toml_lines._statements, "(yield first + 1, s_) → (yield first, s_)"),
        Fault("the first mistake alone", read_scene, "told = sorted(rows_) → told = sorted(rows_)[:1]"),
        Fault("the first key, whatever is meant", scene_file._meant, "list(known) → list(known)[:1]"),
        Fault("a static box that has a mass", _Reading._box, "a_ + b_ + c_ != 1 → a_ + b_ + c_ < 1"),
        Fault("static boxes that spin", _Reading._box, "('velocity', 'angular_velocity') → ('velocity',)"),
        Fault("names of any kind of body", _Reading._body, "a_ or table[0] != kind → a_"),
        Fault("particles of boxes", _Reading._end, "places_[0] not in PLACES[kind_] → False"),
        Fault("names that the world is to find twice", _Reading._note_name, "name in self._called → False"),
        Fault("nothing held, and nothing said", _Reading._soft_body, "not held and a_ → False"),
        Fault("steps of any length", _Reading._run, "run.time_step > stable → False"),
        Fault("speeds of any range", _Reading._film, "('pressure', 'strain', 'speed') → ('pressure', 'strain')"),
        Fault("truth for a number", scene_keys._no_truth, "isinstance(each, bool) → False"),
        Fault(
            "pairs that are not named", scene_keys._pair, "raise ParameterError(a_) → raise ParameterError('a pair')"
        ),
    ),
)
def mistakes_are_told(run: Run) -> Comparison:
    """A mistake in a scene file is told by its line.

    Each kind of mistake with each key, alone and among others: the error lists their lines, all of them and no more,
    and names table and key.
    """
    rng, answers = run.fresh_rng(), Answers()
    with tempfile.TemporaryDirectory() as folder:
        written_parts(Path(folder), rng)
        for _ in range(run.count(1, 3, 20)):
            for kind, text, lines in files_with_mistakes(rng):
                answers.add(is_told(told_of(Path(folder) / "scene.toml", text), lines), True, kind=kind, file=text)
    return answers.comparison()
