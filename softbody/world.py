"""A world to fill with bodies, step, and look at: the host side of the core."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numba
import numpy as np
from numpy.typing import ArrayLike

from softbody.bodies import Box, SoftBody
from softbody.builder import Parts, empty_parts, properties_of, with_box, with_soft_body
from softbody.collision.contact import Contacts, new_contacts, remembered, remembering
from softbody.collision.manifold import new_manifold
from softbody.collision.surface import Surfaces, build_surfaces
from softbody.dynamics.energy import angular_momentum, linear_momentum, total_energy
from softbody.dynamics.soft_bodies import Motion, motion_of
from softbody.dynamics.vertex_rings import in_precision
from softbody.errors import ParameterError, SimulationError
from softbody.guards import StableStep, check_finite, fault_of, stable_time_step, warn_of_mass_ratios, warn_of_overlap
from softbody.mesh import Mesh
from softbody.parameters import check_range, check_whole, vector
from softbody.settings import INTEGRATORS, PAPER, Choices, check_name, integrator_name, settings_of
from softbody.shape_at_rest import shape_at_rest
from softbody.snapshot import Snapshot, digest, entry, named_arrays, read, rebuilt, write
from softbody.state import Controls, Model, State, VertexRings
from softbody.step import Work, run, run_alone
from softbody.threads import team_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

PRECISIONS: dict[str, type[np.floating[Any]]] = {"double": np.float64, "single": np.float32}

FIRST_ROOM = 256  # contacts; there is more as soon as it is needed


class World:
    """Soft bodies, rigid boxes and a ground that move together.

    `gravity` (3,) [m/s²]. `precision` in which soft bodies move between contacts: "double", or "single", which is
    faster and rounds their positions to 6e-8 of the distance from the origin; everything else is double in both.
    `threads` that move soft bodies and find and resolve their contacts, with the same result to the last bit; they are
    compiled for when first used. Worlds that are stepped at the same time by threads of their own need 1.

    Choices, all keywords: `integrator`: "rk4_velocity" (the paper's, default), "rk4" or "symplectic_euler". `axes`
    of the separating-axis test of boxes: "complete", or "paper" for face normals only. `contact` of boxes: "manifold",
    all points solved together in `iterations` sweeps a step (30; up to four times as many where an impact or friction
    is still on its way through a pile), or "single", the paper's one impulse a pair, half-way
    between the two where one lies on the other. `soft_contact`, those of soft bodies: "together", within the step, or
    "single", as in the paper: one after the other, half of the overlap to each side, at the end of the step. `pairs` to
    test: those near in a "grid", or "exhaustive", as in the paper, which tries the normals of all faces of two soft
    bodies, too, before it looks closer, with the same result.
    `edge_contacts` (True): edges hold edges, of boxes and of soft bodies, and not only particles and corners, as in the
    paper. `split_steps` (True): where a soft body and another would jump through each other, a step is taken in parts.

    More of the paper, off by default: `speed_ceiling` [m/s] and `angular_speed_ceiling` [rad/s]; a box on the ground
    that turns more slowly than `angular_speed_floor` [rad/s] stops turning and snaps to the nearest multiples of 90°;
    `frictionless`: whatever is added has friction 0. `World.paper()` has all of the paper.
    Beyond it: `gyroscopic` torque, so that a free box keeps its angular momentum.

    Bodies may be added at any time. Every input is checked before it is stored: ParameterError and MeshError name the
    culprit and the cure.
    """

    def __init__(
        self,
        gravity: ArrayLike = (0.0, 0.0, -9.81),
        *,
        precision: str = "double",
        threads: int = 1,
        **choices: Unpack[Choices],
    ) -> None:
        self.settings = settings_of(choices)
        check_name(precision, "precision", tuple(PRECISIONS))
        self.precision = precision
        self.threads = threads
        self._take(empty_parts(vector(gravity, "gravity"), PRECISIONS[precision]))
        self.contacts: Contacts = new_contacts(FIRST_ROOM)
        self._manifold = new_manifold()
        self.steps = 0
        self.time = 0.0
        self._stable_step = StableStep()

    @classmethod
    def paper(cls, **changes: Any) -> World:
        """Return a world that does as the paper does in all that it chose; `changes` are other arguments of a World."""
        return cls(**{**PAPER, **changes})

    def _take(self, parts: Parts) -> None:
        """Become a world of other bodies; what was made for those before is forgotten."""
        self.model: Model = parts.model
        self.controls: Controls = parts.controls
        self.state: State = parts.state
        self.rings: VertexRings = parts.rings
        self._motion: Motion | None = None
        self._surfaces: Surfaces | None = None
        self._is_fresh = True  # bodies were added since the last step

    @property
    def _parts(self) -> Parts:
        return Parts(self.model, self.controls, self.state, self.rings)

    @property
    def integrator(self) -> str:
        """How soft bodies move: "rk4_velocity", "rk4" or "symplectic_euler"; may be changed between steps."""
        return integrator_name(self.settings)

    @integrator.setter
    def integrator(self, value: str) -> None:
        check_name(value, "integrator", tuple(INTEGRATORS))
        self.settings = self.settings._replace(integrator=INTEGRATORS[value])

    @property
    def threads(self) -> int:
        """Threads that move soft bodies and find their contacts; may be changed, and is no part of a snapshot."""
        return self._threads

    @threads.setter
    def threads(self, value: int) -> None:
        check_whole(value, "threads", 1)
        most = numba.config.NUMBA_NUM_THREADS  # type: ignore[attr-defined]
        if value > most:
            raise ParameterError(f"threads is {value}, and there are {most} here; give a number from 1 to {most}")
        self._threads = int(value)
        self._motion = self._surfaces = None

    def add_soft_body(
        self,
        mesh: Mesh,
        mass: float,
        stiffness: ArrayLike,
        gas: float,
        position: ArrayLike = (0.0, 0.0, 0.0),
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        *,
        rest_length: ArrayLike | None = None,
        fixed: ArrayLike = (),
        **properties: float,
    ) -> SoftBody:
        """Add a soft body whose springs are at rest in the shape of `mesh`, moved by `position` [m].

        `mass` [kg] of the whole body, shared equally by its particles. `stiffness` [N/m] of every spring, or
        (e,) in the order of `mesh.edges`. `gas` is nRT [J] ≥ 0; 0 for an empty body. `rest_length` [m] of every spring,
        or (e,), if not as in the mesh. `fixed`: indices of vertices that stay in place.

        Properties, all keywords: `restitution` 0 … 1 (0) and `friction` ≥ 0 (0.5) in contacts; `damping` [N s/m] of the
        springs, against the speed at which their ends part; `drag` [1/s], the rate at which all velocities fade. The
        body counts as collapsed, which ends a run with a SimulationError, at the fraction `deflated_below` of the
        mesh's volume (0: at none left).
        """
        springs, motion = (stiffness, rest_length), (position, velocity)
        checked = self._properties("soft", properties)
        self._take(with_soft_body(self._parts, mesh, mass, gas, springs, motion, fixed, checked))
        return SoftBody(self, self.model.soft_count - 1)

    def add_box(
        self,
        size: ArrayLike,
        mass: float | None,
        position: ArrayLike = (0.0, 0.0, 0.0),
        orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        angular_velocity: ArrayLike = (0.0, 0.0, 0.0),
        **properties: float,
    ) -> Box:
        """Add a homogeneous box of full extent `size` (3,) [m] and `mass` [kg]; None makes it static.

        `position` [m] of its centre, `orientation` a unit quaternion (w, x, y, z), `velocity` [m/s],
        `angular_velocity` [rad/s] in the world frame. Properties, both keywords: `restitution` 0 … 1 (0) and
        `friction` ≥ 0 (0.5).
        """
        pose, motion = (position, orientation), (velocity, angular_velocity)
        self._take(with_box(self._parts, size, mass, pose, motion, self._properties("box", properties)))
        return Box(self, self.model.box_count - 1)

    def add_ground(self, height: float = 0.0, restitution: float = 0.0, friction: float = 0.5) -> None:
        """Make everything below z = `height` [m] solid ground; a second call moves it."""
        check_range(height, "height", "m")
        check_range(restitution, "restitution", least=0.0, most=1.0)
        check_range(friction, "friction", least=0.0)
        self.model = self.model._replace(
            ground_height=float(height),
            ground_restitution=float(restitution),
            ground_friction=0.0 if self.settings.frictionless else float(friction),
        )

    def _properties(self, kind: str, given: dict[str, float]) -> dict[str, float]:
        """Return the properties of a new body of a kind, checked."""
        properties = properties_of(kind, given)
        return properties | ({f"{kind}_friction": 0.0} if self.settings.frictionless else {})

    def step(self, time_step: float, steps: int = 1, *, substeps: int = 1, allow_unstable: bool = False) -> None:
        """Advance by `steps` steps of `time_step` [s]; soft bodies take each in `substeps` equal parts.

        Raises ParameterError for a step that is too long to be stable, unless told to allow it, and
        SimulationError if a soft body diverges or collapses; the state is then that of the last good step.
        """
        check_range(time_step, "time_step", "s", above=0.0)
        check_whole(steps, "steps", 0)
        check_whole(substeps, "substeps", 1)
        check_range(float(steps) * float(substeps), "steps × substeps", most=2.0**62)
        settings = self.settings._replace(substeps=int(substeps))
        if not allow_unstable:
            self._stable_step.check(float(time_step), self.model, self.controls, self.state, settings, self.steps)
        check_finite(self.model, self.controls, self.state)
        first = int(steps > 0 and self._is_fresh)
        fault, body = self._first_step(float(time_step), int(substeps)) if first else (0, -1)
        if not fault:
            fault, body = self._run(float(time_step), int(steps) - first, int(substeps))
        if fault:
            part, stable = time_step / substeps, self.stable_time_step()
            raise fault_of(fault, body, self.model, part, stable, self.steps)
        if self.model.box_count:
            warn_of_mass_ratios(self.model, self.controls, self.contacts)

    def _first_step(self, time_step: float, substeps: int) -> tuple[int, int]:
        """Do the first step after bodies were added, and warn of those that overlap; return (fault, soft body)."""
        if not self._may_collide():
            self._is_fresh = False
            return self._run(time_step, 1, substeps)
        surfaces = self._touching()
        if surfaces is not None:
            surfaces.deepest[0] = 0.0
        stopped = self._run(time_step, 1, substeps)
        self._is_fresh = False
        if surfaces is not None:
            warn_of_overlap(self.model, surfaces)
        return stopped

    def _run(self, time_step: float, steps: int, substeps: int) -> tuple[int, int]:
        """Do the steps and count them; return (fault, soft body)."""
        settings = self.settings._replace(substeps=substeps)
        with team_of(self.threads):
            if self._may_collide():
                work = self._work()
                what = self.model, self.controls, self.state, work, self.contacts
                self.contacts, done, fault, body = run(*what, settings, time_step, steps)
            else:
                alone = self.model, self.controls, self.state, self._moving()
                done, fault, body = run_alone(*alone, settings, time_step, steps)
        self.steps += done
        self.time += done * time_step
        return fault, body

    def _may_collide(self) -> bool:
        """Tell whether there is more than one soft body and, perhaps, the ground."""
        return self.model.box_count > 0 or self.model.soft_count > 1

    def _work(self) -> Work:
        """Return what a step needs, with nothing for a kind of bodies that there is none of."""
        motion = self._moving() if self.model.soft_count else None
        has_boxes = self.model.box_count > 0
        manifold = self._manifold if has_boxes else None
        grounded = np.zeros(self.model.box_count, bool) if has_boxes else None
        return Work(motion, self._touching(), manifold, self.state.copy(), grounded)

    def _moving(self) -> Motion:
        """Return what moves soft bodies; its memory is kept until bodies are added or threads change."""
        if self._motion is None:
            self._motion = motion_of(self.model.soft_particle_start, self.rings, self.threads)
        return self._motion._replace(rings=self.rings)

    def _touching(self) -> Surfaces | None:
        """Return what finds the contacts of soft bodies, if any; it is kept until one is added or threads change."""
        if self._surfaces is None and self.model.soft_count:
            self._surfaces = build_surfaces(self.model, self.state.particle_position, self.threads)
        return self._surfaces

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
        return stable_time_step(self.model, self.controls, self.state, self.settings)

    def equilibrium(self, tolerance: float = 1e-12, steps: int = 200_000) -> None:
        """Move every soft body to its shape at rest, where it hangs on its fixed particles, or floats without weight.

        The acceleration left of any particle, times the least mass of one, is at most `tolerance` times the body's
        stiffness and size, in each component. Velocities become zero; boxes, the ground and contacts play no part.
        Raises SimulationError after `steps` steps.
        """
        check_range(tolerance, "tolerance", above=0.0)
        check_whole(steps, "steps", 1)
        shapes = []
        for body in range(self.model.soft_count):
            shape, left = shape_at_rest(self._parts, body, tolerance, int(steps))
            if not left <= 1.0:
                raise SimulationError(
                    f"soft body {body} is not at rest after {steps} steps: a force of {left:.3g} × the tolerance is "
                    "left; allow more steps, or see that external forces cancel or fixed particles hold them",
                    self.steps,
                    f"soft body {body}",
                    self.stable_time_step(),
                )
            shapes.append(shape)
        for body, shape in enumerate(shapes):
            SoftBody(self, body).positions[:] = shape
        self.state.particle_velocity[:] = 0.0

    def snapshot(self) -> Snapshot:
        """Return all that the coming steps depend on, as named arrays that share no memory with the world.

        A world that is restored from it goes on to the same bits.
        """
        parts = self._parts._asdict() | {"cache": remembered(self.contacts), "settings": self.settings}
        arrays = {key: array for name, part in parts.items() for key, array in named_arrays(name, part)}
        return arrays | {
            "precision": np.array(self.precision),
            "steps": np.array(self.steps),
            "time": np.array(self.time),
        }

    def restore(self, snapshot: Snapshot) -> None:
        """Become what a world was when it gave this snapshot; handles of bodies go by number.

        Raises ParameterError, and changes nothing, if something is missing in it.
        """
        precision = str(entry(snapshot, "precision"))
        check_name(precision, "precision", tuple(PRECISIONS))
        steps, time = int(entry(snapshot, "steps")), float(entry(snapshot, "time"))
        settings = rebuilt("settings", self.settings, snapshot)
        if settings.integrator not in INTEGRATORS.values():
            raise ParameterError(f"settings.integrator is {settings.integrator}; there are {', '.join(INTEGRATORS)}")
        contacts = remembering(rebuilt("cache", self.contacts.cache, snapshot), FIRST_ROOM)
        parts = Parts(*(rebuilt(name, part, snapshot) for name, part in self._parts._asdict().items()))
        parts = parts._replace(rings=in_precision(parts.rings, PRECISIONS[precision]))
        self._take(parts)
        self.contacts, self.settings, self.precision = contacts, settings, precision
        self.steps, self.time = steps, time
        self._stable_step, self._is_fresh = StableStep(), False

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

    def energy(self) -> float:
        """Return kinetic + spring + gas + gravity energy [J] of every body that can move, less the work of forces.

        That is, Σ f·x of the forces on particles; forces on boxes are not in it.
        """
        return total_energy(self.model, self.controls, self.state)

    def linear_momentum(self) -> np.ndarray:
        """Return Σ m v (3,) [kg m/s]."""
        return np.array(linear_momentum(self.model, self.state))

    def angular_momentum(self) -> np.ndarray:
        """Return Σ x × m v + Σ I ω (3,) [kg m²/s] about the origin."""
        return np.array(angular_momentum(self.model, self.state))
