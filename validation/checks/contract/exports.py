"""Claims that other programs find in an exported file what was in the world."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from softbody import Camera, Trajectory, TrajectoryWriter, World, icosphere
from softbody.export import files, film, looks, meshes, usd
from softbody.export.animation import _Moving, _nearest_signs
from softbody.export.usd import _time_codes
from validation.answers import Answers
from validation.cases import BOX_TRIANGLES, corners_of, random_mesh, random_orientations, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.contract.crowds import Crowd
from validation.fault import Fault

FAMILY = "what is kept and exported"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

Shown = dict[str, tuple[np.ndarray, np.ndarray]]  # name of a body → vertices (n, 3) [m] and triangles (t, 3)
Pose = tuple[Shown, np.ndarray]  # bodies, and orientations of boxes (n, 4)


def crowded(rng: np.random.Generator) -> World:
    """Return a world of two soft bodies and two boxes, some metres from the origin."""
    world = World()
    world.add_ground(-3.0)
    for kind in ("torus", "lumpy sphere"):
        world.add_soft_body(random_mesh(kind, rng), 1.0, 100.0, 10.0, 5.0 * rng.normal(size=3))
    for mass in (1.0, None):
        turn = random_orientations(rng, 1)[0]
        world.add_box(rng.uniform(0.3, 2.0, 3), mass, 5.0 * rng.normal(size=3), turn)
    return world


def in_rows(shown: Shown, of: Iterable[str]) -> np.ndarray:
    """Return (m, 3): of each body its vertices, of a box in the order of their places, then a row with its volume."""
    from references import trimesh

    rows = []
    for name in of:
        vertices, triangles = shown[name]
        in_order = vertices[np.lexsort(vertices.T)] if name.startswith("box") else vertices
        rows += [in_order, np.full((1, 3), trimesh.volume(vertices, triangles))]
    return np.concatenate(rows)


def asked(question: Callable[..., Any], otherwise: Any, *about: Any) -> Any:
    """Return the answer to a question, or another one if there is none: a file that cannot be read shows nothing."""
    try:
        return question(*about)
    except Exception:
        return otherwise


def add_shown(answers: Answers, truth: Shown, kind: str, question: Callable[..., Shown], *about: Any) -> None:
    """Add bodies as they are, and as a file shows them: zeros where it shows none, or other numbers of vertices."""
    expected = in_rows(truth, truth)
    rows = asked(in_rows, expected[:0], asked(question, {}, *about), truth)
    answers.extend(rows if rows.shape == expected.shape else np.zeros_like(expected), expected, kind=kind)


def as_they_are(world: World) -> Shown:
    """Return the bodies of a world, from raw arrays."""
    shown = {f"soft_body_{k}": (b.positions.copy(), b.triangles.copy()) for k, b in enumerate(world.soft_bodies)}
    for k, box in enumerate(world.boxes):
        corners = corners_of(world.model.box_size[k]) @ rotation_matrix(box.orientation).T + box.position
        shown[f"box_{k}"] = corners, BOX_TRIANGLES
    return shown


def parted(world: World, vertices: np.ndarray, triangles: np.ndarray) -> Shown:
    """Return the bodies of one mesh, whose vertices and triangles are in order: soft bodies first, then boxes."""
    shown, first, row = {}, 0, 0
    counts = {f"soft_body_{k}": (len(b.positions), len(b.triangles)) for k, b in enumerate(world.soft_bodies)}
    counts |= {f"box_{k}": (8, 12) for k in range(len(world.boxes))}
    for name, (count, faces) in counts.items():
        shown[name] = vertices[first : first + count], triangles[row : row + faces] - first
        first, row = first + count, row + faces
    return shown


MOMENT = Fault("boxes that are not turned in a file", meshes.box_matrix, "matrix[:3, :3] = rotation_matrix(q_) → ")
SINGLE = "positions in single precision, of some metres: 2.4e-7 each way, more in a volume"


@check(
    section="beyond the paper",
    piece="softbody.World.export",
    reference="libigl's reader of PLY and OBJ, trimesh's of GLB, and glTF 2.0 and USD's text read by hand, binary USD"
    " printed by OpenUSD; raw arrays, boxes by NumPy",
    engines=("igl", "trimesh", "scipy", "pxr"),
    unit="metres; and cubic metres, of volumes",
    tolerance=1e-5,
    because=SINGLE,
    faults=(
        MOMENT,
        Fault("z up in a GLB file, too", meshes.as_scene, "Y_UP → np.eye(4)"),
        Fault(
            "boxes of half their size",
            meshes.box_mesh,
            "_cube().vertices * shapes.box_size[body] → 0.5 * _cube().vertices * shapes.box_size[body]",
        ),
        Fault("the cosine last in USD", usd._place, "m_.Quatd(w, x, y, z) → m_.Quatd(z, x, y, w)"),
        Fault(
            "USD in centimetres",
            usd.stage_bytes,
            "m_.SetStageMetersPerUnit(stage, 1.0) → m_.SetStageMetersPerUnit(stage, 0.01)",
        ),
        Fault("an OBJ of three digits", files._obj, "17 → 3"),
    ),
)
def moments_as_files(run: Run) -> Comparison:
    """Exported files show a world's bodies where they are, facing outwards.

    PLY and OBJ are read by libigl, GLB by trimesh and as the specification of glTF says, USD as its text says. Soft
    bodies are compared vertex by vertex, boxes corner by corner.
    """
    from references import gltf, trimesh
    from references import usd as by_hand

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(2, 10, 100)):
        world = crowded(rng)
        readers: dict[str, Callable[[Path], Shown]] = {
            "ply, by libigl": partial(_read, moving=None, world=world),
            "obj, by libigl": partial(_read, moving=None, world=world),
            "glb, by trimesh": trimesh.load_scene,
            "glb, by the specification": partial(_read, moving=gltf.Film, world=world),
            "usda": partial(_read, moving=by_hand.Stage, world=world),
            "usdc": partial(_read, moving=by_hand.Stage, world=world),
        }
        with tempfile.TemporaryDirectory() as folder:
            for kind, reader in readers.items():
                path = Path(folder) / f"now.{kind.partition(',')[0]}"
                add_shown(answers, as_they_are(world), kind, _exported, world, path, reader)
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.Trajectory.export",
    reference="glTF 2.0 and USD's text read by hand, as their specifications say, turns by SciPy; libigl's reader of"
    " PLY and OBJ",
    engines=("igl", "scipy", "trimesh", "pxr"),
    unit="metres; and cubic metres, of volumes",
    tolerance=2e-5,
    because=SINGLE,
    faults=(
        MOMENT,
        Fault(
            "shapes from frame to frame, in place of from the first",
            _Moving._targets,
            "now - first → now - points[k - actor.start - 1]",
        ),
        Fault("turns a frame late", _Moving._place, "_nearest_signs(x_) → _nearest_signs(np.roll(x_, 1, axis=0))"),
        Fault("shapes a frame late", _Moving._shape, "np.eye(frames, frames - 1, -1) → np.eye(frames, frames - 1, -2)"),
        Fault("signs of turns by the first", _nearest_signs, "q_[:-1] → q_[:1]"),
        Fault("a weight too many", _Moving._shape, "[0.0] * (frames - 1) → [0.0] * frames"),
        Fault("quaternions with w first", _Moving._place, "x_[:, [1, 2, 3, 0]] → x_[:, [0, 1, 2, 3]]"),
        Fault(
            "USD that counts frames from 1",
            _time_codes,
            "[float(code) for code in codes] → [float(code) + 1.0 for code in codes]",
        ),
        Fault(
            "USD whose frames that are not even last as long as each other",
            _time_codes,
            "codes = seconds * rate → codes = np.arange(len(seconds))",
        ),
        Fault("USD whose points stay", usd._put, "mesh.GetPointsAttr().Set(p_, code) → mesh.GetPointsAttr().Set(p_)"),
        Fault("two frames to a file", files.export_sequence, "f'{k:06d}.{kind}' → f'{k // 2:06d}.{kind}'"),
    ),
)
def films_as_files(run: Run) -> Comparison:
    """Exported films show each frame's bodies at its time.

    So do a trajectory's GLB and USD, whose frames are even or not. Between two frames soft bodies are on the straight
    way and boxes on the shortest turn. In GLB they are for viewers, too, that do not look for the shortest. Folders of
    PLY, OBJ, GLB and USD have a file for each frame, or every so many.
    """
    from references import gltf
    from references import usd as by_hand

    rng, answers = run.fresh_rng(), Answers()
    moving: dict[str, Callable[[Path], Any]] = {"glb": gltf.Film, "usda": by_hand.Stage, "usdc": by_hand.Stage}
    for trial in range(run.count(2, 4, 40)):
        world, is_even = crowded(rng), trial % 2 == 0
        # Frames that programs can count, eight a second, or none of them at a whole number of any rate.
        times = np.cumsum(np.full(6, 0.125) if is_even else rng.uniform(0.1, 0.15, 6))
        times -= times[0]
        with tempfile.TemporaryDirectory() as name:
            folder, poses = Path(name), list[Pose]()
            for _ in frames_to_keep(world, times, folder / "kept"):
                _shake(world, rng)
                poses.append((as_they_are(world), world.state.box_orientation.copy()))
            film = Trajectory.open(folder / "kept")
            for kind, reader in moving.items():
                if kind == "usdc" and not is_even:
                    continue
                seen = asked(_exported, None, film, folder / f"film.{kind}", reader)
                for time, (truth, _) in zip(times, poses):
                    add_shown(answers, truth, f"{kind} that moves, at a frame", _at, seen, time)
                for time, *both in zip(0.5 * (times[:-1] + times[1:]), poses, poses[1:]):
                    truth = _half_way(world, *both)
                    add_shown(answers, truth, f"{kind} that moves, between frames", _at, seen, time)
                if kind == "glb":  # (bodies, weights that are not one for each target, turns that go the long way)
                    answers.add(asked(_counts, [0.0] * 3, seen), [4.0, 0.0, 0.0], kind="weights and turns")
            for kind in ("ply", "obj", *moving) if is_even else ():
                asked(partial(film.export, folder / kind, kind, every=2), None)
                paths = asked(_files, [], folder / kind)
                for (truth, _), path in zip(poses[::2], paths):
                    add_shown(answers, truth, f"a folder of {kind}", _read, path, moving.get(kind), world)
                answers.add([float(len(paths))] * 3, [3.0] * 3, kind=f"a folder of {kind}")
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.Trajectory.export",
    reference="glTF 2.0 and USD's text read by hand, as their specifications say; raw arrays, boxes by NumPy",
    engines=("scipy", "trimesh", "pxr"),
    unit="metres; and cubic metres, of volumes",
    tolerance=2e-5,
    because="positions in single precision, of some hundred metres: 3.8e-6 each way, more in a volume",
    faults=(
        Fault("who comes later is there from the first", film.Actor.changes, "self.start == 0 → True"),
        Fault("who goes stays", film.Actor.changes, "self.stop < frames → False"),
        Fault("who goes fades", _Moving._show, "'STEP' → 'LINEAR'"),
        Fault("meshes by their names", film._is_same_mesh, "np.array_equal(a.box_size[i], b.box_size[j]) → True"),
        Fault(
            "rows of the first frame",
            _Moving._targets,
            "self._casts[k].shapes.particles(number) → self._casts[actor.start].shapes.particles(actor.numbers[0])",
        ),
        Fault(
            "boxes by the number of now",
            _Moving._place,
            "pose.box_position[body] → pose.box_position[actor.numbers[0]]",
        ),
        Fault("nobody is invisible in USD", usd.stage_bytes, "'inherited' if is_there else 'invisible' → 'inherited'"),
        Fault("files of the first bodies", Trajectory.export, "self._cast_of(number), p_ → self._cast_of(0), p_"),
    ),
)
def films_of_bodies_that_come_and_go(run: Run) -> Comparison:
    """Exported films show each frame's own bodies, and no other ones.

    Soft bodies and boxes are added, removed, or replaced between frames, by others of the same name, too. GLB and USD
    show, by their names or numbers, those of the frame at its time, and until the next one. So does a folder of GLB.
    """
    from references import gltf
    from references import usd as by_hand

    rng, answers = run.fresh_rng(), Answers()
    moving: dict[str, Callable[[Path], Any]] = {"glb": gltf.Film, "usda": by_hand.Stage, "usdc": by_hand.Stage}
    for trial in range(run.count(2, 6, 60)):
        crowd, truths, times = Crowd(rng, least=1), list[Shown](), np.arange(9) / 8.0
        for title in ("soft a", "box a", "soft b", "box b"):
            (crowd.add_soft if title.startswith("soft") else crowd.add_box)(title)
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            with TrajectoryWriter(crowd.world, folder / "kept") as kept:
                for k, time in enumerate(times.tolist()):
                    if k in (1, 5):  # those after it have other numbers, and are the same
                        crowd.remove(k == 1, 0)
                    elif k == 2:  # one of the same name, and of another mesh, that comes last
                        crowd.add_box(crowd.remove(False, 1))
                    elif k in (6, 8):
                        crowd.change()
                    _shake(crowd.world, rng)
                    crowd.world.time = time
                    kept.frame()
                    truths.append(dict(zip(crowd.titles(), as_they_are(crowd.world).values())))
            trajectory = Trajectory.open(folder / "kept")
            for kind, reader in moving.items():
                if kind == "usdc" and trial:
                    continue
                seen = asked(_exported, None, trajectory, folder / f"film.{kind}", reader)
                for time, truth in zip(times, truths):
                    add_cast(answers, truth, kind, _at, seen, time)
                    answers.add([asked(len, 0, asked(_at, {}, seen, time + 0.06))] * 3, [len(truth)] * 3, kind=kind)
            asked(partial(trajectory.export, folder / "glb", "glb"), None)
            for truth, path in zip(truths, asked(_files, [], folder / "glb")):
                add_cast(answers, truth, "a folder of glb", _read, path, gltf.Film, crowd.world)
    return answers.comparison()


def add_cast(answers: Answers, truth: Shown, kind: str, question: Callable[..., Shown], *about: Any) -> None:
    """Add what a file shows of bodies, by what they are called but since when, and how many it shows."""
    shown = {title.partition(" from frame ")[0]: each for title, each in asked(question, {}, *about).items()}
    answers.add([len(asked(question, {}, *about))] * 3, [len(truth)] * 3, kind=kind)
    add_shown(answers, truth, kind, lambda: shown)


@check(
    section="beyond the paper",
    piece="softbody.World.export, softbody.World.picture",
    reference="pixels of a picture from the side that lies in shadow, as shares of light (power 2.2); glTF 2.0 and"
    " USD's text read by hand",
    kind="specification",
    engines=("trimesh", "pxr"),
    unit="of a unit vector of red, green and blue, as a screen is told",
    tolerance=0.03,
    because="pictures and GLB have eight bits a colour: 5.3e-3 at worst of ten seeds; colours are 0.2 apart and more",
    faults=(
        Fault("bodies without a colour", meshes._add, "mesh.visual = v_ → "),
        Fault("colours as screens are told", looks.looks_of, "np.array(colour) ** GAMMA → np.array(colour)"),
        Fault("boxes that begin anew", looks.looks_of, "colour_of(len(soft) + k) → colour_of(k)"),
    ),
)
def colours_of_bodies(run: Run) -> Comparison:
    """A body has in GLB and USD files its picture's colour.

    It is compared up to how bright it is: of two to eight bodies, soft ones and boxes, some of which cannot move, each
    of its own colour.
    """
    from references import gltf
    from references import usd as by_hand

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(2, 6, 60)):
        world = World()
        for k in range(int(rng.integers(1, 4))):
            world.add_soft_body(icosphere(2, 0.5), 1.0, 100.0, 10.0, (10.0 * k, -8.0 * k, 2.0))
        first = len(world.soft_bodies)
        for k in range(first, first + int(rng.integers(1, 6))):
            mass = None if rng.random() < 0.3 else 1.0
            world.add_box((1.0, 1.0, 1.0), mass, (10.0 * k, -8.0 * k, 2.0))
        with tempfile.TemporaryDirectory() as folder:
            colours_in = {
                "GLB": _exported(world, Path(folder) / "now.glb", gltf.Film).colours(),
                "USD": _exported(world, Path(folder) / "now.usda", by_hand.Stage).colours(),
            }
        bodies = {f"soft_body_{k}": body.centre for k, body in enumerate(world.soft_bodies)}
        bodies |= {f"box_{k}": box.position for k, box in enumerate(world.boxes)}
        for title, place in bodies.items():
            eye = place + np.array([1.54, 1.26, -0.2])  # the light comes from −x, −y
            camera = Camera(tuple(eye), tuple(place), 5.0)
            pixels = world.picture(camera=camera, size=(16, 16), colour="plain").reshape(-1, 3).mean(axis=0)
            for kind, colours in colours_in.items():
                screen = colours.get(title, np.ones(3)) ** (1.0 / 2.2)
                answers.add(screen / np.linalg.norm(screen), pixels / np.linalg.norm(pixels), kind=kind)
    return answers.comparison()


def _exported(what: World | Trajectory, path: Path, reader: Callable[[Path], Any]) -> Any:
    """Return what a reader makes of a file."""
    what.export(path)
    return reader(path)


def _files(folder: Path) -> list[Path]:
    return sorted(folder.iterdir())


def _at(film: Any, time: float) -> Shown:
    return film.shown(time)  # type: ignore[no-any-return]


def _counts(film: Any) -> list[float]:
    """Return how many bodies a GLB file has, how many of them of a wrong number of weights, and its long turns."""
    weights = film.weights()
    return [float(len(weights)), float(sum(one != other for one, other in weights)), float(film.long_turns())]


def _read(path: Path, moving: Callable[[Path], Any] | None, world: World) -> Shown:
    from references import igl

    return moving(path).shown() if moving else parted(world, *igl.read_mesh(path))


def frames_to_keep(world: World, times: np.ndarray, folder: Path) -> Iterator[None]:
    """Keep a frame at each time, of the world as it is made in between: the caller moves it before each."""
    with TrajectoryWriter(world, folder) as kept:
        for time in times.tolist():
            yield
            world.time = time
            kept.frame()


def _shake(world: World, rng: np.random.Generator) -> None:
    """Put everything a little aside; a quaternion may change its sign, and means the same."""
    state = world.state
    state.particle_position[:] += 0.01 * rng.normal(size=state.particle_position.shape)
    state.box_position[:] += 0.1 * rng.normal(size=state.box_position.shape)
    turned = state.box_orientation + 0.2 * rng.normal(size=state.box_orientation.shape)
    turned *= rng.choice([-1.0, 1.0], (len(turned), 1))
    state.box_orientation[:] = turned / np.linalg.norm(turned, axis=1, keepdims=True)


def _half_way(world: World, one: Pose, other: Pose) -> Shown:
    """Return what is between two poses: shapes and places half-way, turns by the shortest arc."""
    from references import rotation

    shown = {name: (0.5 * (vertices + other[0][name][0]), triangles) for name, (vertices, triangles) in one[0].items()}
    for k, size in enumerate(world.model.box_size):
        middle = 0.5 * (one[0][f"box_{k}"][0].mean(axis=0) + other[0][f"box_{k}"][0].mean(axis=0))
        turn = rotation.half_way(one[1][k], other[1][k])
        shown[f"box_{k}"] = corners_of(size) @ rotation_matrix(turn).T + middle, BOX_TRIANGLES
    return shown


@check(
    section="beyond the paper",
    piece="softbody.Trajectory.export",
    reference="what is documented; the times in the file's text, read by hand",
    kind="specification",
    engines=("pxr",),
    because="yes or no; times of up to a minute are kept to 1e-14 s",
    faults=(
        Fault("a hundredth less even", _time_codes, "x_.max() < EVEN → x_.max() < 1.01 * EVEN"),
        Fault("frames that are never counted", _time_codes, "x_.max() < EVEN → False"),
        Fault("even to a millionth of a second", _time_codes, "x_.max() < EVEN → x_.max() < whole * EVEN"),
    ),
)
def frames_that_are_counted(run: Run) -> Comparison:
    """Programs count the frames of a USD that come evenly.

    Their times are whole numbers then. They do if frames come a whole number a second, each to a millionth of a frame:
    with one that is late or early by 0.5, 0.997, 1.003 and 2 millionths.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(16, 48, 400)):
        factor, rate, late = (0.5, 0.997, 1.003, 2.0)[trial % 4], int(rng.integers(2, 100)), int(rng.integers(1, 5))
        times = np.arange(6.0) / rate
        times[late] += rng.choice([-1.0, 1.0]) * factor * 1e-6 / rate
        world = World()
        world.add_box((1.0, 1.0, 1.0), 1.0)
        with tempfile.TemporaryDirectory() as folder:
            kept, path = Path(folder) / "kept", Path(folder) / "film.usda"
            for _ in frames_to_keep(world, times, kept):
                world.state.box_position[0] = rng.normal(size=3)
            text = _exported(Trajectory.open(kept), path, Path.read_text)
        codes = [float(code) for code in re.findall(r"^\s*([-+.e\d]+): \(", text, re.MULTILINE)]
        is_counted = len(codes) >= 6 and all(code.is_integer() for code in codes)
        answers.add(is_counted, factor < 1.0, kind=f"{factor} millionths of a frame")
    return answers.comparison()
