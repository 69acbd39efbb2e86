"""Claims that every argument is taken up to its documented limit, and refused beyond, by name."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import softbody
from softbody import Mesh, MeshError, ParameterError, Trajectory, TrajectoryWriter, World, geometry
from softbody.mesh import mesh as meshes
from softbody.model import settings, validation
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

BALL = softbody.icosphere(1, 0.5)
LEAST, NAN, INF = 5e-324, float("nan"), float("inf")


ROWS = {"points": "point", "vertices": "vertex", "triangles": "triangle"}  # what one of an array's rows is called


class Limits(NamedTuple):
    """What an argument takes, up to its limits, and what it refuses, from just beyond them."""

    taken: tuple[Any, ...]
    refused: tuple[Any, ...]
    told: tuple[str, ...] = ()  # what the refusal of a number that is beyond them says besides


MOST_SAID = 1000  # characters of a refusal, however much was given
NO_NUMBERS = ("two", 1j, None, [1.0, 2.0], NAN, INF, -INF, 10**400, "many" * MOST_SAID)
POSITIVE = Limits((1.0, 2, np.float32(0.5), np.array(0.25)), (0.0, -0.0, -LEAST, -1.0, *NO_NUMBERS), ("> 0",))
NOT_NEGATIVE = Limits((0.0, LEAST, 1.0, 2), (-LEAST, -1.0, *NO_NUMBERS), ("≥ 0",))
UP_TO_ONE = Limits((0.0, LEAST, 1.0, 1), (-LEAST, np.nextafter(1.0, 2.0), 2, *NO_NUMBERS), ("≥ 0", "≤ 1"))
VECTOR = Limits(
    ((0.0, 0.0, 0.0), [1, 2, 3], np.array([0.0, -0.5, 1.0], np.float32)),
    ((1.0, 2.0), (1.0, 2.0, 3.0, 4.0), 1.0, (0.0, NAN, 0.0), (0.0, 0.0, INF), "abc", (0.0, 1j, 0.0), None),
)
LENGTHS = Limits(((1.0, 2.0, 3.0), [1, 2, 1]), ((1.0, 0.0, 1.0), (1.0, 1.0, -LEAST), *VECTOR.refused[:-1]))
TURN = Limits(
    ((1.0, 0.0, 0.0, 0.0), (0.6, 0.0, -0.8, 0.0), (0.0, 0.0, 1.0 + 0.99e-6, 0.0), (1.0 - 0.99e-6, 0.0, 0.0, 0.0)),
    (
        (0.0, 0.0, 1.0 + 1.01e-6, 0.0),
        (1.0 - 1.01e-6, 0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0, 0.0),
        (1.0, 0.0, 0.0),
        (NAN, 0.0, 0.0, 1.0),
        (1e200, 0.0, 0.0, 0.0),
        "turn",
        1.0,
    ),
)
YES_OR_NO = Limits((True, False, np.True_), (1, 0, "yes", None, 1.0))


def whole(least: int, most: int | None = None, taken: tuple[int, ...] = ()) -> Limits:
    """Return the limits of a whole number from `least` on; of a largest one only what is beyond is tried."""
    beyond = (least - 1, least + 0.5, float(least), "3", None, NAN, np.timedelta64(3, "s"))
    return Limits((least, np.int64(least), *taken), beyond + (() if most is None else (most + 1,)))


def soft(**changes: Any) -> World:
    """Return a world with a soft body that is told something else than usual."""
    world = World()
    usual: dict[str, Any] = {"mesh": BALL, "mass": 1.0, "stiffness": 100.0, "gas": 10.0}
    world.add_soft_body(**usual | changes)
    return world


def rigid(**changes: Any) -> World:
    """Return a world with a box that is told something else than usual."""
    world = World()
    usual: dict[str, Any] = {"size": (1.0, 1.0, 1.0), "mass": 1.0}
    world.add_box(**usual | changes)
    return world


def joined(**changes: Any) -> World:
    """Return a world with a joint that is told something else than usual."""
    world = rigid()
    usual: dict[str, Any] = {"a": (world.boxes[0], (0.5, 0.0, 0.0)), "b": (2.0, 0.0, 0.0), "stiffness": 1.0}
    world.add_joint(**usual | changes)
    return world


def having(make: Callable[[], World], body: str, name: str) -> Callable[[Any], None]:
    """Return what sets an attribute of the first body of a kind, in a world of its own."""

    def set_it(value: Any) -> None:
        bodies = getattr(make(), body)
        setattr(bodies if body == "ground" else bodies[0], name, value)

    return set_it


def on_the_ground() -> World:
    """Return a world with ground."""
    world = World()
    world.add_ground()
    return world


def told(function: Callable[..., Any], name: str, *before: Any, **others: Any) -> Callable[[Any], Any]:
    """Return what calls a function with one argument by name, and others."""
    return lambda value: function(*before, **others, **{name: value})


def of_bodies() -> Iterator[tuple[str, Callable[[Any], Any], Limits]]:
    """Yield the arguments of bodies, joints and the ground: as Python writes them, what takes a value, its limits."""
    for name, limits in {
        "mass": POSITIVE,
        "stiffness": Limits((0.0, LEAST, 1.0, np.ones(120)), (-LEAST, NAN, INF, "two", 1j, np.ones(119), np.ones(121))),
        "gas": NOT_NEGATIVE,
        "position": VECTOR,
        "velocity": VECTOR,
        "rest_length": Limits(
            (None, LEAST, 1.0, np.ones(120)), (0.0, -1.0, NAN, INF, "two", 1j, np.ones(119), np.ones(121))
        ),
        "damping": Limits(
            (None, *NOT_NEGATIVE.taken), tuple(each for each in NOT_NEGATIVE.refused if each is not None)
        ),
        "fixed": Limits(((), (0,), (41,), [0, 0], range(41)), ((42,), (-1,), (0.0,), "ab", range(42), ((0,), (1,)))),
        "drag": NOT_NEGATIVE,
        "restitution": UP_TO_ONE,
        "friction": NOT_NEGATIVE,
        "deflated_below": UP_TO_ONE,
    }.items():
        yield f"add_soft_body({name}=…)", told(soft, name), limits
        if name in ("drag", "restitution", "friction", "deflated_below", "gas", "fixed"):
            yield f"soft_body.{name} = …", having(soft, "soft_bodies", name), limits
        if name in ("stiffness", "rest_length"):
            yield f"soft_body.set_springs({name}=…)", partial(_set_springs, name), limits
    rows = np.ones((42, 3))
    arrays = Limits((rows, rows.tolist()), (rows[1:], np.where(rows.cumsum(0) == 2.0, NAN, rows), "abc", 1j * rows))
    for name in ("positions", "velocities", "external_force"):
        yield f"soft_body.{name} = …", having(soft, "soft_bodies", name), arrays
    yield "soft_body.damping = …", having(soft, "soft_bodies", "damping"), NOT_NEGATIVE
    for name, limits in {
        "size": LENGTHS,
        "mass": _optional(POSITIVE),
        "position": VECTOR,
        "orientation": TURN,
        "velocity": VECTOR,
        "angular_velocity": VECTOR,
        "restitution": UP_TO_ONE,
        "friction": NOT_NEGATIVE,
    }.items():
        yield f"add_box({name}=…)", told(rigid, name), limits
        if name not in ("size", "mass"):
            yield f"box.{name} = …", having(rigid, "boxes", name), limits
    # (1 / 1e-308 is finite, and 1 / 5e-324 is not; a needle turns about its axis more easily than it moves.)
    yield "add_soft_body(mass=…), hardly any", told(soft, "mass"), Limits((1e-300,), (LEAST,))
    yield "add_box(mass=…), hardly any", told(rigid, "mass"), Limits((1e-300,), (LEAST,))
    yield "add_box(mass=…), of a needle", told(rigid, "mass", size=(1e50, 1e-50, 1e-50)), Limits((1e-200,), (1e-210,))
    for name in ("position", "orientation"):
        yield f"box.move_to({name}=…)", partial(_move, name), _optional(TURN if name == "orientation" else VECTOR)
    yield "box.move_to(seconds=…)", lambda value: _kinematic().move_to((1.0, 0.0, 0.0), seconds=value), POSITIVE
    yield "box.apply_force(force=…)", lambda value: rigid().boxes[0].apply_force(force=value), VECTOR
    yield (
        "box.apply_force(point=…)",
        lambda value: rigid().boxes[0].apply_force((1.0, 0.0, 0.0), point=value),
        _optional(VECTOR),
    )
    yield "box.apply_torque(torque=…)", lambda value: rigid().boxes[0].apply_torque(torque=value), VECTOR
    for name in ("stiffness", "damping", "rest_length"):
        yield f"add_joint({name}=…)", told(joined, name), NOT_NEGATIVE
        yield f"joint.{name} = …", having(joined, "joints", name), NOT_NEGATIVE
    number = Limits((0, 41, np.int64(1)), (-1, 42, 1.0, np.inf))
    yield "add_joint(a=…), a particle", _tie, number
    yield "joint.target = …", having(joined, "joints", "target"), VECTOR
    for name, limits in {"height": Limits((0.0, -1.0, 1e6), NO_NUMBERS), "restitution": UP_TO_ONE}.items():
        yield f"add_ground({name}=…)", told(World().add_ground, name), limits
        yield f"ground.{name} = …", having(on_the_ground, "ground", name), limits
    yield "add_ground(friction=…)", told(World().add_ground, "friction"), NOT_NEGATIVE
    yield "ground.friction = …", having(on_the_ground, "ground", "friction"), NOT_NEGATIVE


def _set_springs(name: str, value: Any) -> None:
    soft().soft_bodies[0].set_springs(**{name: value})


def _tie(particle: Any) -> None:
    world = soft()
    world.add_joint((world.soft_bodies[0], particle), (2.0, 0.0, 0.0), 1.0)


def _move(name: str, value: Any) -> None:
    _kinematic().move_to(seconds=1.0, **{name: value})


def _kinematic() -> softbody.Box:
    return rigid(mass=None).boxes[0]


def of_worlds(folder: Path) -> Iterator[tuple[str, Callable[[Any], Any], Limits]]:
    """Yield the arguments of worlds, of their steps and of what is kept of them."""
    ceiling = Limits((0.0, 1.0, INF), (-LEAST, NAN, -INF, "two", 1j, None))
    for name, limits in {
        "gravity": VECTOR,
        "precision": Limits(("double", "single"), ("half", 64, None)),
        "threads": whole(1, taken=(2,)),
        "integrator": Limits(("symplectic_euler", "rk4", "rk4_velocity"), ("euler", 1, None, "RK4")),
        "substeps": whole(1, 10_000_000, (10_000_000,)),
        "iterations": whole(1, 10_000_000, (10_000_000,)),
        "edge_contacts": YES_OR_NO,
        "split_steps": YES_OR_NO,
        "frictionless": YES_OR_NO,
        "gyroscopic": YES_OR_NO,
        "speed_ceiling": ceiling,
        "angular_speed_ceiling": ceiling,
        "angular_speed_floor": ceiling,
        "axes": Limits(("complete", "paper"), ("all", None)),
        "contact": Limits(("manifold", "single"), ("face", None)),
        "soft_contact": Limits(("together", "single"), ("alone", None)),
        "pairs": Limits(("grid", "exhaustive"), ("tree", None)),
    }.items():
        yield f"World({name}=…)", told(World, name), limits
    yield "world.integrator = …", partial(setattr, World(), "integrator"), Limits(("rk4",), ("euler", 1, None))
    yield "world.substeps = …", partial(setattr, World(), "substeps"), whole(1, 10_000_000, (10_000_000,))
    yield "world.threads = …", partial(setattr, World(), "threads"), whole(1, taken=(2,))
    yield "world.gravity = …", partial(setattr, World(), "gravity"), VECTOR
    seconds = Limits((0.0, LEAST, 1e-3), NOT_NEGATIVE.refused)
    yield "world.step(time_step=…)", rigid().step, Limits((1e-3, LEAST), POSITIVE.refused)
    for what, make in {"a joint": joined, "a soft body": soft}.items():
        longest = make().stable_time_step()
        limits = Limits((longest,), (float(np.nextafter(longest, INF)),))
        yield f"world.step(time_step=…), of {what}", partial(_step_anew, make), limits
    yield "world.step(steps=…)", lambda value: rigid().step(1e-3, value), whole(0, taken=(3,))
    yield "world.step(substeps=…)", lambda value: rigid().step(1e-3, substeps=value), _optional(whole(1, taken=(3,)))
    yield "world.step(allow_unstable=…)", lambda value: rigid().step(1e-3, allow_unstable=value), YES_OR_NO
    yield "world.run(seconds=…)", lambda value: rigid().run(value, 1e-3), seconds
    yield (
        "world.run(time_step=…)",
        lambda value: rigid().run(0.0, value),
        _optional(Limits((1e-3, 1.0), POSITIVE.refused)),
    )
    yield (
        "world.run(seconds=…), of steps",
        lambda value: rigid().run(value, 1.0),
        _refused(Limits((), (1.5 * 2.0**62,))),
    )
    yield "world.run(seconds=…), by itself", lambda value: rigid().run(value), seconds
    yield "world.step_frame(seconds=…)", lambda value: rigid().step_frame(value), seconds
    yield (
        "world.step_frame(time_step=…)",
        lambda value: rigid().step_frame(1e-3, time_step=value),
        _optional(Limits((1e-3, 1.0), POSITIVE.refused)),
    )
    yield "world.frames(seconds=…)", lambda value: list(rigid().frames(seconds=value)), seconds
    yield "world.frames(per_second=…)", lambda value: list(rigid().frames(0.0, per_second=value)), POSITIVE
    yield "world.equilibrium(tolerance=…)", lambda value: rigid().equilibrium(tolerance=value), POSITIVE
    yield "world.equilibrium(steps=…)", lambda value: rigid().equilibrium(steps=value), whole(1)
    kept, written = folder / "kept.npz", folder / "written"
    rigid().save(kept)
    yield "World.load(most_bytes=…)", lambda value: World.load(kept, value), Limits((2**40,), whole(1).refused)
    packed, ball = folder / "packed.npz", World()
    ball.add_soft_body(softbody.icosphere(3), 1.0, 100.0, 10.0)
    np.savez_compressed(packed, **ball.snapshot())  # type: ignore[arg-type]
    bytes_ = sum(array.nbytes for array in ball.snapshot().values())  # more than the file has
    yield "World.load(most_bytes=…), packed", lambda value: World.load(packed, value), Limits((bytes_,), (bytes_ - 1,))
    film = folder / "film"
    with TrajectoryWriter(rigid(), film, 60.0) as writer:
        writer.run(0.05, 1e-2)
    trajectory = Trajectory(film)
    yield "Trajectory(most_bytes=…)", lambda value: Trajectory(film, value), Limits((2**40,), whole(1).refused)
    yield "trajectory.particles(body=…)", Trajectory(_film_of_two(folder)).particles, whole(0, 1, (1,))
    yield (
        "trajectory.export(every=…)",
        lambda value: trajectory.export(folder / "a.npz", every=value),
        _refused(whole(1)),
    )

    def record(value: Any, name: str, **others: Any) -> None:
        TrajectoryWriter(rigid(), written / str(len(list(folder.iterdir()))), **{name: value}, **others).close()

    yield "TrajectoryWriter(frames_per_second=…)", partial(record, name="frames_per_second"), _refused(POSITIVE)
    yield "TrajectoryWriter(velocities=…)", partial(record, name="velocities"), _refused(YES_OR_NO)
    yield "TrajectoryWriter(resume=…)", partial(record, name="resume"), _refused(YES_OR_NO)


def _step_anew(make: Callable[[], World], time_step: float) -> None:
    make().step(time_step)


def _film_of_two(folder: Path) -> Path:
    world = soft()
    world.add_soft_body(BALL, 1.0, 100.0, 10.0, (5.0, 0.0, 0.0))
    with TrajectoryWriter(world, folder / "two", 60.0) as writer:
        writer.frame()
    return folder / "two"


def _optional(limits: Limits) -> Limits:
    """Return limits of what may be None as well."""
    return Limits((None, *limits.taken), tuple(each for each in limits.refused if each is not None), limits.told)


def _refused(limits: Limits) -> Limits:
    """Return limits of which only what is refused is tried."""
    return Limits((), limits.refused, limits.told)


def of_meshes() -> Iterator[tuple[str, Callable[[Any], Any], Limits]]:
    """Yield the arguments of meshes, and of questions about them."""
    for shape in (softbody.tetrahedron, softbody.octahedron, softbody.icosahedron, softbody.icosphere):
        yield f"{shape.__name__}(radius=…)", told(shape, "radius"), POSITIVE
    yield "icosphere(subdivisions=…)", softbody.icosphere, whole(0, 10, (2,))
    big, small = {"minor_radius": 1e-6}, {"major_radius": 10.0}
    yield "torus(major_radius=…)", told(softbody.torus, "major_radius", **big), POSITIVE
    yield "torus(minor_radius=…)", told(softbody.torus, "minor_radius", **small), POSITIVE
    below = np.nextafter(2.0, 1.0)
    wider = Limits((below,), (2.0, np.nextafter(2.0, 3.0)))
    yield "torus(minor_radius=…), of 2 m", told(softbody.torus, "minor_radius", major_radius=2.0), wider
    yield "torus(major_segments=…)", told(softbody.torus, "major_segments"), whole(3)
    yield "torus(minor_segments=…)", told(softbody.torus, "minor_segments"), whole(3)
    yield "box(size=…)", softbody.box, LENGTHS
    yield "box(segments=…)", told(softbody.box, "segments"), whole(1, taken=(2,))
    yield "mesh.moved(offset=…)", BALL.moved, VECTOR
    yield "mesh.scaled(factor=…)", BALL.scaled, POSITIVE
    corners = BALL.vertices[BALL.triangles]
    yield (
        "Mesh.from_soup(tolerance=…)",
        told(Mesh.from_soup, "tolerance", corners),
        Limits((0.0, 1e-9), NOT_NEGATIVE.refused),
    )
    yield "Mesh.from_trimesh(tolerance=…)", told(Mesh.from_trimesh, "tolerance", _Faces(BALL)), _refused(NOT_NEGATIVE)
    yield "Mesh.from_trimesh(merge=…)", told(Mesh.from_trimesh, "merge", _Faces(BALL)), YES_OR_NO
    yield (
        "Mesh.from_trimesh(merge=…), of a soup",
        told(Mesh.from_trimesh, "merge", _Soup(BALL)),
        Limits((True,), (False,)),
    )
    nothing = np.zeros((0, 3))
    yield "Mesh(vertices=…), of nothing", lambda value: Mesh(value, nothing.astype(int)), Limits((), (nothing,))
    arrays = BALL.vertices, BALL.triangles
    density = Limits((0.25, 64.0, LEAST), (np.nextafter(64.0, 65.0), *POSITIVE.refused))
    yield "MeshQuery(columns_per_triangle=…)", partial(geometry.MeshQuery, *arrays), density
    for ask in (geometry.points_in_mesh, geometry.closest_on_mesh):
        yield f"{ask.__name__}(threads=…)", told(ask, "threads", np.zeros((1, 3)), *arrays), whole(1)
        yield (
            f"{ask.__name__}(points=…)",
            told(ask, "points", vertices=arrays[0], triangles=arrays[1]),
            _rows(arrays[0]),
        )
    of_vertices, of_triangles = _limits_of_arrays(*arrays)
    for make in (Mesh, geometry.MeshQuery):
        yield f"{make.__name__}(vertices=…)", told(make, "vertices", triangles=arrays[1]), of_vertices
        yield f"{make.__name__}(triangles=…)", told(make, "triangles", arrays[0]), of_triangles


def _rows(rows: np.ndarray) -> Limits:
    """Return the limits of rows of three numbers, as many as there may be, of which none is infinite or none at all."""
    first, last = rows.copy(), rows.copy()
    first[0, 2], last[-1, 0] = NAN, INF
    return Limits(
        (rows, rows.tolist(), rows.astype(np.float32)), (first, last, rows[0], rows[:, :2], "abc", 1j * rows, None)
    )


def _limits_of_arrays(vertices: np.ndarray, triangles: np.ndarray) -> tuple[Limits, Limits]:
    """Return the limits of the vertices and of the triangles of a mesh."""
    below, beyond, count = triangles.copy(), triangles.copy(), len(vertices)
    below[-1, 1], beyond[0, 0] = -1, count
    bad = (below, beyond, triangles + 0.5, triangles[0], triangles[:, :2], triangles[:0], "abc", 1j * triangles)
    of_vertices = _rows(vertices)
    return of_vertices, Limits((triangles, triangles.tolist(), triangles.astype(np.uint32)), bad)


class _Faces:
    """A mesh as other libraries have it."""

    def __init__(self, mesh: Mesh) -> None:
        self.vertices, self.faces = mesh.vertices, mesh.triangles


class _Soup:
    """A mesh whose triangles do not share their vertices."""

    def __init__(self, mesh: Mesh) -> None:
        self.vertices = mesh.vertices[mesh.triangles].reshape(-1, 3)
        self.faces = np.arange(len(self.vertices)).reshape(-1, 3)


def is_taken(call: Callable[[Any], Any], value: Any) -> bool:
    """Tell whether a call takes a value."""
    try:
        call(value)
    except Exception:
        return False
    return True


def is_refused_by_name(call: Callable[[Any], Any], value: Any, name: str, told: tuple[str, ...]) -> bool:
    """Tell whether a call refuses a value, and says briefly which argument it was; of a number also the limits."""
    is_number = isinstance(value, float)
    try:
        call(value)
    except Exception as error:
        text = str(error)
        is_named = name in text or ROWS.get(name, name) in text
        is_told = all(limit in text for limit in told) or not is_number
        return isinstance(error, (ParameterError, MeshError)) and is_named and is_told and len(text) <= MOST_SAID
    return False


@check(
    section="2",
    piece="softbody.errors, softbody.Mesh, softbody.World, softbody.SoftBody, softbody.Box, softbody.Joint,"
    " softbody.Ground, softbody.Trajectory, softbody.TrajectoryWriter",
    reference="the documentation: from where to where each argument may be",
    kind="specification",
    faults=(
        Fault("nothing is negative enough", validation.check_range, "least <= value <= most → value <= most"),
        Fault("most is too much", validation.check_range, "least <= value <= most → least <= value < most"),
        Fault("turns of any length", validation.unit_quaternion, "abs(length - 1.0) <= QUATERNION_TOLERANCE → True"),
        Fault("the last vertex cannot be fixed", validation.fixed_particles_of, "array >= count → array >= count - 1"),
        Fault("a torus that meets itself", meshes.torus, "major_radius > minor_radius → major_radius >= minor_radius"),
        Fault("no sweep at all", settings.settings_of, "check_whole(value, name, 1) → check_whole(value, name, 0)"),
    ),
)
def every_argument_has_its_limits(run: Run) -> Comparison:
    """Every number, vector, turn, choice and yes or no that the public API takes is taken up to the very limit that its
    documentation names, and refused from the next number on, by an error that names it: NaN, infinite, of another kind,
    one digit too many."""
    right, kinds = [], []
    with tempfile.TemporaryDirectory() as folder:
        for what, call, limits in (*of_bodies(), *of_worlds(Path(folder)), *of_meshes()):
            name = what.partition("(")[2].partition("=")[0] or what.partition(".")[2].partition(" ")[0]
            for value in limits.taken:
                right.append(is_taken(call, value))
                kinds.append(what)
            for value in limits.refused:
                right.append(is_refused_by_name(call, value, name, limits.told))
                kinds.append(what)
    return Comparison(np.array(right), np.ones(len(right), bool), groups=kinds)
