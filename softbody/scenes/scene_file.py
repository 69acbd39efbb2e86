"""Scene files in TOML: the world one describes, and its run. All that is wrong is said at once, by line."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import numpy as np

from softbody.bodies.names import names_listed
from softbody.bodies.rigid_box import Box
from softbody.bodies.soft_body import SoftBody
from softbody.bodies.suspended import Suspended
from softbody.errors import MissingPackageError, ParameterError, SceneError, SoftbodyError
from softbody.extras import library
from softbody.linalg.quaternion import rotation_matrix
from softbody.mesh import mesh as meshes
from softbody.mesh.mesh import Mesh
from softbody.model.validation import check_range, shown
from softbody.scenes.scene_keys import (
    BOX,
    END,
    FILM,
    GROUND,
    JOINT,
    LIQUID,
    MESH_FILE,
    PLACES,
    RUN,
    SHAPES,
    SOFT_BODY,
    SUSPENSION,
    WORLD,
    Check,
)
from softbody.scenes.toml_lines import Path, line_of, lines_of
from softbody.scenes.world_to_fill import world_to_fill
from softbody.storage.atomic_file import path_of
from softbody.world import World

MOST_BYTES = 2**20  # that a scene file may have: some ten thousand bodies
MOST_PARTS = 200  # that a key may have: for each pair of them, Python's parser makes a list of all before

TABLES, BODIES = ("world", "ground", "liquid", "run", "film"), ("soft_body", "box")
LISTS = (*BODIES, "suspension", "joint")
END_HINT = "give a place, [x, y, z], or one on a body, { soft_body | box = its name or number, at = [x, y, z] }"


class Run(NamedTuple):
    """How a scene is run, as `[run]` says."""

    seconds: float  # of the world's time
    frames_per_second: float = 60.0  # that are kept
    time_step: float | None = None  # [s]; None: the world chooses
    velocities: bool = True  # whether they are kept, too


class Film(NamedTuple):
    """Which film is made of a run, as `[film]` says: the arguments of a Recorder."""

    file: str = "film.webp"
    frames_per_second: float = 20.0
    colour: str = "stripes"
    colour_range: tuple[float, float] | None = None
    size: tuple[int, int] = (640, 480)
    show_joints: bool = True


class SceneFile(NamedTuple):
    """What a scene file says."""

    world: World
    run: Run | None
    film: Film | None
    content: bytes


def from_file(path: str | os.PathLike[str], world: World | None = None) -> World:
    """Return `world`, or a new one, filled as a scene file (TOML) says; with a `world`, its own settings hold.

    Raises SceneError, which lists all that is wrong in the file, each with its line and cure, and MissingPackageError:
    before Python 3.11 TOML is read by tomli (softbody[scenes]), mesh files are read by trimesh (softbody[files]).
    """
    return read_scene(path, world).world


def read_scene(path: str | os.PathLike[str], world: World | None = None, **choices: Any) -> SceneFile:
    """Return what a scene file says; see `from_file`. In a new world `choices` hold in place of the file's own."""
    world_to_fill(world)
    place = path_of(path)
    content = _bytes_of(place)
    parser = _parser()
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SceneError(f"{place} is no text in UTF-8; save it as such") from error
    if any(len(re.findall(r"[\w\"'-][ \t]*\.", part)) > MOST_PARTS for part in re.split(r"[^\w.\"' \t-]", text)):
        raise SceneError(f"{place} has a key of more than {MOST_PARTS} parts; keys of a scene have one or two")
    try:
        found = parser.loads(text)
    except (ValueError, RecursionError) as error:
        raise SceneError(f"{place} is no TOML: {error}") from error
    reading = _Reading(place.parent)
    scene = reading.scene(found, world, choices, content)
    if reading.wrong:
        lines = lines_of(text, parser.loads)
        told = sorted((line_of(at, lines), message) for at, message in reading.wrong)
        raise SceneError("\n".join(f"{place}:{line}: {message}" for line, message in told))
    if reading.missing is not None:
        raise reading.missing
    return scene


def _bytes_of(place: FilePath) -> bytes:
    try:
        with place.open("rb") as file:
            content = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise SceneError(f"{place} cannot be read: {error.strerror or error}; give the name of a scene file") from error
    if len(content) > MOST_BYTES:
        raise SceneError(f"{place} has more than {MOST_BYTES} bytes; build so large a scene in Python")
    return content


