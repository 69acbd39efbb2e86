"""Calls of the public API with arguments of all kinds do as they say or end in an error of the core's own."""

from __future__ import annotations

import copy
import pickle
import warnings
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np

import softbody
from softbody import Box, Mesh, SoftBody, SoftbodyError, World
from softbody.geometry import MeshQuery

TRIES = 250  # calls an attempt
GOAL = 200_000
MOST = 12  # bodies of a world, and 300 particles: then a new world

nan, inf = float("nan"), float("inf")
NUMBERS: list[Any] = [
    0, 1, 2, 3, 0.0, -0.0, 1.0, 0.5, 1e-3, -1.0, 1e-12, 1e12, 1e-160, 1e160, 1e-310, 1e308, 5e-324, nan, inf, -inf,
    10**18, 10**30, 10**400, -(10**400), 2**63, 2**64, True, False, np.float32(1.1), np.float16(0.3), np.float64(2.0),
    np.longdouble("1.5"), np.longdouble("1e4000"), np.int8(3), np.uint8(2), np.uint64(2), np.uint64(2**63),
    np.bool_(True), Fraction(1, 3), Decimal("0.1"), Decimal("NaN"), Decimal("sNaN"), Decimal("1e999999"), 1j, 1 + 0j,
]  # fmt: skip
OTHERS: list[Any] = [
    None, "1", "", "ground", b"1", bytearray(b"1"), [], (), {}, set(), [1], [1, 2], [[1, 2], [3]], object(), len,
    np.array(1.0), np.array([1.0]), np.array([]), np.zeros((2, 2)), np.array("1"), np.array(None), np.zeros(3, complex),
    np.array([1, 2, 3], object), np.array(["1", "2", "3"]), np.datetime64("2000"), np.timedelta64(1, "s"), ...,
    range(3), memoryview(b"123"), np.ma.masked, np.zeros(3, [("x", float)]), iter([1.0, 2.0, 3.0]), NotImplemented,
]  # fmt: skip
USUAL = [0.1, 0.5, 1.0, 2.0, 10.0]
MESHES = [softbody.tetrahedron(0.5), softbody.octahedron(0.5), softbody.icosphere(1, 0.5)]


def attempt(seed: int) -> str | None:
    """Make some calls on one world after the other."""
    caller = Caller(np.random.default_rng(seed))
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        for _ in range(TRIES):
            said = caller.call()
            if said:
                return said
    return None


