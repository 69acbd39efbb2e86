"""A world to fill with bodies, step, and look at: the host side of the core."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from math import ceil
from typing import TYPE_CHECKING, Any
from weakref import WeakValueDictionary

import numba
import numpy as np
from numpy.typing import ArrayLike

from softbody.bodies.body import Body
from softbody.bodies.builder import (
    Parts,
    empty_parts,
    joints_that_stay,
    properties_of,
    rings_of,
    with_box,
    with_joint,
    with_soft_body,
    without,
)
from softbody.bodies.contact_points import ContactPoints, contact_points
from softbody.bodies.ground import Ground
from softbody.bodies.joint import End, Joint, ends_of
from softbody.bodies.names import GONE, Names
from softbody.bodies.rigid_box import Box
from softbody.bodies.soft_body import SoftBody
from softbody.bodies.strict_names import StrictNames
from softbody.collision.boxes.manifold import new_manifold
from softbody.collision.contact import Contacts, new_contacts, remembered, remembering, without_box
from softbody.collision.soft.surface import Surfaces, build_surfaces
from softbody.compiler.interrupts import SILENT, Bell, assign_together, listening, set_together
from softbody.compiler.threads import Team, team_of
from softbody.dynamics.energy import (
    Energies,
    angular_momentum,
    kinetic_energy,
    linear_momentum,
    potential_energies,
    total_energy,
)
from softbody.dynamics.joint_forces import joint_energy, joint_memory
from softbody.dynamics.soft_bodies import Motion, motion_of
from softbody.dynamics.stability import most_extents
from softbody.errors import BusyError, ParameterError, SimulationError, SnapshotError
from softbody.mesh.mesh import Mesh
from softbody.model.arrays import Controls, Model, State, VertexRings
from softbody.model.settings import (
    INTEGRATORS,
    PAPER,
    PRECISIONS,
    RK4_VELOCITY,
    Choices,
    Settings,
    check_name,
    integrator_name,
    settings_of,
)
from softbody.model.shapes import labels_of, pose_of, shapes_of
from softbody.model.validation import check_range, check_whole, check_yes_or_no, shown, vector
from softbody.stepping.checks import (
    StableStep,
    check_finite,
    check_pace,
    fault_of,
    helpful_step,
    longest_step_of_joints,
    may_carry_too_much,
    stable_time_step,
    warn_of_mass_ratios,
    warn_of_overlap,
)
from softbody.stepping.shape_at_rest import shape_at_rest
from softbody.stepping.sleep import not_rested
from softbody.stepping.sleep_tracker import Sleepers
from softbody.stepping.step import NO_ROOM, UNSEEN, Clock, Work, run_alone_by_clock, run_by_clock
from softbody.stepping.time_steps import BOX_STEP, OF_STABLE, Remainder, check_own_steps, whole_steps
from softbody.storage.npz import MOST_BYTES, read, write
from softbody.storage.snapshot import Snapped, checked, digest, named_arrays, snapshot_of
from softbody.storage.snapshot_entries import Snapshot

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from softbody.render.camera import Camera

FIRST_ROOM = 256  # contacts; there is more as soon as it is needed


WORTH_LISTENING = 50_000  # particles moved by a sub-step in a call, from which it may take so long that one waits


class _Bodies:
    """The bodies of a world, and what was made for them: replaced as one, so that no interrupt comes between."""

    def __init__(self, parts: Parts, names: Names, sleepers: Sleepers, is_fresh: bool = True) -> None:
        self.parts = parts
        self.names = names
        self.sleepers = sleepers
        sleepers.rest.settled[:] = False
        self.is_fresh = is_fresh  # bodies were added since the last step
        self.motion: Motion | None = None
        self.surfaces: Surfaces | None = None
        self.start: State | None = None  # memory for that of a step
        self.grounded: np.ndarray | None = None  # memory for which boxes touch the ground
        self.acting: Controls | None = None  # memory for what acts in a step that has joints
        self.limits_of: tuple[Model | None, bytes] = None, b""  # for which springs and gas bodies' extents are limited
        self.team: Team | None = None
        self.ground_impulse = np.zeros_like(parts.state.particle_position)  # (n, 3) [N s] in the last step
        self._unlike_of: tuple[Model | None, bool] = None, False  # of which masses, and whether any are too unlike

    def may_carry_too_much(self, model: Model) -> bool:
        """Tell what `guards.may_carry_too_much` says of a model, which is asked once."""
        if self._unlike_of[0] is not model:
            self._unlike_of = model, may_carry_too_much(model)
        return self._unlike_of[1]


def _new_clock(steps: int = 0, time: float = 0.0) -> Clock:
    return Clock(np.array([steps], np.int64), np.array([time]), np.zeros(1, np.int64))


class World(StrictNames):
    """Soft bodies, rigid boxes and a ground that move together.

    `gravity` (3,) [m/s²]. `precision` in which soft bodies move between contacts: "double", or "single", which is
    faster and rounds their positions to 6e-8 of the distance from the origin; everything else is double in both.
    `threads` that move soft bodies and find and resolve their contacts, with the same result to the last bit; they are
    compiled for when first used, and where one alone is faster just now, for others use the machine, it is one. Worlds
    that are stepped at the same time by threads of their own need 1.

    Choices, all keywords: `integrator` of soft bodies: "symplectic_euler" (default), "rk4", four times the work and far
    more exact, or "rk4_velocity", the paper's, as much work and a damping that grows with the step. `substeps`: 1
    (default), or in how many equal parts soft bodies take each step, while contacts are found and resolved once: steps
    may be so many times as long, and worlds of many contacts cost half as much with 2, a third with 4. `axes` of the
    separating-axis test of boxes: "complete", or "paper" for face normals only. `contact` of boxes: "manifold",
    all points solved together in `iterations` sweeps a step (30; up to four times as many while they converge
    fast), or "single", the paper's one impulse a pair, half-way
    between the two where one lies on the other. `soft_contact`, those of soft bodies: "together", within the step, or
    "single", as in the paper: one after the other, half of the overlap to each side, at the end of the step. `pairs` to
    test: those near in a "grid", or "exhaustive", as in the paper, which tries the normals of all faces of two soft
    bodies, too, before it looks closer, with the same result.
    `edge_contacts` (True): edges hold edges, of boxes and of soft bodies, and not only particles and corners, as in the
    paper. `split_steps` (True): where a soft body and another would jump through each other, a step is taken in parts.

    More of the paper, off by default: `speed_ceiling` [m/s] and `angular_speed_ceiling` [rad/s]; a box on the ground
    that turns more slowly than `angular_speed_floor` [rad/s] stops turning and snaps to the nearest multiples of 90°;
    `frictionless`: whatever is added has friction 0. `World.paper()` has all of the paper.
    Beyond it: `gyroscopic` torque, so that a free box keeps its angular momentum; and bodies fall asleep, so that
    steps cost nothing for them, that have been slower than `sleep_speed` [m/s] for `sleep_after` [s] (0.5) with all
    that they touch or are joined to: until something comes near, or something of them or that acts on them changes.
    Speed is the root mean square over their mass.

    Bodies may be added at any time. Every input is checked before it is stored: ParameterError and MeshError name the
    culprit and the cure.
    """

    __slots__ = (
        "__weakref__",
        "_bodies",
        "_clock",
        "_handles",
        "_manifold",
        "_precision",
        "_remainder",
        "_stable_step",
        "_threads",
        "_time_step",
        "_turn",
        "contacts",
        "settings",
    )

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
        self._precision = precision
        self._turn = threading.Lock()  # of who steps, or changes what there is
        self._take(empty_parts(vector(gravity, "gravity"), PRECISIONS[precision]), Names())
        self.threads = threads
        self.contacts: Contacts = new_contacts(FIRST_ROOM)
        self._manifold = new_manifold()
        self._clock = _new_clock()
        self._stable_step = StableStep()
        self._handles: WeakValueDictionary[int, Body] = WeakValueDictionary()
        self._remainder = Remainder()
        self._time_step = 0.0  # [s] of the last step

    @classmethod
    def paper(cls, **changes: Any) -> World:
        """Return a world that does as the paper does in all that it chose; `changes` are other arguments of a World."""
        return cls(**{**PAPER, **changes})

    def _take(self, parts: Parts, names: Names) -> None:
        """Become a world of other bodies; what was made for those before is forgotten."""
        self._bodies = _Bodies(parts, names, Sleepers(parts, not_rested(parts.model)))

    def replace(self, **parts: Any) -> None:
        """Replace some of `model`, `controls`, `state` and `rings`, for the same bodies, all at once or none."""
        self._bodies.parts = self._bodies.parts._replace(**parts)

    @property
    def _parts(self) -> Parts:
        return self._bodies.parts

    @property
    def _names(self) -> Names:
        return self._bodies.names

    @_names.setter
    def _names(self, value: Names) -> None:
        self._bodies.names = value

    def __getitem__(self, name: str) -> SoftBody | Box | Joint:
        """Return a handle of the body, or joint, that has a name; raises ParameterError, which lists those there are.

        It was given where it was added, `add_box(…, name="lid")`, or later, `box.name = "lid"`.
        """
        kind, index = self._names.who(name)
        return Joint(self, index) if kind == "joint" else Box(self, index) if kind == "box" else SoftBody(self, index)

    def __contains__(self, name: object) -> bool:
        """Tell whether a body, or a joint, has this name."""
        return name in self._names

    def __repr__(self) -> str:
        """Say what is in the world, and how far it is."""
        model = self.model
        what = [f"{model.soft_count} soft bodies of {len(self.state.particle_position)} particles"]
        what += [f"{model.box_count} boxes"]
        what += [f"ground at {model.ground_height:.4g} m"] if model.ground_height > -np.inf else []
        return f"<World: {', '.join(what)}; {self.steps} steps, {self.time:.6g} s>"

    @property
    def soft_bodies(self) -> tuple[SoftBody, ...]:
        """All soft bodies, as they were added."""
        return tuple(SoftBody(self, i) for i in range(self.model.soft_count))

    @property
    def boxes(self) -> tuple[Box, ...]:
        """All boxes, as they were added."""
        return tuple(Box(self, i) for i in range(self.model.box_count))

    @property
    def ground(self) -> Ground:
        """The ground: its height, restitution and friction may be set between steps, once there is one."""
        return Ground(self)

    def follow(self, body: Body) -> None:
        """Keep the index of a handle right for as long as there is the handle."""
        self._handles[id(body)] = body

    @property
    def gravity(self) -> np.ndarray:
        """Gravity (3,) [m/s²]; may be assigned between steps."""
        return self.controls.gravity

    @gravity.setter
    def gravity(self, value: ArrayLike) -> None:
        self.controls.gravity[:] = vector(value, "gravity")

    @property
    def model(self) -> Model:
        """What the bodies are."""
        return self._bodies.parts.model

    @model.setter
    def model(self, value: Model) -> None:
        self.replace(model=value)

    @property
    def controls(self) -> Controls:
        """What acts on the bodies."""
        return self._bodies.parts.controls

    @controls.setter
    def controls(self, value: Controls) -> None:
        self.replace(controls=value)

    @property
    def state(self) -> State:
        """Where the bodies are."""
        return self._bodies.parts.state

    @property
    def joints(self) -> tuple[Joint, ...]:
        """All joints, as they were added."""
        return tuple(Joint(self, i) for i in range(len(self._parts.joints.joint_box)))

    @property
    def rings(self) -> VertexRings:
        """The soft bodies, in the order in which kernels read them."""
        return self._bodies.parts.rings

    @property
    def steps(self) -> int:
        """Steps done since the world was made."""
        return int(self._clock.steps[0])

    @steps.setter
    def steps(self, value: int) -> None:
        self._clock.steps[0] = value

    @property
    def time(self) -> float:
        """Time since the world was made [s]."""
        return float(self._clock.time[0])

    @time.setter
    def time(self, value: float) -> None:
        self._clock.time[0] = value

    def _my_turn(self) -> threading.Lock:
        """Return what to hold while something is done with the world; raises BusyError while it is being stepped."""
        if self._turn.locked():
            raise BusyError(
                "this world is being stepped, by another thread or by what called this; wait until it is done, or give "
                "each thread a world of its own"
            )
        return self._turn

    @property
    def integrator(self) -> str:
        """How soft bodies move: "symplectic_euler", "rk4" or "rk4_velocity"; may be changed between steps.

        Bodies that there are keep their damping.
        """
        return integrator_name(self.settings)

    @integrator.setter
    def integrator(self, value: str) -> None:
        check_name(value, "integrator", tuple(INTEGRATORS))
        self.settings = self.settings._replace(integrator=INTEGRATORS[value])

    @property
    def substeps(self) -> int:
        """In how many equal parts soft bodies take each step, with contacts once a step; may be changed between steps.

        `stable_time_step` is as many times as long, and so are the steps that the world chooses.
        """
        return self.settings.substeps

    @substeps.setter
    def substeps(self, value: int) -> None:
        self.settings = self.settings._replace(substeps=settings_of({"substeps": value}).substeps)

    @property
    def precision(self) -> str:
        """In which soft bodies move between contacts: "double" or "single"."""
        return self._precision

    @property
    def threads(self) -> int:
        """Threads that move soft bodies and find their contacts; may be changed, and is no part of a snapshot."""
        return self._threads

    @threads.setter
    def threads(self, value: int) -> None:
        value = check_whole(value, "threads", 1)
        most = numba.config.NUMBA_NUM_THREADS  # type: ignore[attr-defined]
        if value > most:
            raise ParameterError(
                f"threads is {shown(value)}, and there are {most} here; give a number from 1 to {most}"
            )
        with self._my_turn():
            self._bodies = _Bodies(self._parts, self._names, self._bodies.sleepers, self._bodies.is_fresh)
            self._threads = value

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
        damping: float | None = None,
        fixed: ArrayLike = (),
        name: str | None = None,
        **properties: float,
    ) -> SoftBody:
        """Add a soft body whose springs are at rest in the shape of `mesh`, moved by `position` [m].

        `mass` [kg] of the whole body, shared equally by its particles. `stiffness` [N/m] of every spring, or
        (e,) in the order of `mesh.edges`. `gas` is nRT [J] ≥ 0; 0 for an empty body. `rest_length` [m] of every spring,
        or (e,), if not as in the mesh. `damping` [N s/m] of the springs, against the speed at which their ends part.
        None: a tenth of what is critical for two particles on a spring, 0.1 √(2 k m), with k the mean stiffness and m
        the mass of a particle; or 0 in a world whose integrator is "rk4_velocity", which damps by itself.
        `fixed`: indices of vertices that stay in place. `name`, by which the world finds it, `world[name]`: a text that
        nothing else in the world is called.

        Properties, all keywords: `restitution` 0 … 1 (0) and `friction` ≥ 0 (0.5) in contacts; `drag` [1/s], the rate
        at which all velocities fade. The body counts as collapsed, which ends a run with a SimulationError, at the
        fraction `deflated_below` of the mesh's volume (0: at none left).
        """
        springs, motion = (stiffness, rest_length), (position, velocity)
        if damping is None and self.settings.integrator == RK4_VELOCITY:
            damping = 0.0
        checked = self._properties("soft", {**properties, "damping": damping})
        with self._my_turn():
            names = self._names.renamed(("soft", self.model.soft_count), name)
            self._take(with_soft_body(self._parts, mesh, mass, gas, springs, motion, fixed, checked), names)
            return SoftBody(self, self.model.soft_count - 1)

    def add_box(
        self,
        size: ArrayLike,
        mass: float | None,
        position: ArrayLike = (0.0, 0.0, 0.0),
        orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        angular_velocity: ArrayLike = (0.0, 0.0, 0.0),
        *,
        name: str | None = None,
        **properties: float,
    ) -> Box:
        """Add a homogeneous box of full extent `size` (3,) [m] and `mass` [kg].

        None makes it static, or kinematic: it moves by its velocities, pushes what it meets, and nothing changes that.

        `position` [m] of its centre, `orientation` a unit quaternion (w, x, y, z), `velocity` [m/s],
        `angular_velocity` [rad/s] in the world frame. Properties, both keywords: `restitution` 0 … 1 (0) and
        `friction` ≥ 0 (0.5). `name`, by which the world finds it, `world[name]`: one that nothing else in it has.
        """
        pose, motion = (position, orientation), (velocity, angular_velocity)
        checked = self._properties("box", properties)
        with self._my_turn():
            names = self._names.renamed(("box", self.model.box_count), name)
            self._take(with_box(self._parts, size, mass, pose, motion, checked), names)
            return Box(self, self.model.box_count - 1)

    def add_joint(
        self,
        a: End,
        b: End,
        stiffness: float,
        damping: float = 0.0,
        rest_length: float = 0.0,
        *,
        name: str | None = None,
    ) -> Joint:
        """Join two ends by a damped spring; return its handle.

        An end is a place (3,) [m] in the world, which may be moved later; or a body and a place (3,) [m] on it as it is
        now, `(body, place)`: of a soft body the point of its surface nearest to that; or a soft body and the number of
        a particle, `(body, 7)`. `stiffness` [N/m], `damping` [N s/m], `rest_length` [m]: of 0, a is pulled to b, and
        all their motion against each other damped; of more, it acts along the joint, both ways. `name`, by which the
        world finds it, `world[name]`: one that nothing else in it has.

        It is a force, constant within a step, for which a step can be too long: see `stable_time_step`. Bodies that
        are joined touch as others do.
        """
        numbers = {
            "joint_stiffness": check_range(stiffness, "stiffness", "N/m", least=0.0),
            "joint_damping": check_range(damping, "damping", "N s/m", least=0.0),
            "joint_rest_length": check_range(rest_length, "rest_length", "m", least=0.0),
        }
        with self._my_turn():
            number = len(self._parts.joints.joint_box)
            names = self._names.renamed(("joint", number), name)
            self._take(with_joint(self._parts, ends_of(self, a, b), numbers), names)
            return Joint(self, number)

    def add_ground(self, height: float = 0.0, restitution: float = 0.0, friction: float = 0.5) -> Ground:
        """Make everything below z = `height` [m] solid ground; return its handle. A second call sets all three anew.

        `restitution` 0 … 1 and `friction` ≥ 0 in contacts.
        """
        height, restitution = Ground.height.checked(height), Ground.restitution.checked(restitution)
        friction = Ground.friction.checked(friction)
        with self._my_turn():
            self.model = self.model._replace(
                ground_height=height,
                ground_restitution=restitution,
                ground_friction=0.0 if self.settings.frictionless else friction,
            )
        return self.ground

    def remove(self, body: Body) -> None:
        """Take a body, with its joints, or a joint out of the world.

        Handles of others stay theirs; views of arrays, as of positions, do not.
        """
        if not isinstance(body, Body) or body.world is not self:
            raise ParameterError(f"{shown(body)} is no body of this world; give a handle of one, as of world.boxes")
        with self._my_turn():
            row, kind, cache = body._row(), body.kind.split()[0], remembered(self.contacts)
            stay = joints_that_stay(self._parts, kind, row)

            def then(of: str, number: int) -> int:
                """Return the number that one of a kind has afterwards."""
                if of == "joint":
                    return int(stay[:number].sum()) if stay[number] else GONE
                return number if of != kind or number < row else number - 1 if number > row else GONE

            names = self._names.renumbered(then)
            parts = without(self._parts, kind, row)
            bodies = _Bodies(parts, names, Sleepers(parts, not_rested(parts.model)), self._bodies.is_fresh)
            contacts = remembering(without_box(cache, row) if kind == "box" else cache, FIRST_ROOM)
            held = [each for each in self._handles.values() if each.is_there]
            moved = [(each, "_index", then(*each._who())) for each in held]
            set_together((self, "_bodies", bodies), (self, "contacts", contacts), *moved)

    def _properties(self, kind: str, given: dict[str, Any]) -> dict[str, Any]:
        """Return the properties of a new body of a kind, checked."""
        properties = properties_of(kind, given)
        return properties | ({f"{kind}_friction": 0.0} if self.settings.frictionless else {})

    def step(
        self, time_step: float, steps: int = 1, *, substeps: int | None = None, allow_unstable: bool = False
    ) -> None:
        """Advance by `steps` steps of `time_step` [s]; soft bodies take each in `substeps` equal parts.

        None: as many as the world says. Raises ParameterError for a step that is too long to be stable, unless told to
        allow it, and SimulationError if a body diverges or a soft one collapses; the state is then that of the last
        good step. An interrupt is heard in the step that it comes in, which then has not happened, or after it: state,
        `steps` and `time` belong together.
        """
        h = check_range(time_step, "time_step", "s", above=0.0)
        steps = check_whole(steps, "steps", 0)
        substeps = self.substeps if substeps is None else check_whole(substeps, "substeps", 1)
        if steps * substeps > 2**62:
            raise ParameterError(f"steps × substeps is {steps * substeps}; give fewer, up to 2**62")
        allow_unstable = check_yes_or_no(allow_unstable, "allow_unstable")
        with self._my_turn():
            self._step(h, steps, substeps, allow_unstable)

    def _step(self, h: float, steps: int, substeps: int, allow_unstable: bool) -> None:
        """Do what `step` says, with arguments that are checked."""
        settings = self.settings if substeps == self.settings.substeps else self.settings._replace(substeps=substeps)
        model, controls, state, _, joints = self._parts
        begun, first = (self.steps, self.time), int(steps > 0 and self._bodies.is_fresh)
        is_known = allow_unstable or self._stable_step.allows(h, model, controls, settings, joints, begun[0])
        fault, body = UNSEEN, -1
        if is_known and steps > first == 0:
            fault, body = self._run(h, steps, settings, begun, is_seen=False)
        if fault == UNSEEN:
            check_finite(model, controls, state, joints)
            if not allow_unstable:
                self._stable_step.check(h, model, controls, state, settings, joints, begun[0])
            fault, body = self._first_step(h, settings, begun) if first else (0, -1)
            if not fault:
                fault, body = self._run(h, steps - first, settings, begun, is_seen=True)
        self._time_step = h
        if fault:
            self._bodies.ground_impulse[:] = 0.0
            check_finite(model, controls, state, joints)  # a target that was written over
            if body >= model.soft_count and self.steps == begun[0]:
                check_pace(model, state, h, body - model.soft_count)
            advice = helpful_step(model, controls, state, settings, joints, body)
            raise fault_of(fault, body, model, h / substeps, advice, self.steps, self._names)
        if model.box_count and self._bodies.may_carry_too_much(model):
            warn_of_mass_ratios(model, controls, self.contacts, self._names)

    def _first_step(self, time_step: float, settings: Settings, begun: tuple[int, float]) -> tuple[int, int]:
        """Do the first step after bodies were added, and warn of those that overlap; return (fault, body)."""
        if not self._may_collide():
            self._bodies.is_fresh = False
            return self._run(time_step, 1, settings, begun, is_seen=True)
        surfaces = self._touching()
        if surfaces is not None:
            surfaces.deepest[0] = 0.0
        stopped = self._run(time_step, 1, settings, begun, is_seen=True)
        self._bodies.is_fresh = False
        if surfaces is not None:
            warn_of_overlap(self.model, surfaces, self._names)
        return stopped

    def _run(
        self, time_step: float, steps: int, settings: Settings, begun: tuple[int, float], is_seen: bool
    ) -> tuple[int, int]:
        """Do the steps of a call that had `begun` at such a step and time, and count them; return (fault, body).

        Unless what they begin with `is_seen` to be good, that is looked at first; see `run_by_clock`.
        """
        model, _, state, *_ = self._parts
        work = steps * settings.substeps * (len(state.particle_position) + 10 * model.box_count)
        how = self.steps + steps, time_step, settings, begun, is_seen
        if self._threads > 1:
            with team_of(self._threads), listening() as bell:
                return self._run_in_turns(*how, bell)
        if work < WORTH_LISTENING:
            return self._run_until(*how, SILENT)
        with listening() as bell:
            return self._run_until(*how, bell)

    def _run_in_turns(
        self, end: int, time_step: float, settings: Settings, begun: tuple[int, float], is_seen: bool, bell: Bell
    ) -> tuple[int, int]:
        """Do what `_run_until` does, on all threads or on one, as is faster."""
        team = self._bodies.team = self._bodies.team or Team(self._threads)
        while (left := end - self.steps) > 0:
            before = self.steps
            numba.set_num_threads(team.now)
            fault, body = self._run_until(before + team.turn(left), time_step, settings, begun, is_seen, bell)
            if fault:
                return fault, body
            team.note(self.steps - before)
            is_seen = True
        return 0, -1

    def _run_until(
        self, end: int, time_step: float, settings: Settings, begun: tuple[int, float], is_seen: bool, bell: Bell
    ) -> tuple[int, int]:
        """Run kernels until the clock shows as many steps; each run is over when the bell is struck.

        That is in the midst of a step, once: then one is always done, so that the world goes on however often it rings.
        """
        (model, controls, state, *_), clock, hasty = self._parts, self._clock, True
        collides = self._may_collide()
        if self._may_sleep():
            model = self._bodies.sleepers.model_of(model)
        while (left := end - self.steps) > 0:
            bell.still()
            how, before = (settings, time_step, left, clock, begun, is_seen, hasty), self.steps
            if collides:
                fault, body = run_by_clock(model, controls, state, self._work(bell), self.contacts, *how)
            else:
                given = self._bodies.ground_impulse
                fault, body = run_alone_by_clock(model, controls, state, self._moving(bell), *how, given)
            if fault == NO_ROOM:
                self.contacts = remembering(remembered(self.contacts), body)
            elif fault:
                return fault, body
            is_seen, hasty = True, hasty and self.steps > before
        return 0, -1

    def _may_collide(self) -> bool:
        """Tell whether there is more than one soft body and, perhaps, the ground."""
        is_more = self.model.box_count > 0 or self.model.soft_count > 1 or len(self._parts.joints.joint_box) > 0
        return is_more or self._may_sleep()

    def _may_sleep(self) -> bool:
        return self.settings.sleep_speed > 0.0

    def _work(self, bell: Bell) -> Work:
        """Return what a step needs, with nothing for a kind of bodies that there is none of."""
        motion = self._moving(bell) if self.model.soft_count else None
        bodies, has_boxes = self._bodies, self.model.box_count > 0
        if bodies.start is None:
            bodies.start = self.state.copy()
            bodies.grounded = np.zeros(self.model.box_count, bool) if has_boxes else None
            bodies.acting = joint_memory(self.state, self.controls) if len(self._parts.joints.joint_box) else None
        manifold = self._manifold if has_boxes else None
        joints = self._parts.joints if bodies.acting is not None else None
        return Work(
            motion,
            self._touching(),
            manifold,
            bodies.start,
            bodies.grounded,
            bodies.ground_impulse,
            joints,
            bodies.acting,
            bodies.sleepers.rest if self._may_sleep() else None,
            bell.struck,
        )

    def _moving(self, bell: Bell) -> Motion:
        """Return what moves soft bodies; its memory is kept until bodies are added or threads change."""
        bodies, (model, controls, _, rings, _) = self._bodies, self._parts
        motion = bodies.motion
        if motion is None or motion.rings is not rings:
            memory = motion.memory if motion else motion_of(model.soft_particle_start, rings, self.threads).memory
            if self._may_sleep():
                memory = memory._replace(asleep=bodies.sleepers.rest.asleep[: model.soft_count])
            motion = bodies.motion = Motion(rings, memory, None if self.threads == 1 else self.threads)
        if not (bodies.limits_of[0] is model and bodies.limits_of[1] == controls.soft_gas.tobytes()):
            motion.memory.most_extent[:] = most_extents(model, controls)
            bodies.limits_of = model, controls.soft_gas.tobytes()
        if bell is SILENT:
            return motion
        return motion._replace(memory=motion.memory._replace(stop=bell.struck))

    def _touching(self) -> Surfaces | None:
        """Return what finds the contacts of soft bodies, if any; it is kept until one is added or threads change."""
        bodies = self._bodies
        if bodies.surfaces is None and self.model.soft_count:
            bodies.surfaces = build_surfaces(self.model, self.state.particle_position, self.threads)
        return bodies.surfaces

    def run(
        self,
        seconds: float,
        time_step: float | None = None,
        *,
        substeps: int | None = None,
        allow_unstable: bool = False,
    ) -> None:
        """Advance by `seconds` [s], in equal steps of at most `time_step` [s]; see `step`.

        They are of `time_step` itself where that goes into `seconds`. None: the world chooses, frame by frame, see
        `step_frame`.
        """
        seconds = check_range(seconds, "seconds", "s", least=0.0)
        check_own_steps(time_step, substeps, allow_unstable)
        if time_step is None:
            for _ in self.frames(seconds):
                pass
            return
        time_step = check_range(time_step, "time_step", "s", above=0.0)
        check_range(seconds / time_step, "seconds / time_step", most=2.0**62)
        steps, h = whole_steps(seconds, time_step)
        self.step(h, steps, substeps=substeps, allow_unstable=allow_unstable)

    def step_frame(self, seconds: float = 1.0 / 60.0, time_step: float | None = None) -> int:
        """Advance by the time of a frame [s], however short or long; return how many steps that took.

        The world chooses equal steps that end with the frame: 0.8 of the stable one, and with boxes 1/240 s, or
        shorter. With a `time_step` [s] of your own, steps are of that length, and what is left of a frame is kept for
        the next: so over many frames no time is lost, and results do not depend on how long each was.
        """
        seconds = check_range(seconds, "seconds", "s", least=0.0)
        if time_step is not None:
            time_step = check_range(time_step, "time_step", "s", above=0.0)
            check_range(seconds / time_step, "seconds / time_step", most=2.0**53)
            count = self._remainder.steps(seconds, time_step)
            self.step(time_step, count)
            return count
        longest = min(OF_STABLE * self.stable_time_step(), BOX_STEP if self.model.box_count else np.inf)
        check_range(seconds / longest, "seconds / stable_time_step", most=2.0**53)
        count = max(1, ceil(seconds / longest)) if seconds > 0.0 else 0
        if count:
            self.step(seconds / count, count)
        return count

    def frames(self, seconds: float, per_second: float = 60.0, time_step: float | None = None) -> Iterator[int]:
        """Advance by `seconds` [s] frame by frame, and yield the number of each, from 0 on, when it is done.

        What is left when frames do not go into `seconds` is a last, shorter one. See `step_frame`.
        """
        seconds = check_range(seconds, "seconds", "s", least=0.0)
        frame = 1.0 / check_range(per_second, "per_second", "1/s", above=0.0)
        check_range(seconds / frame, "seconds × per_second", most=2.0**53)
        count, even = whole_steps(seconds, frame)
        for number in range(count):
            self.step_frame(frame if even == frame or number < count - 1 else seconds - (count - 1) * frame, time_step)
            yield number

    def stable_time_step(self) -> float:
        """Return a time step [s] that is stable for every soft body as it is now, and joints; inf if there is none.

        From an upper bound of the highest frequency, so often a little shorter than need be. Contacts and motion
        that stretches the body further can ask for a shorter one. It is `substeps` times that of a part, but for
        joints, which act once a step. Raises ParameterError where no step is stable.
        """
        model, controls, state, _, joints = self._parts
        of_joints = longest_step_of_joints(model, joints)
        return min(self.substeps * stable_time_step(model, controls, state, self.settings, of_joints), of_joints)

    def equilibrium(self, tolerance: float = 1e-12, steps: int = 200_000) -> None:
        """Move every soft body to its shape at rest, where it hangs on its fixed particles, or floats without weight.

        The acceleration left of any particle, times the least mass of one, is at most `tolerance` times the body's
        stiffness and size, in each component. Velocities become zero; boxes, the ground and contacts play no part.
        Raises SimulationError after `steps` steps.
        """
        tolerance, steps = check_range(tolerance, "tolerance", above=0.0), check_whole(steps, "steps", 1)
        with self._my_turn():
            self._relax(tolerance, steps)

    def _relax(self, tolerance: float, steps: int) -> None:
        """Do what `equilibrium` says, with arguments that are checked."""
        positions = self.state.particle_position.copy()
        for body in range(self.model.soft_count):
            shape, left = shape_at_rest(self._parts, body, tolerance, steps)
            if not left <= 1.0:
                title = self._names.title(("soft", body))
                raise SimulationError(
                    f"{title} is not at rest after {steps} steps: a force of {left:.3g} × the tolerance is left; allow "
                    "more steps, or see that external forces cancel or fixed particles hold them",
                    self.steps,
                    f"soft body {body}",
                    self.stable_time_step(),
                )
            positions[slice(*self.model.soft_particle_start[body : body + 2])] = shape
        assign_together((self.state.particle_position, positions), (self.state.particle_velocity, 0.0))

    def snapshot(self) -> Snapshot:
        """Return all that the coming steps depend on, as named arrays that share no memory with the world.

        A world that is restored from it goes on to the same bits.
        """
        self._my_turn()
        rested = self._bodies.sleepers.rested(self._parts)
        what = self.model, self.controls, self.state, self._parts.joints, self._names, rested
        kept = remembered(self.contacts), self.settings, self.precision, self.steps, self.time
        return snapshot_of(Snapped(*what, *kept))

    def restore(self, snapshot: Snapshot) -> None:
        """Become what a world was when it gave this snapshot; handles of bodies go by number, names come along.

        It may come from anywhere: everything in it is checked first, and what follows from it is made anew. That takes
        some 3 µs a particle, 0.7 where bodies share a mesh. Raises SnapshotError, which names the entry, and then
        changes nothing. An interrupt comes before it, or after.
        """
        with self._my_turn():
            model, controls, state, joints, names, rested, cache, settings, precision, steps, time = checked(snapshot)
            parts = Parts(model, controls, state, rings_of(model, PRECISIONS[precision]), joints)
            set_together(
                (self, "_bodies", _Bodies(parts, names, Sleepers(parts, rested), is_fresh=False)),
                (self, "contacts", remembering(cache, FIRST_ROOM)),
                (self, "settings", settings),
                (self, "_precision", precision),
                (self, "_clock", _new_clock(steps, time)),
                (self, "_stable_step", StableStep()),
                (self, "_remainder", Remainder()),
            )

    def state_hash(self) -> str:
        """Return a SHA-256, in hexadecimal, of where the bodies are and how they move, to the last bit."""
        return digest(named_arrays("state", self.state))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a snapshot to an NPZ file, whole or not at all, flushed to the disk.

        Until it is whole, what stood at `path` stays. Raises SnapshotError, and writes nothing, for a world that could
        not be read again, such as one with a position that is not finite.
        """
        snapshot = self.snapshot()
        checked(snapshot)
        write(path, snapshot)

    @classmethod
    def load(cls, path: str | os.PathLike[str], most_bytes: int = MOST_BYTES) -> World:
        """Return the world of a file that `save` wrote, or somebody else: it need not be trusted.

        Raises SnapshotError for another kind of file, damage of any kind, numbers out of range, and a file that is, or
        unpacks to, more than `most_bytes` (1 GiB), before it takes that memory; the world made of it takes a few times
        as much. OSError if there is none to read.
        """
        check_whole(most_bytes, "most_bytes", 1)
        snapshot = read(path, int(most_bytes))
        world = cls()
        try:
            world.restore(snapshot)
        except SnapshotError as error:
            raise SnapshotError(f"{path}: {error}") from error
        return world

    def __getstate__(self) -> Snapshot:
        """Pickle as a snapshot. Unpickle only what you trust: any pickle may run code, before this class is asked."""
        return self.snapshot()

    def __setstate__(self, snapshot: Snapshot) -> None:
        """Unpickle, checked as by `restore`, to go on to the same bits."""
        World.__init__(self)
        self.restore(snapshot)

    def picture(
        self,
        path: str | os.PathLike[str] | None = None,
        *,
        camera: Camera | None = None,
        size: tuple[int, int] = (640, 480),
        colour: str = "stripes",
        colour_range: tuple[float, float] | None = None,
        colour_map: str = "viridis",
        show_joints: bool = True,
    ) -> np.ndarray:
        """Return a picture (h, w, 3) of uint8 of the world as it is; write it to a PNG file, if there is a `path`.

        `camera`: a softbody.Camera, or none for one that frames the whole scene. `size` (width, height) [pixels].
        `colour`: "stripes", "plain", or by a quantity of soft bodies, "pressure" [Pa], "strain" or "speed" [m/s], from
        the least to the greatest of `colour_range`, or of the picture if it is None; `colour_map`: "viridis" or
        "coolwarm". `show_joints`: as lines between their ends. Raises OutputError, before any work, for a file that
        cannot be written.
        """
        from softbody.render.drawing import Drawing
        from softbody.render.recorder import picture

        with self._my_turn():
            return picture(self, path, camera, size, Drawing(self, colour, colour_range, colour_map, show_joints))

    def export(self, path: str | os.PathLike[str]) -> None:
        """Write all bodies, as they are, to a PLY, OBJ, GLB or USD file, whole or not at all, for other programs.

        Needs trimesh: pip install softbody[files]; for .usd, .usda and .usdc OpenUSD: pip install softbody[usd]. Soft
        bodies come first, then boxes of 8 corners and 12 triangles, in their places; the ground is left out. PLY is one
        mesh, positions rounded to single precision; OBJ has an object for each body, positions to 1e-17 m. GLB and USD
        have a node for each, boxes with their pose, in the colours of pictures, positions in single precision; in GLB
        under one that puts y up, as glTF has it: (x, y, z) is (x, z, −y) there; USD says that z is up. Bodies are
        called by their names, and `soft_body_0` …, `box_0` … where they have none. Raises OutputError,
        MissingPackageError, and ParameterError for positions that are not finite.
        """
        from softbody.export import export_moment, looks_of

        with self._my_turn():
            export_moment(path, shapes_of(self.model), looks_of(labels_of(self)), pose_of(self.state))

    def view(self, port: int = 8080, *, host: str = "127.0.0.1", open_browser: bool = True) -> None:
        """Show the world live in the browser, to be watched and steered, until Ctrl-C; it moves on meanwhile.

        Needs viser: pip install softbody[view]. The page is at `port` of `host` (0: any port that is free), which only
        this machine sees; `open_browser` opens it, where there is a display. Raises MissingPackageError, and ViewError
        for a port that is taken.
        """
        from softbody.view.serving import view

        view(self, port, host, open_browser)

    def energy(self) -> float:
        """Return kinetic + spring + gas + gravity energy [J] of every body that can move, less the work of forces.

        The springs of joints count.

        That is, Σ f·x of the forces on particles; forces on boxes are not in it.
        """
        return total_energy(self.model, self.controls, self.state) + joint_energy(self._parts.joints, self.state)

    def energies(self) -> Energies:
        """Return the energy [J] of every body that can move, by kind: kinetic, spring, gas, gravity, external.

        Of gas it is what it gives when it expands from here to its mesh's volume as it was added (less than 0 if it is
        larger): −nRT ln(V / V0). Only differences of the last three mean something, and `total` is the sum.
        """
        model, controls = self.model, self.controls
        spring, gas, gravity, external = potential_energies(model, controls, self.state)
        filled = controls.soft_gas > 0.0
        gas += float((controls.soft_gas[filled] * np.log(model.soft_mesh_volume[filled])).sum())
        spring += joint_energy(self._parts.joints, self.state)
        return Energies(kinetic_energy(model, self.state), spring, gas, gravity, external)

    def contact_points(self) -> ContactPoints:
        """Return what touched what in the last step, where and how hard, as arrays: see `ContactPoints`.

        Two calls tell what began and ended: `now.pairs() - before.pairs()`. Of what sleeps, they are those that it
        would have in a step if it were awake.
        """
        given = self._bodies.ground_impulse
        found = contact_points(self.model, self.state.particle_position, self.contacts, given, self._time_step)
        asleep = self._bodies.sleepers.rest.asleep
        if not (self._may_sleep() and asleep.any() and self._time_step > 0.0):  # 0: no step since it was restored
            return found
        return found.and_of(asleep, self._contacts_if_awake())

    def _contacts_if_awake(self) -> ContactPoints:
        """Return the contacts of the next step if nobody slept in it."""
        sleepers = self._bodies.sleepers
        found, key = sleepers.contacts_if_awake, sleepers.key(self._time_step)
        if found is None or found[0] != key:
            snapshot = self.snapshot()
            snapshot["rest.time"][:], snapshot["rest.asleep"][:] = 0.0, 0
            twin = World(threads=self.threads)
            twin.restore(snapshot)
            twin.step(self._time_step, allow_unstable=True)
            found = sleepers.contacts_if_awake = key, twin.contact_points()
        return found[1]

    def linear_momentum(self) -> np.ndarray:
        """Return Σ m v (3,) [kg m/s]."""
        return np.array(linear_momentum(self.model, self.state))

    def angular_momentum(self) -> np.ndarray:
        """Return Σ x × m v + Σ I ω (3,) [kg m²/s] about the origin."""
        return np.array(angular_momentum(self.model, self.state))


def world_to_fill(world: World | None) -> World:
    """Return a world that a scene is to be built in: the one given, or a new one; raises ParameterError."""
    if not isinstance(world, (World, type(None))):
        raise ParameterError(f"world is {shown(world)}; give a softbody.World, or none for a new one")
    return World() if world is None else world
