"""Claims that every argument is taken up to its documented limit, and refused beyond, by name."""

from __future__ import annotations

import inspect
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

import softbody
from softbody import Mesh, MeshError, ParameterError, Trajectory, TrajectoryWriter, World, geometry
from softbody.mesh import mesh as meshes
from softbody.model import settings, validation
from softbody.model.properties import known_properties
from validation.answers import Answers
from validation.cases import settable
from validation.check import Comparison, Run, check
from validation.checks.contract.cases import BALL, error_of, rigid, soft
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

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
HARDLY, TOO_FAR = 0.99e-6, 1.01e-6  # from a length of 1
NO_TURNS = (0.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (NAN, 0.0, 0.0, 1.0), (1e200, 0.0, 0.0, 0.0), "turn", 1.0
TURN = Limits(
    ((1.0, 0.0, 0.0, 0.0), (0.6, 0.0, -0.8, 0.0), (0.0, 0.0, 1.0 + HARDLY, 0.0), (1.0 - HARDLY, 0.0, 0.0, 0.0)),
    ((0.0, 0.0, 1.0 + TOO_FAR, 0.0), (1.0 - TOO_FAR, 0.0, 0.0, 0.0), *NO_TURNS),
)
YES_OR_NO = Limits((True, False, np.True_), (1, 0, "yes", None, 1.0))


def whole(least: int, most: int | None = None, taken: tuple[int, ...] = ()) -> Limits:
    """Return the limits of a whole number from `least` on; of a largest one only what is beyond is tried."""
    beyond = (least - 1, least + 0.5, float(least), "3", None, NAN, np.timedelta64(3, "s"))
    return Limits((least, np.int64(least), *taken), beyond + (() if most is None else (most + 1,)))


def joined(**changes: Any) -> World:
    """Return a world with a joint that is told something else than usual."""
    world = rigid()
    usual: dict[str, Any] = {"a": (world.boxes[0], (0.5, 0.0, 0.0)), "b": (2.0, 0.0, 0.0), "stiffness": 1.0}
    world.add_joint(**usual | changes)
    return world


def having(make: Callable[[], Any], name: str) -> Callable[[Any], None]:
    """Return what sets an attribute of a body, in a world of its own."""
    return lambda value: setattr(make(), name, value)


def a_soft_body() -> softbody.SoftBody:
    """Return a soft body in a world of its own."""
    return soft().soft_bodies[0]


def a_box(mass: float | None = 1.0) -> softbody.Box:
    """Return a box in a world of its own; of no mass it is static."""
    return rigid(mass=mass).boxes[0]


def a_joint() -> softbody.Joint:
    """Return a joint in a world of its own."""
    return joined().joints[0]


def told(function: Callable[..., Any], name: str, *before: Any, **others: Any) -> Callable[[Any], Any]:
    """Return what calls a function with one argument by name, and others."""
    return lambda value: function(*before, **others, **{name: value})


def _optional(limits: Limits) -> Limits:
    """Return limits of what may be None as well."""
    return Limits((None, *limits.taken), tuple(each for each in limits.refused if each is not None), limits.told)


def _refused(limits: Limits) -> Limits:
    """Return limits of which only what is refused is tried."""
    return Limits((), limits.refused, limits.told)


Case = tuple[str, Callable[[Any], Any], Limits]  # an argument as Python writes it, what takes a value, its limits


def of_bodies() -> Iterator[Case]:
    """Yield the arguments of bodies, joints, the ground and the liquid."""
    skin = Limits((True, False, 0.0, 1e-6), (-LEAST, 1.0, *NO_NUMBERS))
    of_edges = (0.0, -1.0, NAN, INF, "two", 1j, np.ones(119), np.ones(121))
    for name, limits in {
        "mass": POSITIVE,
        "stiffness": Limits((0.0, LEAST, 1.0, np.ones(120)), (-LEAST, *of_edges[2:])),
        "gas": NOT_NEGATIVE,
        "position": VECTOR,
        "velocity": VECTOR,
        "rest_length": Limits((None, LEAST, 1.0, np.ones(120)), of_edges),
        "tear_at": Limits((0.0, np.nextafter(1.0, 2.0), 2, np.full(120, 1.5)), (LEAST, 1.0, *of_edges[1:])),
        "damping": _optional(NOT_NEGATIVE)._replace(told=()),
        "fixed": Limits(((), (0,), (41,), [0, 0], range(41)), ((42,), (-1,), (0.0,), "ab", range(42), ((0,), (1,)))),
        "drag": NOT_NEGATIVE,
        "restitution": UP_TO_ONE,
        "friction": NOT_NEGATIVE,
        "deflated_below": UP_TO_ONE,
        "liquid_density": NOT_NEGATIVE,
        "sound_speed": NOT_NEGATIVE,
        "liquid_drag": NOT_NEGATIVE,
        "leak": NOT_NEGATIVE,
        "self_contact": skin,
    }.items():
        yield f"add_soft_body({name}=…)", told(soft, name), _optional(limits) if limits is skin else limits
        if name not in ("mass", "stiffness", "position", "rest_length", "tear_at", "damping"):
            yield f"soft_body.{name} = …", having(a_soft_body, name), limits
        if name in ("stiffness", "rest_length", "tear_at"):
            call = told(lambda **given: a_soft_body().set_springs(**given), name)
            yield f"soft_body.set_springs({name}=…)", call, limits
    rows = np.ones((42, 3))
    arrays = Limits((rows, rows.tolist()), (rows[1:], np.where(rows.cumsum(0) == 2.0, NAN, rows), "abc", 1j * rows))
    for name in ("positions", "velocities", "external_force"):
        yield f"soft_body.{name} = …", having(a_soft_body, name), arrays
    yield "soft_body.angular_velocity = …", having(a_soft_body, "angular_velocity"), VECTOR
    for kind, thing in (("soft_body", a_soft_body), ("box", a_box)):
        yield from _pushes(kind, thing)
    yield "add_soft_body(pressure=…)", told(soft, "pressure", gas=None), NOT_NEGATIVE
    for name in ("damping", "pressure"):
        yield f"soft_body.{name} = …", having(a_soft_body, name), NOT_NEGATIVE
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
            yield f"box.{name} = …", having(a_box, name), limits
    # (1 / 1e-308 is finite, and 1 / 5e-324 is not; a needle turns about its axis more easily than it moves.)
    yield "add_soft_body(mass=…), hardly any", told(soft, "mass"), Limits((1e-300,), (LEAST,))
    yield "add_box(mass=…), hardly any", told(rigid, "mass"), Limits((1e-300,), (LEAST,))
    yield "add_box(mass=…), of a needle", told(rigid, "mass", size=(1e50, 1e-50, 1e-50)), Limits((1e-200,), (1e-210,))
    for name, limits in {"position": VECTOR, "orientation": TURN}.items():
        way = _optional(limits)
        yield f"box.move_to({name}=…)", told(lambda **given: a_box(None).move_to(seconds=1.0, **given), name), way
    yield "box.move_to(seconds=…)", lambda value: a_box(None).move_to((1.0, 0.0, 0.0), seconds=value), POSITIVE
    for name in ("stiffness", "damping", "rest_length"):
        yield f"add_joint({name}=…)", told(joined, name), NOT_NEGATIVE
        yield f"joint.{name} = …", having(a_joint, name), NOT_NEGATIVE
    number = Limits((0, 41, np.int64(1)), (-1, 42, 1.0, np.inf))
    yield "add_joint(a=…), a particle", _tie, number
    yield "joint.target = …", having(a_joint, "target"), VECTOR
    for name, limits in {"height": Limits((0.0, -1.0, 1e6), NO_NUMBERS), "restitution": UP_TO_ONE}.items():
        yield f"add_ground({name}=…)", told(World().add_ground, name), limits
        yield f"ground.{name} = …", having(World().add_ground, name), limits
    liquid = {"density": POSITIVE, "surface_height": Limits((0.0, -1.0, 1e6), NO_NUMBERS), "drag": NOT_NEGATIVE}
    for name, limits in {**liquid, "velocity": VECTOR}.items():
        yield f"add_liquid({name}=…)", told(World().add_liquid, name), limits
        yield f"liquid.{name} = …", having(World().add_liquid, name), limits
    for name, limits in {
        "stiffness": _optional(NOT_NEGATIVE),
        "damping": _optional(NOT_NEGATIVE),
        "weights": Limits(("mean-value", "tetrahedron"), ("mean", 1, None)),
        "body": Limits((), (None, 0, "ball", NAN)),
    }.items():
        yield f"suspend({name}=…)", told(_hung, name), limits
    wrong = (None, "ball", NAN, np.ones((2, 2)), (0.0, 0.0, INF), (0.0, 0.0, 9.0))
    points = Limits(((0.0, 0.1, 0.2), np.zeros((3, 3))), wrong)
    yield "suspend(what=…), points", told(_hung, "what", stiffness=None), points
    yield (
        "add_box(inside=…)",
        lambda value: _hung().add_box((0.1, 0.1, 0.1), 1.0, inside=value),
        Limits((None,), ("ball", 0, NAN)),
    )
    yield "box.inside = …", having(a_box, "inside"), Limits((None,), ("ball", 0, NAN, False))
    yield "add_ground(friction=…)", told(World().add_ground, "friction"), NOT_NEGATIVE
    yield "ground.friction = …", having(World().add_ground, "friction"), NOT_NEGATIVE


def _hung(**changes: Any) -> World:
    """Return a world of a soft body and a box that hangs in it, told something else than usual."""
    world = soft()
    box = world.add_box((0.1, 0.1, 0.1), 1.0)
    usual: dict[str, Any] = {"what": box, "body": world.soft_bodies[0], "stiffness": 1.0}
    world.suspend(**usual | changes)
    return world


def _tie(particle: Any) -> None:
    world = soft()
    world.add_joint((world.soft_bodies[0], particle), (2.0, 0.0, 0.0), 1.0)


def of_worlds(folder: Path) -> Iterator[Case]:
    """Yield the arguments of worlds, of their steps and of what is kept of them."""
    many = whole(1, 10_000_000, (10_000_000,))
    ceiling = Limits((0.0, 1.0, INF), (-LEAST, NAN, -INF, "two", 1j, None))
    for name, limits in {
        "gravity": VECTOR,
        "precision": Limits(("double", "single"), ("half", 64, None)),
        "threads": whole(1, taken=(2,)),
        "integrator": Limits(("symplectic_euler", "rk4", "rk4_velocity"), ("euler", 1, None, "RK4")),
        "substeps": many,
        "iterations": many,
        "edge_contacts": YES_OR_NO,
        "split_steps": YES_OR_NO,
        "frictionless": YES_OR_NO,
        "self_contact": YES_OR_NO,
        "gyroscopic": YES_OR_NO,
        "speed_ceiling": ceiling,
        "angular_speed_ceiling": ceiling,
        "angular_speed_floor": ceiling,
        "sleep_speed": ceiling,
        "sleep_after": ceiling,
        "axes": Limits(("complete", "paper"), ("all", None)),
        "contact": Limits(("manifold", "single"), ("face", None)),
        "soft_contact": Limits(("together", "single"), ("alone", None)),
        "pairs": Limits(("grid", "exhaustive"), ("tree", None)),
    }.items():
        yield f"World({name}=…)", told(World, name), limits
    yield "world.integrator = …", partial(setattr, World(), "integrator"), Limits(("rk4",), ("euler", 1, None))
    yield "world.substeps = …", partial(setattr, World(), "substeps"), many
    yield "world.threads = …", partial(setattr, World(), "threads"), whole(1, taken=(2,))
    yield "world.time = …", partial(setattr, World(), "time"), NOT_NEGATIVE
    yield "world.gravity = …", partial(setattr, World(), "gravity"), VECTOR
    seconds, step = Limits((0.0, LEAST, 1e-3), NOT_NEGATIVE.refused), Limits((1e-3, LEAST), POSITIVE.refused)
    longer, too_many = _optional(Limits((1e-3, 1.0), POSITIVE.refused)), Limits((), (1.5 * 2.0**62,))
    yield "world.step(time_step=…)", rigid().step, step
    for what, make in {"a joint": joined, "a soft body": soft}.items():
        longest = make().stable_time_step()
        limits = Limits((longest,), (float(np.nextafter(longest, INF)),))
        call = told(lambda make, time_step: make().step(time_step), "time_step", make)
        yield f"world.step(time_step=…), of {what}", call, limits
    yield "world.step(steps=…)", lambda value: rigid().step(1e-3, value), whole(0, taken=(3,))
    yield "world.step(substeps=…)", lambda value: rigid().step(1e-3, substeps=value), _optional(whole(1, taken=(3,)))
    yield "world.step(allow_unstable=…)", lambda value: rigid().step(1e-3, allow_unstable=value), YES_OR_NO
    yield "world.run(seconds=…)", lambda value: rigid().run(value, 1e-3), seconds
    yield "world.run(time_step=…)", lambda value: rigid().run(0.0, value), longer
    yield "world.run(seconds=…), of steps", lambda value: rigid().run(value, 1.0), too_many
    yield "world.run(seconds=…), by itself", lambda value: rigid().run(value), seconds
    yield (
        "world.run(substeps=…)",
        lambda value: rigid().run(1e-3, 1e-3, substeps=value),
        _optional(whole(1, taken=(3,))),
    )
    yield "world.run(allow_unstable=…)", lambda value: rigid().run(1e-3, 1e-3, allow_unstable=value), YES_OR_NO
    yield "world.step_frame(seconds=…)", lambda value: rigid().step_frame(value), seconds
    yield "world.step_frame(time_step=…)", lambda value: rigid().step_frame(1e-3, time_step=value), longer
    yield "world.step_frame_contacts(seconds=…)", lambda value: rigid().step_frame_contacts(value), POSITIVE
    yield "world.frames(seconds=…)", lambda value: list(rigid().frames(seconds=value)), seconds
    yield "world.frames(time_step=…)", lambda value: list(rigid().frames(1e-3, time_step=value)), longer
    yield "world.frames(per_second=…)", lambda value: list(rigid().frames(0.0, per_second=value)), POSITIVE
    yield "world.equilibrium(tolerance=…)", lambda value: rigid().equilibrium(tolerance=value), POSITIVE
    yield "world.equilibrium(steps=…)", lambda value: rigid().equilibrium(steps=value), whole(1)
    kept, written = folder / "kept.npz", folder / "written"
    rigid().save(kept)
    yield "World.load(most_bytes=…)", lambda value: World.load(kept, value), Limits((2**40,), whole(1).refused)
    packed, ball = folder / "packed.npz", soft(mesh=softbody.icosphere(3))
    np.savez_compressed(packed, **ball.snapshot())  # type: ignore[arg-type]
    bytes_ = sum(array.nbytes for array in ball.snapshot().values())  # more than the file has
    yield "World.load(most_bytes=…), packed", lambda value: World.load(packed, value), Limits((bytes_,), (bytes_ - 1,))
    film = folder / "film"
    with TrajectoryWriter(rigid(), film, 60.0) as writer:
        writer.run(0.05, 1e-2)
    trajectory, every = Trajectory(film), _refused(whole(1))
    yield "Trajectory(most_bytes=…)", lambda value: Trajectory(film, value), Limits((2**40,), whole(1).refused)
    two = soft()
    two.add_soft_body(BALL, 1.0, 100.0, 10.0, (5.0, 0.0, 0.0))
    with TrajectoryWriter(two, folder / "two", 60.0) as writer:
        writer.frame()
    yield "trajectory.particles(body=…)", Trajectory(folder / "two").particles, whole(0, 1, (1,))
    yield "trajectory.export(every=…)", lambda value: trajectory.export(folder / "a.npz", every=value), every

    def record(value: Any, name: str, **others: Any) -> None:
        TrajectoryWriter(rigid(), written / str(len(list(folder.iterdir()))), **{name: value}, **others).close()

    yield "TrajectoryWriter(frames_per_second=…)", partial(record, name="frames_per_second"), _refused(POSITIVE)
    yield "TrajectoryWriter(velocities=…)", partial(record, name="velocities"), _refused(YES_OR_NO)
    yield "TrajectoryWriter(resume=…)", partial(record, name="resume"), _refused(YES_OR_NO)


def of_meshes() -> Iterator[Case]:
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
    arrays, nothing = (BALL.vertices, BALL.triangles), np.zeros((0, 3))
    corners, apart = arrays[0][arrays[1]], Limits((0.0, 1e-9), NOT_NEGATIVE.refused)
    yield "Mesh.from_soup(tolerance=…)", told(Mesh.from_soup, "tolerance", corners), apart
    # As other libraries have it, and of triangles that do not share their vertices.
    whole_ball = SimpleNamespace(vertices=arrays[0], faces=arrays[1])
    soup = SimpleNamespace(vertices=corners.reshape(-1, 3), faces=np.arange(corners.size // 3).reshape(-1, 3))
    merged = Limits((True,), (False,))
    yield "Mesh.from_trimesh(tolerance=…)", told(Mesh.from_trimesh, "tolerance", whole_ball), _refused(NOT_NEGATIVE)
    yield "Mesh.from_trimesh(merge=…)", told(Mesh.from_trimesh, "merge", whole_ball), YES_OR_NO
    yield "Mesh.from_trimesh(merge=…), of a soup", told(Mesh.from_trimesh, "merge", soup), merged
    yield "Mesh(vertices=…), of nothing", lambda value: Mesh(value, nothing.astype(int)), Limits((), (nothing,))
    density = Limits((0.25, 64.0, LEAST), (np.nextafter(64.0, 65.0), *POSITIVE.refused))
    yield "MeshQuery(columns_per_triangle=…)", partial(geometry.MeshQuery, *arrays), density
    for ask in (geometry.points_in_mesh, geometry.closest_on_mesh):
        of_mesh = told(ask, "points", vertices=arrays[0], triangles=arrays[1])
        yield f"{ask.__name__}(threads=…)", told(ask, "threads", np.zeros((1, 3)), *arrays), whole(1)
        yield f"{ask.__name__}(points=…)", of_mesh, _rows(arrays[0])
    of_vertices, of_triangles = _limits_of_arrays(*arrays)
    for make in (Mesh, geometry.MeshQuery):
        yield f"{make.__name__}(vertices=…)", told(make, "vertices", triangles=arrays[1]), of_vertices
        yield f"{make.__name__}(triangles=…)", told(make, "triangles", arrays[0]), of_triangles


def _rows(rows: np.ndarray) -> Limits:
    """Return the limits of rows of three numbers, as many as there may be, of which none is infinite or none at all."""
    first, last = rows.copy(), rows.copy()
    first[0, 2], last[-1, 0] = NAN, INF
    refused = first, last, rows[0], rows[:, :2], "abc", 1j * rows, None
    return Limits((rows, rows.tolist(), rows.astype(np.float32)), refused)


def _limits_of_arrays(vertices: np.ndarray, triangles: np.ndarray) -> tuple[Limits, Limits]:
    """Return the limits of the vertices and of the triangles of a mesh."""
    below, beyond, count = triangles.copy(), triangles.copy(), len(vertices)
    below[-1, 1], beyond[0, 0] = -1, count
    bad = below, beyond, triangles + 0.5, triangles[0], triangles[:, :2], triangles[:0], "abc", 1j * triangles
    return _rows(vertices), Limits((triangles, triangles.tolist(), triangles.astype(np.uint32)), bad)


def is_refused_by_name(call: Callable[[Any], Any], value: Any, name: str, told: tuple[str, ...]) -> bool:
    """Tell whether a call refuses a value, and says briefly which argument it was; of a number also the limits."""
    error = error_of(Exception, call, value)
    text = str(error)
    is_named = name in text or ROWS.get(name, name) in text
    is_told = all(limit in text for limit in told) or not isinstance(value, float)
    return isinstance(error, (ParameterError, MeshError)) and is_named and is_told and len(text) <= MOST_SAID


def _pushes(kind: str, thing: Callable[[], Any]) -> Iterator[Case]:
    """Yield how a body is pushed, struck and turned."""
    along, place = (1.0, 0.0, 0.0), _optional(VECTOR)
    yield f"{kind}.apply_force(force=…)", lambda value: thing().apply_force(force=value), VECTOR
    yield f"{kind}.apply_force(point=…)", lambda value: thing().apply_force(along, point=value), place
    yield f"{kind}.apply_impulse(impulse=…)", lambda value: thing().apply_impulse(impulse=value), VECTOR
    yield f"{kind}.apply_impulse(point=…)", lambda value: thing().apply_impulse(along, point=value), place
    yield f"{kind}.apply_torque(torque=…)", lambda value: thing().apply_torque(torque=value), VECTOR


CALLS: tuple[Callable[..., Any], ...] = (
    World,
    World.add_soft_body,
    World.add_box,
    World.add_joint,
    World.add_ground,
    World.add_liquid,
    World.step,
    World.run,
)
CALLS += World.step_frame, World.frames, World.equilibrium, softbody.Box.move_to, softbody.Box.apply_force
CALLS += softbody.SoftBody.apply_impulse, softbody.SoftBody.apply_torque, World.step_frame_contacts
ELSEWHERE = {"mesh", "a", "b", "name"}  # arguments that other claims are about


def _all_there_are() -> Iterator[str]:
    """Yield how a case of each argument, and of each attribute that may be assigned, begins or ends."""
    kinds = {"world": World, "soft_body": softbody.SoftBody, "box": softbody.Box, "joint": softbody.Joint}
    for name, kind in {**kinds, "ground": softbody.Ground, "liquid": softbody.Liquid}.items():
        yield from (f"{name}.{each} = …" for each in settable(kind) - ELSEWHERE)
    for call in CALLS:
        taken = inspect.signature(call).parameters.values()
        names = {each.name for each in taken if each.kind is not each.VAR_KEYWORD} - {"self", *ELSEWHERE}
        yield from (f"{call.__name__}({each}=…)" for each in names)
    for field in known_properties():
        of, _, name = field.partition("_")
        yield f"add_{'soft_body' if of == 'soft' else of}({name}=…)"


@check(
    section="2",
    piece="softbody.errors, softbody.Mesh, softbody.World, softbody.SoftBody, softbody.Box, softbody.Joint,"
    " softbody.Ground, softbody.Liquid, softbody.Trajectory, softbody.TrajectoryWriter",
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
    """Every argument is taken up to its limit and refused beyond it.

    Every number, vector, turn, choice and yes or no of the public API, up to the very limit that its documentation
    names. From the next number on it is refused by an error that names it: NaN, infinite, of another kind, one digit
    too many.
    """
    answers = Answers()
    with tempfile.TemporaryDirectory() as folder:
        cases = [*of_bodies(), *of_worlds(Path(folder)), *of_meshes()]
        for each in _all_there_are():
            answers.add(any(what.endswith(each) for what, _, _ in cases), True, kind=f"{each}: asked at all")
        for what, call, limits in cases:
            name = what.partition("(")[2].partition("=")[0] or what.partition(".")[2].partition(" ")[0]
            for value in limits.taken:
                answers.add(error_of(Exception, call, value) is None, True, kind=what)
            for value in limits.refused:
                answers.add(is_refused_by_name(call, value, name, limits.told), True, kind=what)
    return answers.comparison()