class Caller:
    """Who calls anything with anything."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.world = World()
        self.odd = 0.3  # share of arguments that are not usual

    def one(self, choices: Any) -> Any:
        """Return one of the choices."""
        return choices[int(self.rng.integers(len(choices)))]

    def number(self) -> Any:
        """Return what may be meant as a number."""
        if self.rng.random() >= self.odd:
            return self.one(USUAL)
        return self.one(NUMBERS) if self.rng.random() < 0.8 else self.one(OTHERS)

    def whole(self) -> Any:
        """Return what may be meant as a small whole number."""
        if self.rng.random() >= self.odd:
            return int(self.rng.integers(1, 4))
        return self.one([n for n in NUMBERS if not (isinstance(n, (int, np.integer)) and 3 < n < 2**62)] + OTHERS)

    def vector(self, length: int = 3) -> Any:
        """Return what may be meant as a vector."""
        draw = self.rng.random()
        if draw < 0.7:
            return self.rng.normal(size=length) * self.one([1.0, 1.0, 3.0])
        if draw < 0.9:
            return [self.number() for _ in range(length)]
        return self.one(OTHERS)

    def yes(self) -> Any:
        """Return what may be meant as yes or no."""
        return self.one([True, False, np.bool_(True)]) if self.rng.random() < 0.9 else self.one(OTHERS)

    def mesh(self) -> Any:
        """Return what may be meant as a mesh."""
        return self.one(MESHES) if self.rng.random() < 0.95 else self.one(OTHERS)

    def soft(self) -> SoftBody:
        """Return a soft body that is there, or none."""
        return SoftBody(self.world, int(self.rng.integers(max(1, self.world.model.soft_count))))

    def box(self) -> Box:
        """Return a box that is there, or none."""
        return Box(self.world, int(self.rng.integers(max(1, self.world.model.box_count))))

    def call(self) -> str | None:
        """Make one call; return what is wrong with what came of it."""
        model = self.world.model
        if self.rng.random() < 0.02 or model.soft_count + model.box_count > MOST or len(self.world.state[0]) > 300:
            self.world = World()
        calls: list[Callable[[], str]] = [getattr(self, name) for name in dir(self) if name.startswith("try_")]
        tried = self.one(calls)
        try:
            tried()
        except SoftbodyError:
            pass
        except RecursionError:
            raise
        except Exception as error:
            return f"{tried.__name__[4:]}: {type(error).__name__}: {error}"
        for name, rows in self.world.state._asdict().items():
            if not np.isfinite(rows).all():
                return f"{tried.__name__[4:]}: {name} is not finite"
        return None

    def try_world(self) -> None:
        choices = {
            "integrator": self.one(["rk4", "rk4_velocity", "symplectic_euler", *OTHERS[:5]]),
            "axes": self.one(["complete", "paper", *OTHERS[:5]]),
            "contact": self.one(["manifold", "single", *OTHERS[:5]]),
            "soft_contact": self.one(["together", "single", *OTHERS[:5]]),
            "pairs": self.one(["grid", "exhaustive", *OTHERS[:5]]),
            "iterations": self.whole(),
            "speed_ceiling": self.number(),
            "angular_speed_ceiling": self.number(),
            "angular_speed_floor": self.number(),
            "edge_contacts": self.yes(),
            "split_steps": self.yes(),
            "gyroscopic": self.yes(),
            "frictionless": self.yes(),
            "self_contact": self.yes(),
            "substeps": self.one([1, 2, 0, -1, 10**400, None, 1.0, "1", np.uint64(2)]),
            "threads": self.one([1, 0, -1, 10**6, 10**400, None, 1.0, "1", np.uint64(1)]),
            "colour": 1,
        }
        some = {name: value for name, value in choices.items() if self.rng.random() < 0.15}
        self.world = self.one([World, World.paper])(gravity=self.vector(), **some)

    def try_add_soft_body(self) -> None:
        some = {"restitution", "friction", "damping", "drag", "deflated_below", "leak", "colour"}
        properties = {name: self.number() for name in sorted(some) if self.rng.random() < 0.1}
        if self.rng.random() < 0.1:
            properties["fixed"] = self.one([[0], [0, 1], [99], [-1], 0, (), [0.5], *OTHERS])
        if self.rng.random() < 0.1:
            properties["rest_length"] = self.one([self.number(), np.ones(6), np.ones(12), *OTHERS])
        if self.rng.random() < 0.1:
            properties["tear_at"] = self.tear_at()
        stiffness = self.one([self.number(), self.number(), 100.0, np.ones(6), np.ones(7)])
        self.world.add_soft_body(
            self.mesh(), self.number(), stiffness, self.number(), self.vector(), self.vector(), **properties
        )

    def tear_at(self) -> Any:
        """Return what may be meant as limits of springs."""
        return self.one([None, 0.0, 1.001, 1.2, self.number(), np.full(6, 1.1), np.full(12, 1.1), *OTHERS])

    def try_add_box(self) -> None:
        size = np.abs(self.rng.normal(size=3)) + 0.1 if self.rng.random() < 0.8 else self.vector()
        turn = self.one([(1, 0, 0, 0), (0.6, 0, 0, 0.8), self.vector(4)])
        mass = self.one([None, self.number(), self.number()])
        properties = {name: self.number() for name in ("restitution", "friction", "mass_") if self.rng.random() < 0.1}
        self.world.add_box(size, mass, self.vector(), turn, self.vector(), self.vector(), **properties)

    def end(self) -> Any:
        """Return what may be meant as an end of a joint."""
        body = self.soft() if self.rng.random() < 0.5 and self.world.model.soft_count else self.box()
        where = self.whole() if isinstance(body, SoftBody) and self.rng.random() < 0.5 else self.vector()
        return (body, where) if self.rng.random() < 0.7 else self.one([self.vector(), *OTHERS])

    def try_add_joint(self) -> None:
        a = self.vector() if self.world.model.soft_count + self.world.model.box_count == 0 else self.end()
        joint = self.world.add_joint(a, self.end(), *(self.number() for _ in range(1 + int(self.rng.integers(3)))))
        setattr(joint, self.one(["stiffness", "damping", "rest_length"]), self.number())
        joint.target = self.vector()

    def try_move_to(self) -> None:
        turn = self.one([None, (0.6, 0, 0, 0.8), self.vector(4)])
        self.box().move_to(self.one([None, self.vector()]), turn, seconds=self.number())

    def try_remove(self) -> None:
        self.world.remove(self.one([*self.world.soft_bodies, *self.world.boxes, *self.world.joints, *OTHERS]))

    def try_add_ground(self) -> None:
        self.world.add_ground(*(self.number() for _ in range(int(self.rng.integers(4)))))

    def try_step(self) -> None:
        h = self.one([1e-3, 1e-4, 0.01, self.number()])
        self.world.step(h, self.whole(), substeps=self.whole(), allow_unstable=self.yes())

    def try_run(self) -> None:
        h = self.one([1e-3, 1e-4, 0.01])
        self.world.run(self.one([h, 3 * h, 0.0, nan, -1.0, 1e308, "1"]), self.one([h, nan, 0.0, 1e-320]))

    def try_equilibrium(self) -> None:
        self.world.equilibrium(self.one([1e-3, self.number()]), self.whole())

    def try_snapshot(self) -> None:
        self.world.restore(self.world.snapshot())

    def try_pickle(self) -> None:
        self.world = pickle.loads(pickle.dumps(self.world))

    def try_copy(self) -> None:
        self.world = copy.deepcopy(self.world)

    def try_asking(self) -> None:
        world = self.world
        self.one(
            [world.energy, world.linear_momentum, world.angular_momentum, world.state_hash, world.stable_time_step]
        )()

    def try_integrator(self) -> None:
        self.world.integrator = self.one(["rk4", "rk4_velocity", "symplectic_euler", *OTHERS])

    def try_substeps(self) -> None:
        self.world.substeps = self.one([1, 2, 3, 0, -1, 10**400, None, 1.0, "1", np.uint64(1)])

    def try_threads(self) -> None:
        self.world.threads = self.one([1, 0, -1, 10**6, 10**400, None, 1.0, "1", np.uint64(1)])

    def try_soft(self) -> None:
        if not self.world.model.soft_count:
            return
        body = self.soft()
        kind = int(self.rng.integers(5))
        if kind == 0:
            body.gas = self.number()
        elif kind == 1:
            body.external_force = self.vector()
        elif kind == 2:
            body.set_springs(*(self.one([None, self.number(), np.ones(6)]) for _ in range(2)), self.tear_at())
        elif kind == 3:
            self.written(self.one([body.positions, body.velocities]))
        else:
            self.one([lambda: body.volume, lambda: body.pressure, lambda: body.centre, lambda: body.triangles])()

    def try_box(self) -> None:
        if not self.world.model.box_count:
            return
        box = self.box()
        kind = int(self.rng.integers(4))
        if kind == 0:
            box.apply_force(self.vector(), self.one([None, self.vector()]))
        elif kind == 1:
            box.apply_torque(self.vector())
        elif kind == 2:
            box.clear_forces()
        else:
            self.written(self.one([box.position, box.orientation, box.velocity, box.angular_velocity]))

    def written(self, view: np.ndarray) -> None:
        """Write numbers to a view, see whether a step of them is refused or done, and put back what was there."""
        # (No snapshot: of a world of numbers too large for one, none is taken back.)
        before, numbers = self.world.state.copy(), [n for n in NUMBERS if isinstance(n, (float, np.floating))]
        view[...] = self.one(numbers) if self.rng.random() < 0.5 else view * self.one(numbers)
        try:
            self.world.step(1e-4, 2, allow_unstable=bool(self.rng.integers(2)))
        finally:
            for rows, were in zip(self.world.state, before, strict=True):
                rows[...] = were

    def try_shapes(self) -> None:
        make = self.one([softbody.tetrahedron, softbody.octahedron, softbody.icosahedron])
        make(self.number())
        softbody.torus(self.number(), self.number(), self.whole(), self.whole())
        softbody.icosphere(self.one([0, 1, np.uint8(1), -1, 11, 10**400, 1.0, *OTHERS]), self.number())
        softbody.box(self.vector(), self.one([1, 2, np.uint64(2), 10**6, 0, None, *OTHERS]))

    def try_mesh(self) -> None:
        mesh = self.one(MESHES)
        vertices, triangles = mesh.vertices.copy(), mesh.triangles.copy()
        rows: Any = self.one([vertices, triangles])
        rows[int(self.rng.integers(len(rows))), int(self.rng.integers(3))] = self.one([0, 1, -1, 5, 10**9, 2])
        Mesh(self.one([vertices, vertices.tolist(), *OTHERS]), self.one([triangles, triangles.astype(float), *OTHERS]))
        mesh.moved(self.vector())
        mesh.scaled(self.number())

    def try_soup(self) -> None:
        mesh = self.one(MESHES)
        corners = mesh.vertices[mesh.triangles]
        listed: list[Any] = corners.tolist()
        listed[int(self.rng.integers(len(listed)))] = self.vector()
        soup: Any = self.one([corners, corners.reshape(-1, 3), corners.tolist(), listed, self.one(OTHERS)])
        Mesh.from_soup(soup, self.one([None, None, np.arange(12).reshape(4, 3), *OTHERS]), self.number()).check()

    def try_trimesh(self) -> None:
        mesh = self.one(MESHES)
        faces: Any = self.one([mesh.triangles, *OTHERS])
        given: Any = self.one([SimpleNamespace(vertices=mesh.vertices, faces=faces), *OTHERS])
        Mesh.from_trimesh(given, merge=self.yes(), tolerance=self.one([0.0, self.number()]))

    def try_query(self) -> None:
        mesh = self.one(MESHES)
        arrays = self.one([(mesh.vertices, mesh.triangles), (mesh, None), (mesh.vertices, mesh.triangles[1:])])
        query = MeshQuery(*self.one([arrays, arrays, (self.one(OTHERS), None)]), self.one([0.25, self.number()]))
        points = self.one([self.rng.normal(size=(4, 3)), [[0.0, 0.0, nan]], *OTHERS])
        self.one([query.contains, query.closest, query.signed_distance])(
            points, self.one([1, 2, 0, -1, 10**6, 10**400, None, 1.5, "1"])
        )
        query.move(self.one([mesh.vertices, *OTHERS]))

    def try_scene(self) -> None:
        scene = self.one(["box_stack", "box_pile", "torus_stack", "ball_drop", "boxes_on_torus", "rolling_torus"])
        given: Any = self.one(OTHERS + [0, -1, nan, 10**400, 1.5])
        getattr(softbody.scenes, scene).build(
            **self.one([{"world": self.one([3, "1", []])}, {}]) or _wrong(scene, given)
        )


def _wrong(scene: str, given: Any) -> dict[str, Any]:
    """Return an argument of a scene that it can hardly take."""
    name = {"torus_stack": "bodies", "ball_drop": "height", "rolling_torus": "tilt"}.get(scene, "boxes")
    return {name: given}