def _parser() -> Any:
    """Return what reads TOML: Python's own from 3.11 on."""
    try:
        import tomllib
    except ImportError:
        return library("tomli", "tomli", "scenes", "reading a scene file before Python 3.11")
    return tomllib


class _Reading:
    """What is read of a scene file, and what was found to be wrong on the way: where, and what to do."""

    def __init__(self, folder: FilePath) -> None:
        self.wrong: list[tuple[Path, str]] = []
        self.missing: MissingPackageError | None = None  # to be said when nothing is wrong with the file itself
        self._folder = folder
        self._bodies: dict[Path, SoftBody | Box | Suspended | None] = {}  # of each table; None where that is wrong
        self._called: dict[str, Path] = {}  # which table has each name

    def scene(self, found: dict[str, Any], world: World | None, choices: dict[str, Any], content: bytes) -> SceneFile:
        """Return the scene; it is good if there is nothing wrong."""
        self._names(found, (*TABLES, *LISTS), ())
        if not any(found.get(name) for name in BODIES):
            self.wrong.append(((), "there are no bodies; add [[soft_body]] or [[box]]"))
        world = self._world(found, world, choices)
        ground = self._table(found, "ground", GROUND)
        if ground is not None:
            with self._telling(("ground",)):
                world.add_ground(**ground)
        liquid = self._table(found, "liquid", LIQUID)
        if liquid is not None:
            with self._telling(("liquid",)):
                world.add_liquid(**liquid)
        for at, table in self._list(found, "soft_body"):
            self._soft_body(world, at, table)
        for at, table in self._list(found, "box"):
            self._box(world, at, table)
        for at, table in self._list(found, "suspension"):
            self._suspension(world, at, table)
        for at, table in self._list(found, "joint"):
            self._joint(world, at, table)
        return SceneFile(world, self._run(found, world), self._film(found), content)

    def _world(self, found: dict[str, Any], world: World | None, choices: dict[str, Any]) -> World:
        before = len(self.wrong)
        settings = {**(self._table(found, "world", WORLD) or {}), **choices}
        if world is not None or len(self.wrong) > before:
            return world_to_fill(world)
        with self._telling(("world",)):
            return World.paper(**settings) if settings.pop("paper", False) else World(**settings)
        return World()

    def _soft_body(self, world: World, at: Path, table: Any) -> None:
        before, self._bodies[at] = len(self.wrong), None
        has_pressure = isinstance(table, dict) and "pressure" in table
        needed = ("shape", "mass", "stiffness", *(() if has_pressure else ("gas",)))
        given = self._checked(table, at, SOFT_BODY, needed)
        self._note_name(given, at)
        shape = given.pop("shape", None)
        mesh = None if shape is None else self._shape(shape, (*at, "shape"))
        if mesh is None or len(self.wrong) > before:
            return
        above, below = given.pop("fixed_above", np.inf), given.pop("fixed_below", -np.inf)
        with self._telling(at):
            mesh = Mesh(mesh.vertices @ rotation_matrix(given.pop("orientation", np.eye(4)[0])).T, mesh.triangles)
            z = mesh.vertices[:, 2] + given.get("position", np.zeros(3))[2]
            held = np.flatnonzero((z > above) | (z < below)).tolist()
            if not held and not (above == np.inf and below == -np.inf):
                where = {"fixed_above": above, "fixed_below": below}
                none = " and ".join(f"{key} is {z} m" for key, z in where.items() if abs(z) < np.inf)
                there = f"no vertex is there: this one is from {z.min():.4g} to {z.max():.4g} m"
                raise ParameterError(f"{none}, and {there}; fix it where it is")
            self._bodies[at] = world.add_soft_body(mesh, **{**given, "fixed": [*given.get("fixed", []), *held]})

    def _shape(self, found: Any, at: Path) -> Mesh | None:
        """Return the mesh that a table describes: one of ours by name, or that of a file."""
        hint = f"give {{ name = {' | '.join(SHAPES)}, … }} or {{ file = … }}"
        if not isinstance(found, dict) or ("name" in found) == ("file" in found):
            self.wrong.append((at, f"{_name(at)} is {shown(found)}; {hint}"))
            return None
        before = len(self.wrong)
        if "file" in found:
            given = self._checked(found, at, MESH_FILE, ())
            return None if len(self.wrong) > before else self._mesh_file(given, at)
        name = found["name"]
        if not isinstance(name, str) or name not in SHAPES:
            self.wrong.append(((*at, "name"), f"{_name(at)}: name is {shown(name)}; {hint}{_meant(name, SHAPES)}"))
            return None
        given = self._checked({key: value for key, value in found.items() if key != "name"}, at, SHAPES[name], ())
        if len(self.wrong) > before:
            return None
        with self._telling(at):
            return getattr(meshes, name)(**given)
        return None

    def _mesh_file(self, given: dict[str, Any], at: Path) -> Mesh | None:
        scale = given.pop("scale", 1.0)
        path = self._folder / given.pop("file")
        try:
            with self._telling((*at, "file"), at):
                return Mesh.from_file(path, **given).scaled(scale)
        except OSError as error:
            self.wrong.append(
                ((*at, "file"), f"{_name(at)}: {path} cannot be read: {error.strerror or error}; see that it is there")
            )
        return None

    def _box(self, world: World, at: Path, table: Any) -> None:
        before, self._bodies[at] = len(self.wrong), None
        given = self._checked(table, at, BOX, ("size",))
        self._note_name(given, at)
        if "inside" in given:
            given["inside"] = self._body("soft_body", given["inside"], at, "inside")
        if len(self.wrong) > before or ("inside" in given and given["inside"] is None):
            return
        with self._telling(at):
            is_static, is_kinematic = given.pop("static", False), given.pop("kinematic", False)
            if is_static + is_kinematic + ("mass" in given) != 1:
                raise ParameterError("a box has a mass [kg], or static = true, or kinematic = true; give one of them")
            for name in ("velocity", "angular_velocity") if is_static else ():
                if np.any(given.get(name, 0.0)):
                    raise ParameterError(f"{name} is not for a static box; say kinematic = true for it to move by it")
            self._bodies[at] = world.add_box(given.pop("size"), given.pop("mass", None), **given)

    def _suspension(self, world: World, at: Path, table: Any) -> None:
        before, self._bodies[at] = len(self.wrong), None
        given = self._checked(table, at, SUSPENSION, ("soft_body",))
        self._note_name(given, at)
        if len(self.wrong) == before and ("box" in given) == ("points" in given):
            self.wrong.append((at, f"{_name(at)} needs a box, or points; give one of them"))
        if len(self.wrong) > before:
            return
        body = self._body("soft_body", given.pop("soft_body"), at)
        what = given.pop("points") if "points" in given else self._body("box", given.pop("box"), at)
        if body is not None and what is not None:
            with self._telling(at):
                self._bodies[at] = world.suspend(what, body, **given)

    def _joint(self, world: World, at: Path, table: Any) -> None:
        before = len(self.wrong)
        given = self._checked(table, at, JOINT, ("a", "b", "stiffness"))
        self._note_name(given, at)
        ends = [self._end(given.pop(name), (*at, name)) for name in ("a", "b") if name in given]
        if len(self.wrong) > before or any(end is None for end in ends):
            return
        with self._telling(at):
            world.add_joint(*ends, **given)

    def _note_name(self, given: dict[str, Any], at: Path) -> None:
        """Remember the name of a table; two of them must not have the same."""
        name = given.get("name")
        if name in self._called:
            self.wrong.append(
                ((*at, "name"), f"{_name(at)}: name is {name!r}, which {_name(self._called[name])} has; give another")
            )
        elif name is not None:
            self._called[name] = at

    def _end(self, found: Any, at: Path) -> Any:
        """Return the end of a joint as `World.add_joint` takes it; None if it, or the body that it is on, is wrong."""
        if isinstance(found, list):
            with self._telling(at, at[:-1]):
                return END["at"](found, at[-1])
            return None
        kinds = [kind for kind in PLACES if isinstance(found, dict) and kind in found]
        places = [place for place in ("at", "particle", "point") if kinds and place in found]
        if len(kinds) != 1 or len(places) != 1 or places[0] not in PLACES[kinds[0]]:
            hint = (
                "; of a soft body there may be particle = … in place of at, and of a suspension point" if kinds else ""
            )
            self.wrong.append((at, f"{_name(at)} is {shown(found)}; {END_HINT}{hint}"))
            return None
        before = len(self.wrong)
        given = self._checked(found, at, END, ())
        if len(self.wrong) > before:
            return None
        body = self._body(kinds[0], given.pop(kinds[0]), at)
        return None if body is None else (body, *given.values())

    def _body(self, kind: str, which: int | str, at: Path, key: str | None = None) -> Any:
        """Return the body of a kind that a `key`, if not the kind, names; None if it, or its table, is wrong."""
        table = self._called.get(which, (kind, which)) if isinstance(which, str) else (kind, which)
        if table not in self._bodies or table[0] != kind:
            names = [name for name, (of, _) in self._called.items() if of == kind]
            count = sum(of == kind for of, _ in self._bodies)
            there = names_listed(which, names) if isinstance(which, str) else f"give a number from 0 to {count - 1}"
            hint = there if count else f"there is none: add [[{kind}]]"
            self.wrong.append(((*at, key or kind), f"{_name(at)}: there is no {kind} {shown(which)}; {hint}"))
        return self._bodies.get(table)

    def _run(self, found: dict[str, Any], world: World) -> Run | None:
        before = len(self.wrong)
        given = self._table(found, "run", RUN, ("seconds",))
        if given is None or len(self.wrong) > before:
            return None
        run = Run(**given)
        with self._telling(("run",)):
            if run.time_step is not None:
                check_range(run.time_step, "time_step", "s", most=1.0 / run.frames_per_second)
                stable = world.stable_time_step()
                if run.time_step > stable:
                    raise ParameterError(
                        f"time_step is {run.time_step:.6g} s, and a stable one is {stable:.6g} s; take that, or leave "
                        "it out: the world chooses"
                    )
        return run

    def _film(self, found: dict[str, Any]) -> Film | None:
        given = self._table(found, "film", FILM)
        if given is None:
            return None
        film, run = Film(**given), found.get("run")
        if film.colour == "speed" and isinstance(run, dict) and run.get("velocities") is False:
            self.wrong.append((("film", "colour"), "film: colour speed needs velocities = true in [run]"))
        if film.colour in ("pressure", "strain", "speed") and "colour_range" not in found["film"]:
            self.wrong.append((("film", "colour"), f"film: colour {film.colour} needs a colour_range = [least, most]"))
        return film

    def _table(
        self, found: dict[str, Any], name: str, checks: dict[str, Check], needed: tuple[str, ...] = ()
    ) -> dict[str, Any] | None:
        """Return the values of a table, checked, or None if there is no such table."""
        return self._checked(found[name], (name,), checks, needed) if name in found else None

    def _list(self, found: dict[str, Any], name: str) -> list[tuple[Path, Any]]:
        tables = found.get(name, [])
        if not isinstance(tables, list):
            self.wrong.append(((name,), f"{name} is one table; begin each with [[{name}]]"))
            return []
        return [((name, k), table) for k, table in enumerate(tables)]

    def _checked(self, table: Any, at: Path, checks: dict[str, Check], needed: tuple[str, ...]) -> dict[str, Any]:
        """Return the good values of a table, and note what is wrong with the others."""
        if not isinstance(table, dict):
            self.wrong.append((at, f"{_name(at)} is {shown(table)}; give a table"))
            return {}
        self._names(table, tuple(checks), at)
        for name in needed:
            if name not in table:
                told = "gas, or pressure, is missing; add one" if name == "gas" else f"{name} is missing; add it"
                self.wrong.append((at, f"{_name(at)}: {told}"))
        good = {}
        for name, value in table.items():
            if name in checks:
                with self._telling((*at, name), at):
                    good[name] = checks[name](value, name)
        return good

    def _names(self, table: dict[str, Any], known: tuple[str, ...], at: Path) -> None:
        """Note the keys that nothing knows."""
        for name in table:
            if name not in known:
                where = f"{_name(at)}: " if at else ""
                told = f"{where}there is no {name!r}{_meant(name, known)}; choose from {', '.join(known)}"
                self.wrong.append(((*at, name), told))

    @contextmanager
    def _telling(self, at: Path, inside: Path | None = None) -> Iterator[None]:
        """Note the error, of the core's own, that ends the block, as one of what is `at` a path `inside` another."""
        try:
            yield
        except MissingPackageError as error:
            self.missing = error
        except SoftbodyError as error:
            argument, *more = str(error).split(" ", 3)
            key = (more[1], argument) if more[:1] == ["of"] else (argument,)  # "particle of b is 99"
            place = at if inside is not None else (*at, *key)
            self.wrong.append((place, f"{_name(at if inside is None else inside)}: {error}"))


def _name(at: Path) -> str:
    """Return what messages call a table: soft_body[1]."""
    return "".join(f"[{each}]" if isinstance(each, int) else f".{each}" for each in at).removeprefix(".")


def _meant(name: object, known: Any) -> str:
    close = get_close_matches(str(name), list(known), 1)
    return f"; did you mean {close[0]!r}?" if close else ""
