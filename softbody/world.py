"""A world to fill with bodies, step, and look at."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from softbody.bodies import adding
from softbody.bodies.body import Body
from softbody.bodies.builder import empty_parts
from softbody.bodies.contact_points import ContactPoints
from softbody.bodies.ground import Ground
from softbody.bodies.inventory import Inventory
from softbody.bodies.joining import join_bodies
from softbody.bodies.joint import End, Joint
from softbody.bodies.liquid import Liquid
from softbody.bodies.names import Names
from softbody.bodies.rigid_box import Box
from softbody.bodies.soft_body import Event, SoftBody
from softbody.bodies.store import FIRST_ROOM, Contents, Store
from softbody.bodies.strict_names import strict_options
from softbody.bodies.suspended import Suspended
from softbody.collision.contact import new_contacts
from softbody.errors import SnapshotError
from softbody.mesh.mesh import Mesh
from softbody.model.settings import (
    PAPER,
    PRECISIONS,
    Choices,
    check_name,
    integrator_name,
    settings_of,
    with_integrator,
)
from softbody.model.shapes import Cast, pose_of, shapes_of
from softbody.model.validation import check_whole, vector
from softbody.stepping import frames as in_frames
from softbody.stepping.runner import Runner
from softbody.stepping.shape_at_rest import equilibrium
from softbody.storage.npz import MOST_BYTES, read, write
from softbody.storage.restore import restore, snapshot_of_store
from softbody.storage.snapshot import checked, digest, named_arrays
from softbody.storage.snapshot_entries import Snapshot

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from softbody.render.camera import Camera


class Options(Choices, total=False):
    """The arguments of a World."""

    gravity: ArrayLike
    precision: str
    threads: int


class World(Inventory):
    """Soft bodies, rigid boxes, a ground and a liquid that move together.

    Bodies may be added at any time. Every input is checked before it is stored: ParameterError and MeshError name the
    culprit and the cure. All but `gravity` are keywords; those of the paper are in `World.paper()`.

    - `gravity` (3,) [m/s²].
    - `precision` in which soft bodies move between contacts: "double", or "single", which is faster and rounds their
      positions to 6e-8 of the distance from the origin. Everything else is double in both.
    - `threads` that move soft bodies and find and resolve their contacts, with the same bits. Where one alone is faster
      just now, it is one. Worlds that are stepped at the same time by threads of their own need 1.
    - `integrator` of soft bodies: "symplectic_euler"; "rk4", four times the work and far more exact; "rk4_velocity",
      the paper's, as much work and a damping that grows with the step.
    - `substeps`: in how many equal parts soft bodies take each step, while contacts are found and resolved once. Steps
      may be so many times as long, and worlds of many contacts cost half as much with 2, a third with 4.
    - `axes` of the separating-axis test of boxes: "complete", or "paper" for face normals only.
    - `contact` of boxes: "manifold", all points solved together; or "single", the paper's one impulse a pair, half-way
      between the two where one lies on the other.
    - `iterations`: sweeps of the contact solver a step; up to four times as many while they converge fast.
    - `soft_contact`, contacts of soft bodies: "together", within the step; or "single", as in the paper, one after the
      other, half of the overlap to each side, at the end of the step.
    - `pairs` to test: those near in a "grid"; or "exhaustive", as in the paper, which tries the normals of all faces of
      two soft bodies, too, before it looks closer, with the same result.
    - `edge_contacts`: edges hold edges, of boxes and of soft bodies. False: only particles and corners are held, as in
      the paper.
    - `split_steps`: a step is taken in parts where a soft body and another would jump through each other, where a load
      presses them together by a quarter of an edge, or where gravity moves boxes by more than a sixteenth of the
      thickness of the thinnest.
    - `gyroscopic` torque, so that a free box keeps its angular momentum.
    - `speed_ceiling` [m/s] and `angular_speed_ceiling` [rad/s] of boxes.
    - `angular_speed_floor` [rad/s]: a box on the ground that turns more slowly stops turning, and snaps to the nearest
      multiples of 90°.
    - `frictionless`: whatever is added has friction 0.
    - `self_contact`: soft bodies that are added have `self_contact`, unless they are told otherwise.
    - `sleep_speed` [m/s] and `sleep_after` [s]: bodies fall asleep, so that steps cost nothing for them, that have been
      slower for so long with all that they touch or are joined to; 0: none does. They wake when something comes near,
      or something of them or that acts on them changes. Speed is the root mean square over their mass.
    """

    __slots__ = ("runner",)

    def __init__(
        self,
        gravity: ArrayLike = (0.0, 0.0, -9.81),
        *,
        precision: str = "double",
        threads: int = 1,
        integrator: str = "symplectic_euler",
        substeps: int = 1,
        axes: str = "complete",
        contact: str = "manifold",
        iterations: int = 30,
        soft_contact: str = "together",
        pairs: str = "grid",
        edge_contacts: bool = True,
        split_steps: bool = True,
        gyroscopic: bool = False,
        speed_ceiling: float = inf,
        angular_speed_ceiling: float = inf,
        angular_speed_floor: float = 0.0,
        frictionless: bool = False,
        self_contact: bool = False,
        sleep_speed: float = 0.0,
        sleep_after: float = 0.5,
    ) -> None:
        choices: Choices = {"integrator": integrator, "substeps": substeps, "axes": axes, "contact": contact}
        choices |= {
            "iterations": iterations,
            "soft_contact": soft_contact,
            "pairs": pairs,
            "frictionless": frictionless,
            "self_contact": self_contact,
        }
        choices |= {"edge_contacts": edge_contacts, "split_steps": split_steps, "gyroscopic": gyroscopic}
        choices |= {"speed_ceiling": speed_ceiling, "angular_speed_ceiling": angular_speed_ceiling}
        choices |= {"angular_speed_floor": angular_speed_floor, "sleep_speed": sleep_speed, "sleep_after": sleep_after}
        check_name(precision, "precision", tuple(PRECISIONS))
        contents = Contents(empty_parts(vector(gravity, "gravity"), PRECISIONS[precision]), Names())
        self.store = Store(contents, new_contacts(FIRST_ROOM), settings_of(choices), precision)
        self.runner = Runner(self.store, threads)

    @classmethod
    def paper(cls, **changes: Unpack[Options]) -> World:
        """Return a world that does as the paper does in all that it chose; `changes` are other arguments of a World."""
        options: Options = {**PAPER, **changes}
        return cls(**options)

    def __repr__(self) -> str:
        """Say what is in the world, and how far it is."""
        model = self.model
        what = [f"{model.soft_count} soft bodies of {len(self.state.particle_position)} particles"]
        what += [f"{model.box_count} boxes"]
        what += [f"ground at {model.ground_height:.4g} m"] if model.ground_height > -np.inf else []
        what += [f"liquid up to {model.liquid_surface_height:.4g} m"] if model.liquid_density > 0.0 else []
        return f"<World: {', '.join(what)}; {self.steps} steps, {self.time:.6g} s>"

    @property
    def integrator(self) -> str:
        """How soft bodies move: "symplectic_euler", "rk4" or "rk4_velocity"; may be changed between steps.

        Bodies that there are keep their damping.
        """
        return integrator_name(self.store.settings)

    @integrator.setter
    def integrator(self, value: str) -> None:
        self.store.settings = with_integrator(self.store.settings, value)

    @property
    def substeps(self) -> int:
        """In how many equal parts soft bodies take each step, with contacts once a step; may be changed between steps.

        `stable_time_step` is as many times as long, and so are the steps that the world chooses.
        """
        return self.store.settings.substeps

    @substeps.setter
    def substeps(self, value: int) -> None:
        self.store.settings = self.store.settings._replace(substeps=settings_of({"substeps": value}).substeps)

    @property
    def precision(self) -> str:
        """In which soft bodies move between contacts: "double" or "single"."""
        return self.store.precision

    @property
    def threads(self) -> int:
        """Threads that move soft bodies and find their contacts; may be changed, and is no part of a snapshot."""
        return self.runner.threads

    @threads.setter
    def threads(self, value: int) -> None:
        self.runner.threads = value

    @strict_options
    def add_soft_body(
        self,
        mesh: Mesh,
        mass: float,
        stiffness: ArrayLike,
        gas: float | None = None,
        position: ArrayLike = (0.0, 0.0, 0.0),
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        *,
        pressure: float | None = None,
        rest_length: ArrayLike | None = None,
        tear_at: ArrayLike = 0.0,
        fixed: ArrayLike = (),
        name: str | None = None,
        damping: float | None = None,
        drag: float = 0.0,
        restitution: float = 0.0,
        friction: float = 0.5,
        deflated_below: float = 0.0,
        self_contact: bool | float | None = None,
        leak: float = 200.0,
        liquid_density: float = 0.0,
        sound_speed: float = 0.0,
        liquid_drag: float = 0.0,
    ) -> SoftBody:
        """Add a soft body whose springs are at rest in the shape of `mesh`, moved by `position` [m].

        `mass` [kg] of the body, shared equally by its particles. `stiffness` [N/m] of every spring, or
        (e,) in the order of `mesh.edges`. Give either `gas`, nRT [J] ≥ 0, or `pressure` [Pa] ≥ 0 above that outside,
        which the gas has in the volume of the mesh; 0 for an empty body. `rest_length` [m] of every spring, or (e,), if
        not as in the mesh. `damping` [N s/m] of the springs, against the speed at which their ends part.
        None: a tenth of what is critical for two particles on a spring, 0.1 √(2 k m), with k the mean stiffness and m
        the mass of a particle; or 0 in a world whose integrator is "rk4_velocity", which damps by itself.
        `fixed`: indices of vertices that stay in place. `name`, by which the world finds it, `world[name]`: a text that
        nothing else in the world is called.

        `tear_at`: length / rest length beyond which a spring tears the surface, > 1, of every spring, or (e,); 0: it
        never does. For a force of F [N] it is 1 + F / (stiffness × rest length). After each step the springs that are
        farthest beyond tear: the particle at an end splits, across the spring. Springs along a split are two, half as
        stiff. The gas flows out through the hole, by `leak` [m/s] (200): dn/dt = −leak × area × n / volume; 0 keeps
        it. What falls off is a body of its own, "ball.1"; `events` tells. A torn body holds particles and edges against
        boxes, the ground and whole bodies, and is held by none from within: others go into it through holes.

        `restitution` 0 … 1 and `friction` ≥ 0 are those in contacts; `drag` [1/s], the rate
        at which all velocities fade. The body counts as collapsed, which ends a run with a SimulationError, at the
        fraction `deflated_below` of the mesh's volume (0: at none left). With `self_contact` its surface keeps a
        distance from itself: True, as far as the mesh allows; or a smaller number [m]; False or 0: it goes through
        itself; None: as the world says. Without gas it may then lie flat. A surface that meets itself holds itself once
        it has parted.

        `liquid_density` [kg/m³] of a liquid that fills it, with or without gas. `mass` is then that of the skin alone;
        the liquid has density × the mesh's volume, shared by the particles, too. It presses by its depth, so that the
        body sags, as a water bag does; sloshing is left out. `sound_speed` [m/s] says how hard it is to press together:
        by p / (ρ c²). 0: as much as makes it give way by a hundredth or so under its own weight. `liquid_drag`
        [N s/m³] acts on boxes inside, by their surface and their speed against the liquid (0).
        """
        number = adding.add_soft_body(
            self.store,
            mesh,
            (mass, gas, pressure),
            (stiffness, rest_length, tear_at),
            (position, velocity),
            fixed,
            name,
            {
                "damping": damping,
                "drag": drag,
                "restitution": restitution,
                "friction": friction,
                "deflated_below": deflated_below,
                "self_contact": self_contact,
                "leak": leak,
                "liquid_density": liquid_density,
                "sound_speed": sound_speed,
                "liquid_drag": liquid_drag,
            },
        )
        return SoftBody(self, number)

    @strict_options
    def add_box(
        self,
        size: ArrayLike,
        mass: float | None,
        position: ArrayLike = (0.0, 0.0, 0.0),
        orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        angular_velocity: ArrayLike = (0.0, 0.0, 0.0),
        *,
        restitution: float = 0.0,
        friction: float = 0.5,
        inside: SoftBody | None = None,
        name: str | None = None,
    ) -> Box:
        """Add a homogeneous box of full extent `size` (3,) [m] and `mass` [kg].

        None makes it static, or kinematic: it moves by its velocities, pushes what it meets, and nothing changes that.

        `position` [m] of its centre, `orientation` a unit quaternion (w, x, y, z), `velocity` [m/s],
        `angular_velocity` [rad/s] in the world frame. `restitution` 0 … 1 and `friction` ≥ 0 are those
        in contacts. `name`, by which the world finds it, `world[name]`: one that nothing else in it has.

        `inside`: a soft body in which it is. The skin holds it there from within. A liquid that fills the body makes
        place for it, bears it up by ρ g V, and drags it by the body's `liquid_drag`; a gas has less room. It may be set
        later, too, as `box.inside`. Raises ParameterError for a box that does not fit in.
        """
        pose, motion = (position, orientation), (velocity, angular_velocity)
        properties = {"restitution": restitution, "friction": friction}
        return Box(self, adding.add_box(self.store, size, mass, pose, motion, inside, name, properties))

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
        a particle, `(body, 7)`; or the number of a point that hangs in a soft body, `(suspended, 0)`, see `suspend`.
        `stiffness` [N/m], `damping` [N s/m], `rest_length` [m]: of 0, a is pulled to b, and
        all their motion against each other damped; of more, it acts along the joint, both ways. `name`, by which the
        world finds it, `world[name]`: one that nothing else in it has.

        It is a force, constant within a step, for which a step can be too long: see `stable_time_step`. Bodies that
        are joined touch as others do.
        """
        numbers = {"stiffness": (stiffness, "N/m"), "damping": (damping, "N s/m"), "rest_length": (rest_length, "m")}
        return Joint(self, adding.add_joint(self.store, (a, b), numbers, name))

    def suspend(
        self,
        what: Box | ArrayLike,
        body: SoftBody,
        *,
        stiffness: float | None = None,
        damping: float | None = None,
        weights: str = "mean-value",
        name: str | None = None,
    ) -> Suspended:
        """Hang a box, or points (k, 3) [m], where they are now in a soft body; return the handle.

        A point is carried: it is where Σ w x of the body's particles is. Weights w, which sum to 1, are made once, from
        where all is now, so that motions that are affine carry points exactly. "mean-value" coordinates are smooth,
        whatever the shape (Ju, Schaefer and Warren 2005). "tetrahedron": of a triangle and the mean of all particles,
        as the paper's §7 would have it; in a ring that mean is outside, and points may be carried out of the ring where
        it bends.

        A box hangs by its eight corners, each pulled to its carried point by a joint of no length; the particles bear
        what pulls it, by their weights, so that both momenta are kept. It is inside the body, as by `add_box`, and
        stays so when the suspension is removed. `stiffness` [N/m] and `damping` [N s/m] of each joint: by default as
        firm as the step that is stable for the body allows, and damped critically; the step stable for both is √2 times
        shorter. `name`, by which the world finds it: one that nothing else in it has. To remove the box, the body or
        the suspension ends it.

        Raises ParameterError for what is not inside the body, and for a box that hangs already.
        """
        return Suspended(self, adding.suspend(self.store, what, body, stiffness, damping, weights, name))

    def add_ground(self, height: float = 0.0, restitution: float = 0.0, friction: float = 0.5) -> Ground:
        """Make everything below z = `height` [m] solid ground; return its handle. A second call sets all three anew.

        `restitution` 0 … 1 and `friction` ≥ 0 in contacts.
        """
        adding.add_ground(self.store, height, restitution, friction)
        return self.ground

    def add_liquid(
        self,
        density: float = 1000.0,
        surface_height: float = 0.0,
        *,
        drag: float = 0.0,
        velocity: ArrayLike = (0.0, 0.0, 0.0),
    ) -> Liquid:
        """Let a liquid of `density` [kg/m³] fill all below z = `surface_height` [m]; return its handle.

        Bodies float in it, sink, tilt and bob, by its pressure on their wet surface, which is cut at the liquid's
        exactly. `drag` [N s/m³] is a force against the liquid's speed, by speed and wet area: with none, what bobs
        does so for ever. `velocity` (3,) [m/s] with which it flows: drag carries bodies along. A second call sets all
        four anew. Its surface stays level, whatever falls in: waves, and the mass of liquid that moves along with a
        body, are left out. Above it there is nothing: `gas` has the pressure that holds a body against the liquid.

        Pressure and drag are constant within a step, for which a step can be too long: see `stable_time_step`. Raises
        ParameterError for numbers out of range, and where gravity does not point straight down.
        """
        adding.add_liquid(self.store, density, surface_height, drag, velocity)
        return self.liquid

    def remove(self, body: Body) -> None:
        """Take a body, with its joints, or a joint out of the world.

        Handles of others stay theirs; views of arrays, as of positions, do not.
        """
        adding.remove(self.store, body)

    def join(
        self, a: SoftBody, b: SoftBody, where: ArrayLike | None = None, *, within: float | None = None
    ) -> SoftBody:
        """Make one soft body of two, and return it; both handles are of it from now on. It is called as `a`, or `b`.

        `where` (3,) [m]: a tube of six triangles joins the triangles of both that are nearest to that place. Or
        `within` [m]: particles of both that are nearer than that become one, where triangles lie on each other, which
        vanish. So the halves of a body that was cut are whole again.

        The gas of both is in it, and the mass; both momenta stay. Springs stay as they are, and new ones are at rest;
        where two become one it has the stiffness and the tension of both. Damping, friction and what else a body has
        one of are those of `a`. Joints stay nearest to where they are. Raises ParameterError, and changes nothing, for
        bodies that are too far apart, whose tube would go through them, or that are full of different liquids; and if
        something hangs in one.
        """
        join_bodies(self.store, a, b, where, within)
        place = a.centre if where is None else vector(where, "where")
        self.store.events.append(Event("join", self.time, place[None], (SoftBody(self, a.index),)))
        return a

    @property
    def events(self) -> tuple[Event, ...]:
        """What bodies tore, were cut or were joined, the latest 10 000; no snapshot has them: a restore ends them."""
        return tuple(
            replace(event, bodies=tuple(SoftBody(self, b.index) if b.is_there else b for b in event.bodies))
            for event in self.store.events
        )

    def step(
        self, time_step: float, steps: int = 1, *, substeps: int | None = None, allow_unstable: bool = False
    ) -> None:
        """Advance by `steps` steps of `time_step` [s]; soft bodies take each in `substeps` equal parts.

        None: as many as the world says. Raises ParameterError for a step that is too long to be stable, unless told to
        allow it, and SimulationError if a body diverges or a soft one collapses; the state is then that of the last
        good step. An interrupt is heard in the step that it comes in, which then has not happened, or after it: state,
        `steps` and `time` belong together.
        """
        self.runner.step(time_step, steps, substeps, allow_unstable)

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
        in_frames.run(self.runner, seconds, time_step, substeps, allow_unstable)

    def step_frame(self, seconds: float = 1.0 / 60.0, time_step: float | None = None) -> int:
        """Advance by the time of a frame [s], however short or long; return how many steps that took.

        The world chooses equal steps that end with the frame: 0.8 of the stable one, and with boxes 1/240 s, or
        shorter. With a `time_step` [s] of your own, steps are of that length, and what is left of a frame is kept for
        the next: so over many frames no time is lost, and results do not depend on how long each was.
        """
        return in_frames.step_frame(self.runner, seconds, time_step)

    def step_frame_contacts(self, seconds: float = 1.0 / 60.0) -> ContactPoints:
        """Advance by a frame as `step_frame` does, and return what touched in it: the contacts of all its steps.

        `force_on` of those is the mean over the frame: what one step says alone may chatter by half of it. Of a step
        that was taken in parts the last part counts, and a step in which a body tears tells no contacts. Raises
        ParameterError for a frame of no time.
        """
        return in_frames.step_frame_contacts(self.runner, seconds)

    def frames(self, seconds: float, per_second: float = 60.0, time_step: float | None = None) -> Iterator[int]:
        """Advance by `seconds` [s] frame by frame, and yield the number of each, from 0 on, when it is done.

        What is left when frames do not go into `seconds` is a last, shorter one. See `step_frame`.
        """
        return in_frames.frames(self.runner, seconds, per_second, time_step)

    def stable_time_step(self) -> float:
        """Return a time step [s] that is stable for every soft body as it is now, and joints; inf if there is none.

        From an upper bound of the highest frequency, so often a little shorter than need be. Contacts and motion
        that stretches the body further can ask for a shorter one. It is `substeps` times that of a part, but for
        joints, which act once a step. Raises ParameterError where no step is stable, or something is not finite.
        """
        return self.runner.stable_time_step()

    def equilibrium(self, tolerance: float = 1e-12, steps: int = 200_000) -> None:
        """Move every soft body to its shape at rest, where it hangs on its fixed particles, or floats without weight.

        The acceleration left of any particle, times the least mass of one, is at most `tolerance` times the body's
        stiffness and size, in each component. Velocities become zero; boxes, ground, liquid and contacts play no part.
        Raises SimulationError after `steps` steps.
        """
        equilibrium(self.runner, tolerance, steps)

    def snapshot(self) -> Snapshot:
        """Return all that the coming steps depend on, as named arrays that share no memory with the world.

        A world that is restored from it goes on to the same bits.
        """
        return snapshot_of_store(self.store)

    def restore(self, snapshot: Snapshot) -> None:
        """Become what a world was when it gave this snapshot; handles of bodies go by number, names come along.

        It may come from anywhere: everything in it is checked first, and what follows from it is made anew. That takes
        some 3 µs a particle, 0.7 where bodies share a mesh. Raises SnapshotError, which names the entry, and then
        changes nothing. An interrupt comes before it, or after.
        """
        restore(self.store, snapshot)
        self.store.events.clear()

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

        with self.store.exclusive():
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
        from softbody.export import export_moment

        with self.store.exclusive():
            export_moment(path, Cast(shapes_of(self.model), self.store.labels()), pose_of(self.state))

    def view(self, port: int = 8080, *, host: str = "127.0.0.1", open_browser: bool = True) -> None:
        """Show the world live in the browser, to be watched and steered, until Ctrl-C; it moves on meanwhile.

        Needs viser: pip install softbody[view]. The page is at `port` of `host` (0: any port that is free), which only
        this machine sees; `open_browser` opens it, where there is a display. Raises MissingPackageError, and ViewError
        for a port that is taken.
        """
        from softbody.view.serving import view

        view(self, port, host, open_browser)

    def contact_points(self) -> ContactPoints:
        """Return what touched what in the last step, where and how hard, as arrays: see `ContactPoints`.

        Two calls tell what began and ended: `now.pairs() - before.pairs()`. Of what sleeps, they are those that it
        would have in a step if it were awake.
        """
        return self.runner.contact_points()
