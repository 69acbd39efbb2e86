"""A world to fill with bodies, step, and look at: the host side of the core."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from math import isfinite
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numpy.typing import ArrayLike

from softbody.collision.contacts import grown, new_contacts
from softbody.collision.skins import Skins, build_skins
from softbody.dynamics.energy import angular_momentum, linear_momentum, total_energy
from softbody.dynamics.equilibrium import relax
from softbody.dynamics.integrators import INTEGRATORS, STABILITY_LIMIT
from softbody.dynamics.motion import COLLAPSED, Scratch, scratch_for
from softbody.dynamics.pressure import gas_pressure
from softbody.dynamics.rings import append_rings, build_rings, in_precision, no_rings, with_springs
from softbody.dynamics.soft import body_volume
from softbody.dynamics.stability import highest_damping, highest_frequency, longest_stable_step
from softbody.errors import OverlapWarning, ParameterError, SimulationError
from softbody.geometry.box import box_inertia
from softbody.geometry.polyhedron import surface_area
from softbody.mesh import Mesh
from softbody.parameters import check_range, check_whole, pins_of, rest_length_of, stiffness_of, unit_quaternion, vector
from softbody.snapshot import Snapshot, digest, entry, named_arrays, read, rebuilt, write
from softbody.state import Model, Rings, Rules, State, appended
from softbody.step import OVERFLOW, run, run_soft_bodies

AXES = ("complete", "paper")
CONTACTS = ("manifold", "single")
PAIRS = ("grid", "exhaustive")
PRECISIONS: dict[str, type[np.floating[Any]]] = {"double": np.float64, "single": np.float32}

DEEP = 0.1  # of the thickness of the thinner of two bodies, from which an overlap at the start is worth a warning

# What the paper chose, as arguments of a World. It gives no numbers for its limits (§6). These: in a frame of 1/60 s a
# box goes no farther than 1/6 m, a third of a small box, and turns by no more than 10°; and one that would take a
# second for 10° lies still.
PAPER: dict[str, Any] = {
    "integrator": "rk4_velocity",
    "axes": "paper",
    "contact": "single",
    "pairs": "exhaustive",
    "edge_contacts": False,
    "split_steps": False,
    "frictionless": True,
    "speed_ceiling": 10.0,
    "angular_speed_ceiling": 10.0,
    "angular_speed_floor": 0.2,
}

STABLE_FOR = 100  # steps for which an estimate of the stable step is trusted; making one costs about a step
RELAX_ROUND = 500  # steps of relaxation between two looks at the forces left and at the stable step


class World:
    """Soft bodies, rigid boxes and a ground that move together.

    `gravity` (3,) [m/s²]. `integrator`: "rk4_velocity" (the paper's), "rk4" or "symplectic_euler". `axes` of the
    separating-axis test: "complete", or "paper" for face normals only. `contact` of boxes: "manifold", all points
    solved together in `iterations` sweeps a step, or "single", the paper's one impulse a pair, half-way between the
    two. `pairs` to test: those near in a "grid", or "exhaustive", as in the paper, with the same result.
    `edge_contacts`: edges hold edges, of boxes and of soft bodies, and not only particles and corners, as in the paper.
    `split_steps`: a step in which a soft body and another would jump through each other is taken in parts.

    More of the paper, off by default: `speed_ceiling` [m/s] and `angular_speed_ceiling` [rad/s]; a box on the ground
    that turns more slowly than `angular_speed_floor` [rad/s] stops turning and snaps to the nearest multiples of 90°;
    `frictionless`: whatever is added has friction 0. `World.paper()` has all of the paper.
    Beyond it: `gyroscopic` torque, so that a free box keeps its angular momentum.

    `precision` in which soft bodies move between contacts: "double", or "single", which is faster and rounds their
    positions to 6e-8 of the distance from the origin; everything else is double in both. `threads` that move soft
    bodies, with the same result to the last bit; they are compiled for when first used, and pay where there are many
    bodies or some 10 000 particles. Worlds that are stepped at the same time by threads of their own need 1.

    Bodies may be added at any time. Every input is checked before it is stored: ParameterError and MeshError name the
    culprit and the cure.
    """

    def __init__(
        self,
        gravity: ArrayLike = (0.0, 0.0, -9.81),
        integrator: str = "rk4_velocity",
        axes: str = "complete",
        contact: str = "manifold",
        pairs: str = "grid",
        iterations: int = 30,
        edge_contacts: bool = True,
        split_steps: bool = True,
        gyroscopic: bool = False,
        speed_ceiling: float = np.inf,
        angular_speed_ceiling: float = np.inf,
        angular_speed_floor: float = 0.0,
        frictionless: bool = False,
        precision: str = "double",
        threads: int = 1,
    ) -> None:
        if integrator not in list(INTEGRATORS):
            raise ParameterError(f"integrator is {integrator!r}; choose one of {', '.join(INTEGRATORS)}")
        for name, value, choice in (
            ("axes", axes, AXES),
            ("contact", contact, CONTACTS),
            ("pairs", pairs, PAIRS),
            ("precision", precision, tuple(PRECISIONS)),
        ):
            if value not in choice:
                raise ParameterError(f"{name} is {value!r}; choose one of {', '.join(choice)}")
        if not isinstance(iterations, (int, np.integer)) or not 1 <= iterations < 2**31:
            raise ParameterError(f"iterations is {iterations!r}; give a whole number ≥ 1")
        ceilings = {"speed_ceiling": speed_ceiling, "angular_speed_ceiling": angular_speed_ceiling}
        for name, ceiling in ceilings.items():
            if ceiling != np.inf:
                check_range(ceiling, name, least=0.0)
        check_range(angular_speed_floor, "angular_speed_floor", "rad/s", least=0.0)
        self.integrator = integrator
        self.precision = precision
        self.threads = threads
        self.rules = Rules(
            axes == "paper",
            contact == "single",
            pairs == "exhaustive",
            int(iterations),
            bool(edge_contacts),
            bool(split_steps),
            bool(gyroscopic),
            float(speed_ceiling),
            float(angular_speed_ceiling),
            float(angular_speed_floor),
            bool(frictionless),
        )
        self.contacts = new_contacts(0)
        self.model = _empty_model(vector(gravity, "gravity"))
        self.rings = in_precision(no_rings(), PRECISIONS[precision])
        self.state = State(*(np.empty((0, columns)) for columns in (3, 3, 3, 4, 3, 3)))
        self._kept_skins: Skins | None = None
        self.steps = 0
        self.time = 0.0
        self._stable_key: tuple[str, int, bytes] | None = None
        self._stable_at = 0
        self._kept: Scratch | None = None
        self._kept_for = 0, 0
        self._is_fresh = True  # bodies were added since the last step
        self._stable_step = np.inf

    @classmethod
    def paper(cls, **changes: Any) -> World:
        """Return a world that does as the paper does in all that it chose; `changes` are other arguments of a World."""
        return cls(**(PAPER | changes))

    def add_soft_body(
        self,
        mesh: Mesh,
        mass: float,
        stiffness: ArrayLike,
        gas: float,
        position: ArrayLike = (0.0, 0.0, 0.0),
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        restitution: float = 0.0,
        friction: float = 0.5,
        *,
        rest_length: ArrayLike | None = None,
        damping: float = 0.0,
        drag: float = 0.0,
        pinned: ArrayLike = (),
        deflated_below: float = 0.0,
    ) -> SoftBody:
        """Add a soft body whose springs are at rest in the shape of `mesh`, moved by `position` [m].

        `mass` [kg] of the whole body, shared equally by its particles. `stiffness` [N/m] of every spring, or
        (e,) in the order of `mesh.edges`. `gas` is nRT [J] ≥ 0; 0 for an empty skin. `restitution` 0 … 1 and
        `friction` ≥ 0 in contacts. `rest_length` [m] of every spring, or (e,), if not as in the mesh. `damping`
        [N s/m] of the springs, against the speed at which their ends part; `drag` [1/s], the rate at which all
        velocities fade. `pinned`: indices of vertices that stay in place. The body counts as collapsed, which
        ends a run with a SimulationError, at the fraction `deflated_below` of the mesh's volume (0: at none left).
        """
        if not isinstance(mesh, Mesh):
            raise ParameterError(f"mesh is a {type(mesh).__name__}; make a softbody.Mesh(vertices, triangles)")
        edges = mesh.edges
        check_range(mass, "mass", "kg", above=0.0)
        check_range(gas, "gas", "J", least=0.0)
        check_range(restitution, "restitution", least=0.0, most=1.0)
        check_range(friction, "friction", least=0.0)
        spring_stiffness = stiffness_of(stiffness, len(edges))
        points = np.ascontiguousarray(mesh.vertices + vector(position, "position"))
        lengths = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)
        edge = int(np.argmin(lengths))
        if not lengths[edge] > np.spacing(np.abs(points).max()):
            raise ParameterError(
                f"position is {position!r}: so far away that edge {edge} is lost in rounding; come closer"
            )
        speed = vector(velocity, "velocity")
        in_mesh = lengths
        if rest_length is not None:
            lengths = rest_length_of(rest_length, len(edges))
        check_range(damping, "damping", "N s/m", least=0.0)
        check_range(drag, "drag", "1/s", least=0.0)
        check_range(deflated_below, "deflated_below", least=0.0, most=1.0)
        pins = pins_of(pinned, len(points))
        speeds = np.tile(speed, (len(points), 1))
        speeds[pins] = 0.0
        inverse_masses = np.full(len(points), len(points) / mass)
        inverse_masses[pins] = 0.0

        model, first, count = self.model, len(self.state.position), len(points)
        self.model = model._replace(
            inverse_mass=appended(model.inverse_mass, inverse_masses),
            edges=appended(model.edges, edges + first),
            rest_length=appended(model.rest_length, lengths),
            stiffness=appended(model.stiffness, spring_stiffness),
            triangles=appended(model.triangles, mesh.triangles + first),
            particle_start=appended(model.particle_start, first + count),
            edge_start=appended(model.edge_start, len(model.edges) + len(edges)),
            triangle_start=appended(model.triangle_start, len(model.triangles) + len(mesh.triangles)),
            gas=appended(model.gas, float(gas)),
            thickness=appended(model.thickness, 2.0 * mesh.volume / surface_area(mesh.vertices, mesh.triangles)),
            edge_length=appended(model.edge_length, in_mesh.mean()),
            least_volume=appended(model.least_volume, deflated_below * mesh.volume),
            damping=appended(model.damping, float(damping)),
            drag=appended(model.drag, float(drag)),
            external_force=(
                appended(model.external_force, np.zeros((count, 3)))
                if len(model.external_force)
                else model.external_force
            ),
            soft_restitution=appended(model.soft_restitution, float(restitution)),
            soft_friction=appended(model.soft_friction, self._friction(friction)),
        )
        rings = build_rings(count, edges, mesh.triangles, lengths, spring_stiffness)
        self.rings = append_rings(self.rings, in_precision(rings, PRECISIONS[self.precision]), len(model.edges))
        self.state = self.state._replace(
            position=appended(self.state.position, points),
            velocity=appended(self.state.velocity, speeds),
        )
        self._kept_skins, self._is_fresh = None, True
        return SoftBody(self, len(self.model.gas) - 1)

    def add_box(
        self,
        size: ArrayLike,
        mass: float | None,
        position: ArrayLike = (0.0, 0.0, 0.0),
        orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        angular_velocity: ArrayLike = (0.0, 0.0, 0.0),
        restitution: float = 0.0,
        friction: float = 0.5,
    ) -> Box:
        """Add a homogeneous box of full extent `size` (3,) [m] and `mass` [kg]; None makes it static.

        `position` [m] of its centre, `orientation` a unit quaternion (w, x, y, z), `velocity` [m/s],
        `angular_velocity` [rad/s] in the world frame; `restitution` 0 … 1, `friction` ≥ 0.
        """
        extent = vector(size, "size")
        if not (extent > 0.0).all():
            raise ParameterError(f"size is {extent}; give three positive lengths [m]")
        if mass is None:
            inverse_mass, inverse_inertia = 0.0, np.zeros(3)
        else:
            check_range(mass, "mass", "kg", above=0.0)
            inverse_mass, inverse_inertia = (
                1.0 / mass,
                1.0 / np.array(box_inertia(tuple(extent), float(mass))),
            )
        check_range(restitution, "restitution", least=0.0, most=1.0)
        check_range(friction, "friction", least=0.0)
        row = [
            vector(position, "position"),
            unit_quaternion(orientation),
            vector(velocity, "velocity"),
            vector(angular_velocity, "angular_velocity"),
        ]
        if mass is None and (row[2].any() or row[3].any()):
            raise ParameterError("a static box (mass None) cannot have a velocity; give it a mass or leave it at rest")

        model, state = self.model, self.state
        self.model = model._replace(
            box_size=appended(model.box_size, extent),
            box_inverse_mass=appended(model.box_inverse_mass, inverse_mass),
            box_inverse_inertia=appended(model.box_inverse_inertia, inverse_inertia),
            box_restitution=appended(model.box_restitution, float(restitution)),
            box_friction=appended(model.box_friction, self._friction(friction)),
            box_force=appended(model.box_force, np.zeros(3)),
            box_torque=appended(model.box_torque, np.zeros(3)),
        )
        self.state = state._replace(
            box_position=appended(state.box_position, row[0]),
            box_orientation=appended(state.box_orientation, row[1]),
            box_velocity=appended(state.box_velocity, row[2]),
            box_angular_velocity=appended(state.box_angular_velocity, row[3]),
        )
        self._is_fresh = True
        return Box(self, len(self.model.box_size) - 1)

    def add_ground(self, height: float = 0.0, restitution: float = 0.0, friction: float = 0.5) -> None:
        """Make everything below z = `height` [m] solid ground; a second call moves it."""
        check_range(height, "height", "m")
        check_range(restitution, "restitution", least=0.0, most=1.0)
        check_range(friction, "friction", least=0.0)
        self.model = self.model._replace(
            ground_height=float(height),
            ground_restitution=float(restitution),
            ground_friction=self._friction(friction),
        )

    def _friction(self, friction: float) -> float:
        """Return the friction that something added has."""
        return 0.0 if self.rules.frictionless else float(friction)

    def step(self, time_step: float, steps: int = 1, *, substeps: int = 1, allow_unstable: bool = False) -> None:
        """Advance by `steps` steps of `time_step` [s]; soft bodies take each in `substeps` equal parts.

        Raises ParameterError for a step that is too long to be stable, unless told to allow it, and
        SimulationError if a soft body diverges or collapses; the state is then that of the last good step.
        """
        check_range(time_step, "time_step", "s", above=0.0)
        check_whole(steps, "steps", 0)
        check_whole(substeps, "substeps", 1)
        check_range(float(steps) * float(substeps), "steps × substeps", most=2.0**62)
        if not allow_unstable:
            self._check_stable(time_step, int(substeps))
        self._check_finite()
        fault, body, first = 0, -1, int(steps > 0 and self._is_fresh)
        if first:
            if self._may_collide():
                self._skins().deepest[0] = 0.0
            fault, body = self._run(float(time_step), 1, int(substeps))
            self._is_fresh = False
            self._warn_of_overlap()
        if not fault:
            fault, body = self._run(float(time_step), int(steps) - first, int(substeps))
        if fault:
            stable = self.stable_time_step()
            what = "diverged"
            if fault == COLLAPSED:
                least = self.model.least_volume[body]
                what = f"collapsed (deflated to {least:.3g} m³ or less)" if least else "collapsed (no volume left)"
            cure = (
                f"a stable time step here is {stable:.3g} s, not {time_step / substeps:.3g} s"
                if time_step / substeps > stable
                else "its gas is too weak or its load too strong for its springs; raise gas or stiffness"
            )
            raise SimulationError(
                f"soft body {body} {what} in step {self.steps}; {cure}. The state is the last good one.",
                self.steps,
                f"soft body {body}",
                stable,
            )

    def _run(self, time_step: float, steps: int, substeps: int) -> tuple[int, int]:
        """Do the steps, make room for contacts where it is needed, count them; return (fault, soft body)."""
        integrator, scratch = INTEGRATORS[self.integrator], self._scratch()
        threads = None if self.threads == 1 else self.threads
        left, fault, body = steps, OVERFLOW, -1
        while fault == OVERFLOW:
            with _team_of(self.threads):
                if self._may_collide():
                    every = (
                        self.model,
                        self.rings,
                        self.state,
                        scratch,
                        time_step,
                        left,
                        integrator,
                        self.rules,
                        substeps,
                    )
                    done, fault, body = run(*every, self.contacts, self._skins(), threads)
                else:
                    soft = self.model, self.rings, self.state, scratch, time_step, left, integrator, substeps
                    done, fault, body = run_soft_bodies(*soft, threads)
            left -= done
            self.steps += done
            self.time += done * time_step
            if fault == OVERFLOW:
                self.contacts = grown(self.contacts)
        return fault, body

    def _may_collide(self) -> bool:
        """Tell whether there is more than one soft body and, perhaps, the ground."""
        return len(self.model.box_size) > 0 or len(self.model.gas) > 1

    def _check_finite(self) -> None:
        """Raise ParameterError for the first body of which a position, velocity or force is not finite."""
        model, state = self.model, self.state
        for name, kind, rows in (
            ("position", "soft body", state.position),
            ("velocity", "soft body", state.velocity),
            ("external_force", "soft body", model.external_force),
            ("position", "box", state.box_position),
            ("orientation", "box", state.box_orientation),
            ("velocity", "box", state.box_velocity),
            ("angular_velocity", "box", state.box_angular_velocity),
            ("force", "box", model.box_force),
            ("torque", "box", model.box_torque),
        ):
            # A sum is quicker than a look at every number; it is finite only if they are.
            if len(rows) and not isfinite(rows.sum()) and not np.isfinite(rows).all():
                row = int(np.argmin(np.isfinite(rows).all(axis=1)))
                first = model.particle_start if kind == "soft body" else np.arange(len(rows))
                body = int(np.searchsorted(first, row, side="right")) - 1
                where = f" of particle {row - first[body]}" if kind == "soft body" else ""
                raise ParameterError(f"{name}{where} of {kind} {body} is not finite: {rows[row]}; set it to numbers")

    def _warn_of_overlap(self) -> None:
        """Warn of bodies whose deepest contact in the first step was a DEEP one."""
        if not self._may_collide():
            return
        soft, pair = len(self.model.gas), self._skins().deepest_pair
        depth = float(self._skins().deepest[0])
        thickness = np.append(self.model.thickness, self.model.box_size.min(axis=1))
        if depth > DEEP * thickness[pair].min():
            a, b = (f"soft body {k}" if k < soft else f"box {k - soft}" for k in pair)
            warnings.warn(
                f"{a} and {b} start {depth:.3g} m inside each other: they are pushed apart, from deep inside not all "
                "the way; move one of them first",
                OverlapWarning,
                stacklevel=3,
            )

    @property
    def threads(self) -> int:
        """Threads that move soft bodies; may be changed between steps, and is no part of a snapshot."""
        return self._threads

    @threads.setter
    def threads(self, value: int) -> None:
        check_whole(value, "threads", 1)
        most = numba.config.NUMBA_NUM_THREADS  # type: ignore[attr-defined]
        if value > most:
            raise ParameterError(f"threads is {value}, and there are {most} here; give a number from 1 to {most}")
        self._threads = int(value)

    def run(self, seconds: float, time_step: float, *, substeps: int = 1, allow_unstable: bool = False) -> None:
        """Advance by `seconds` [s] in steps of `time_step` [s], rounded to a whole number of steps; see `step`."""
        check_range(seconds, "seconds", "s", least=0.0)
        check_range(time_step, "time_step", "s", above=0.0)
        check_range(seconds / time_step, "seconds / time_step", most=2.0**62)
        self.step(time_step, round(seconds / time_step), substeps=substeps, allow_unstable=allow_unstable)

    def stable_time_step(self) -> float:
        """Return a time step [s] that is stable for every soft body as it is now; inf if there is none.

        From an upper bound of the highest frequency, so often a little shorter than need be. Contacts and motion
        that stretches the body further can ask for a shorter one.
        """
        limit = STABILITY_LIMIT[self.integrator]
        return min(
            (
                longest_stable_step(
                    highest_frequency(self.model, self.state.position, body), highest_damping(self.model, body), limit
                )
                for body in range(len(self.model.gas))
            ),
            default=np.inf,
        )

    def equilibrium(self, tolerance: float = 1e-12, steps: int = 200_000) -> None:
        """Move every soft body to its shape at rest, where it hangs on its pins, or floats without weight.

        The largest force left on a particle is at most `tolerance` times the body's stiffness and size. Velocities
        become zero; boxes, the ground and contacts play no part. Raises SimulationError after `steps` steps.
        """
        check_range(tolerance, "tolerance", above=0.0)
        check_whole(steps, "steps", 1)
        bodies = [SoftBody(self, body) for body in range(len(self.model.gas))]
        alone = self.state.position.copy()
        for body in bodies:
            rows, (model, rings) = body._rows(), body._alone()
            points = np.ascontiguousarray(alone[rows])
            scratch = scratch_for(model, rings)
            left, enough = np.inf, 0.0
            for _ in range(0, steps, RELAX_ROUND):
                # Half of the stable step of symplectic Euler: where the steering adds, less is more.
                longest = 1.0 / highest_frequency(model, points, 0)
                left = relax(model, rings, points, longest, min(steps, RELAX_ROUND), scratch)
                size = np.ptp(points, axis=0).max()
                enough = tolerance * model.stiffness.max() * size * model.inverse_mass.max()
                if not left > enough:
                    break
            if not left <= enough:
                raise SimulationError(
                    f"soft body {body.index} is not at rest after {steps} steps: a force of {left / enough:.3g} × the "
                    "tolerance is left; allow more steps, or see that external forces cancel or pins hold them",
                    self.steps,
                    f"soft body {body.index}",
                    self.stable_time_step(),
                )
            alone[rows] = points
        self.state.position[:] = alone
        self.state.velocity[:] = 0.0

    def snapshot(self) -> Snapshot:
        """Return all that the coming steps depend on, as named arrays that share no memory with the world.

        A world that is restored from it goes on to the same bits.
        """
        parts = {"model": self.model, "rings": self.rings, "state": self.state, "contacts": self.contacts}
        parts |= {"rules": self.rules}
        arrays = {key: array for name, part in parts.items() for key, array in named_arrays(name, part)}
        return arrays | {
            "integrator": np.array(self.integrator),
            "precision": np.array(self.precision),
            "steps": np.array(self.steps),
            "time": np.array(self.time),
        }

    def restore(self, snapshot: Snapshot) -> None:
        """Become what a world was when it gave this snapshot; handles of bodies go by number.

        Raises ParameterError, and changes nothing, if something is missing in it.
        """
        integrator = str(entry(snapshot, "integrator"))
        if integrator not in INTEGRATORS:
            raise ParameterError(f"integrator is {integrator!r}; choose one of {', '.join(INTEGRATORS)}")
        precision = str(entry(snapshot, "precision"))
        if precision not in PRECISIONS:
            raise ParameterError(f"precision is {precision!r}; choose one of {', '.join(PRECISIONS)}")
        steps, time = int(entry(snapshot, "steps")), float(entry(snapshot, "time"))
        model, state = rebuilt("model", self.model, snapshot), rebuilt("state", self.state, snapshot)
        contacts, rules = rebuilt("contacts", self.contacts, snapshot), rebuilt("rules", self.rules, snapshot)
        rings = in_precision(rebuilt("rings", self.rings, snapshot), PRECISIONS[precision])
        self.integrator, self.precision, self.steps, self.time = integrator, precision, steps, time
        self.model, self.rings, self.state, self.contacts, self.rules = model, rings, state, contacts, rules
        self._kept_skins, self._kept, self._stable_key, self._is_fresh = None, None, None, False

    def state_hash(self) -> str:
        """Return a SHA-256, in hexadecimal, of where the bodies are and how they move, to the last bit."""
        return digest(named_arrays("state", self.state))

    def save(self, path: str | Path) -> None:
        """Write a snapshot to an NPZ file, whole or not at all."""
        write(path, self.snapshot())

    @classmethod
    def load(cls, path: str | Path) -> World:
        """Return the world of a file that `save` wrote; raises ParameterError if it is another kind of file."""
        world = cls()
        world.restore(read(path))
        return world

    def __getstate__(self) -> Snapshot:
        """Pickle as a snapshot."""
        return self.snapshot()

    def __setstate__(self, snapshot: Snapshot) -> None:
        """Unpickle, to go on to the same bits."""
        World.__init__(self)
        self.restore(snapshot)

    def _skins(self) -> Skins:
        """Return what finds the contacts of soft bodies, kept until one is added."""
        if self._kept_skins is None:
            self._kept_skins = build_skins(self.model, self.state.position)
        return self._kept_skins

    def _scratch(self) -> Scratch:
        """Return memory for a run, kept until bodies are added or threads changed."""
        key = len(self.rings.order), self.threads
        if self._kept is None or self._kept_for != key:
            self._kept_for, self._kept = key, scratch_for(self.model, self.rings, self.threads)
        return self._kept

    def _check_stable(self, time_step: float, substeps: int) -> None:
        """Raise ParameterError if a sub-step is too long, by an estimate that is at most STABLE_FOR steps old."""
        key = self.integrator, id(self.model), self.model.gas.tobytes()
        if key != self._stable_key or not self._stable_at <= self.steps < self._stable_at + STABLE_FOR:
            self._stable_key, self._stable_at, self._stable_step = key, self.steps, self.stable_time_step()
        if time_step / substeps > self._stable_step:
            enough = int(np.ceil(time_step / self._stable_step))
            raise ParameterError(
                f"time_step / substeps is {time_step / substeps:.6g} s, and a stable time step here is "
                f"{self._stable_step:.6g} s with {self.integrator}: take that, or substeps={enough}, or say "
                "allow_unstable=True"
            )

    def energy(self) -> float:
        """Return kinetic + spring + gas + gravity energy [J] of every body that can move."""
        return total_energy(self.model, self.state)

    def linear_momentum(self) -> np.ndarray:
        """Return Σ m v (3,) [kg m/s]."""
        return np.array(linear_momentum(self.model, self.state))

    def angular_momentum(self) -> np.ndarray:
        """Return Σ x × m v + Σ I ω (3,) [kg m²/s] about the origin."""
        return np.array(angular_momentum(self.model, self.state))


class SoftBody:
    """A soft body in a World: its arrays are views of the world's, good until the next body is added."""

    def __init__(self, world: World, index: int) -> None:
        self.world = world
        self.index = index

    def _rows(self) -> slice:
        start = self.world.model.particle_start
        return slice(start[self.index], start[self.index + 1])

    @property
    def positions(self) -> np.ndarray:
        """Positions of the particles (n, 3) [m]."""
        return self.world.state.position[self._rows()]

    @property
    def triangles(self) -> np.ndarray:
        """Triangles (t, 3), as rows of `positions`."""
        model = self.world.model
        rows = slice(model.triangle_start[self.index], model.triangle_start[self.index + 1])
        return model.triangles[rows] - model.particle_start[self.index]

    @property
    def velocities(self) -> np.ndarray:
        """Velocities of the particles (n, 3) [m/s]."""
        return self.world.state.velocity[self._rows()]

    @property
    def centre(self) -> np.ndarray:
        """Centre of mass (3,) [m]; all particles have the same mass."""
        return self.positions.mean(axis=0)

    @property
    def volume(self) -> float:
        """Enclosed volume [m³]."""
        return body_volume(self.world.model, self.world.state.position, self.index)

    @property
    def pressure(self) -> float:
        """Pressure of the gas [Pa]."""
        return gas_pressure(self.gas, self.volume)

    @property
    def gas(self) -> float:
        """The gas's nRT [J]; may be changed between steps."""
        return float(self.world.model.gas[self.index])

    @gas.setter
    def gas(self, value: float) -> None:
        check_range(value, "gas", "J", least=0.0)
        self.world.model.gas[self.index] = value

    @property
    def external_force(self) -> np.ndarray:
        """Force on each particle (n, 3) [N] besides springs, gas and gravity; assign an (n, 3) array, or (3,) for all.

        It stays until it is changed.
        """
        force = self.world.model.external_force
        return force[self._rows()] if len(force) else np.zeros_like(self.positions)

    @external_force.setter
    def external_force(self, value: ArrayLike) -> None:
        try:
            force = np.broadcast_to(np.asarray(value, dtype=np.float64), self.positions.shape)
        except (TypeError, ValueError) as error:
            raise ParameterError(
                f"external_force does not fit; give (3,) or {self.positions.shape} numbers [N]"
            ) from error
        if not np.isfinite(force).all():
            raise ParameterError("external_force is not finite; give finite numbers [N]")
        if not len(self.world.model.external_force):
            self.world.model = self.world.model._replace(external_force=np.zeros_like(self.world.state.position))
        self.world.model.external_force[self._rows()] = force

    def set_springs(self, stiffness: ArrayLike | None = None, rest_length: ArrayLike | None = None) -> None:
        """Change `stiffness` [N/m] or `rest_length` [m] of all springs: one number, or (e,) as in add_soft_body."""
        model = self.world.model
        edges = slice(model.edge_start[self.index], model.edge_start[self.index + 1])
        count = edges.stop - edges.start
        stiffnesses, lengths = model.stiffness.copy(), model.rest_length.copy()
        if stiffness is not None:
            stiffnesses[edges] = stiffness_of(stiffness, count)
        if rest_length is not None:
            lengths[edges] = rest_length_of(rest_length, count)
        self.world.model = model._replace(
            stiffness=stiffnesses,
            rest_length=lengths,
        )
        rings = with_springs(self.world.rings, lengths, stiffnesses, model.edge_start)
        self.world.rings = in_precision(rings, PRECISIONS[self.world.precision])

    def _alone(self) -> tuple[Model, Rings]:
        """Return the model and rings of this body alone, without weight unless it is pinned."""
        model, b = self.world.model, self.index
        rows = self._rows()
        edges = slice(model.edge_start[b], model.edge_start[b + 1])
        triangles = slice(model.triangle_start[b], model.triangle_start[b + 1])
        one = slice(b, b + 1)
        pinned = (model.inverse_mass[rows] == 0.0).any()
        own_edges, own_triangles = model.edges[edges] - rows.start, model.triangles[triangles] - rows.start
        alone = _empty_model(model.gravity if pinned else np.zeros(3))._replace(
            inverse_mass=model.inverse_mass[rows],
            edges=own_edges,
            rest_length=model.rest_length[edges],
            stiffness=model.stiffness[edges],
            triangles=own_triangles,
            particle_start=np.array([0, rows.stop - rows.start]),
            edge_start=np.array([0, len(own_edges)]),
            triangle_start=np.array([0, len(own_triangles)]),
            gas=model.gas[one],
            thickness=model.thickness[one],
            edge_length=model.edge_length[one],
            least_volume=model.least_volume[one],
            damping=np.zeros(1),
            drag=np.zeros(1),
            external_force=model.external_force[rows],
            soft_restitution=model.soft_restitution[one],
            soft_friction=model.soft_friction[one],
        )
        return alone, build_rings(
            rows.stop - rows.start, own_edges, own_triangles, model.rest_length[edges], model.stiffness[edges]
        )


class Box:
    """A rigid box in a World: its arrays are views of the world's, good until the next body is added."""

    def __init__(self, world: World, index: int) -> None:
        self.world = world
        self.index = index

    @property
    def position(self) -> np.ndarray:
        """Position of the centre (3,) [m]."""
        return self.world.state.box_position[self.index]

    @property
    def orientation(self) -> np.ndarray:
        """Orientation (4,): unit quaternion (w, x, y, z), box frame to world."""
        return self.world.state.box_orientation[self.index]

    @property
    def velocity(self) -> np.ndarray:
        """Velocity of the centre (3,) [m/s]."""
        return self.world.state.box_velocity[self.index]

    @property
    def angular_velocity(self) -> np.ndarray:
        """Angular velocity (3,) [rad/s] in the world frame."""
        return self.world.state.box_angular_velocity[self.index]

    def apply_force(self, force: ArrayLike, point: ArrayLike | None = None) -> None:
        """Let `force` (3,) [N] act at `point` (3,) [m] of the world, or at the centre; paper §10.13.

        Adds F and τ = r × F, with the arm r as it is now, to what acts on the box. Both stay, in every step to come,
        until `clear_forces`.
        """
        push = vector(force, "force")
        if point is not None:
            self.apply_torque(np.cross(vector(point, "point") - self.position, push))
        self.world.model.box_force[self.index] += push

    def apply_torque(self, torque: ArrayLike) -> None:
        """Let `torque` (3,) [N m], in the world frame, act on the box until `clear_forces`."""
        self.world.model.box_torque[self.index] += vector(torque, "torque")

    def clear_forces(self) -> None:
        """Let nothing but gravity act on the box."""
        self.world.model.box_force[self.index] = 0.0
        self.world.model.box_torque[self.index] = 0.0


def _empty_model(gravity: np.ndarray) -> Model:
    none = np.empty(0)
    start = np.zeros(1, np.int64)
    return Model(
        inverse_mass=none,
        edges=np.empty((0, 2), np.int64),
        rest_length=none,
        stiffness=none,
        triangles=np.empty((0, 3), np.int64),
        particle_start=start,
        edge_start=start,
        triangle_start=start,
        gas=none,
        thickness=none,
        edge_length=none,
        least_volume=none,
        damping=none,
        drag=none,
        external_force=np.empty((0, 3)),
        soft_restitution=none,
        soft_friction=none,
        box_size=np.empty((0, 3)),
        box_inverse_mass=none,
        box_inverse_inertia=np.empty((0, 3)),
        box_restitution=none,
        box_friction=none,
        box_force=np.empty((0, 3)),
        box_torque=np.empty((0, 3)),
        gravity=gravity,
        ground_height=-np.inf,
        ground_restitution=0.0,
        ground_friction=0.0,
    )


@contextmanager
def _team_of(threads: int) -> Iterator[None]:
    """Let Numba have that many threads; one, and nothing runs on Numba's threads."""
    if threads == 1:
        yield
        return
    before = numba.get_num_threads()
    numba.set_num_threads(threads)
    try:
        yield
    finally:
        numba.set_num_threads(before)
