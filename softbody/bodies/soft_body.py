"""A soft body of a World: a handle, whose arrays are views of the world's."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from softbody.bodies.body import BodyProperty, SleepyBody, set_row
from softbody.bodies.builder import distance_of_skin, with_liquid_mass
from softbody.bodies.cutting import cut_body
from softbody.bodies.store import HasStore
from softbody.dynamics.filling import liquid_mass, liquid_pressure
from softbody.dynamics.pressure import gas_pressure, room_in, soft_volume
from softbody.dynamics.vertex_rings import with_springs
from softbody.errors import ParameterError
from softbody.model.arrays import is_open, mass_of
from softbody.model.properties import check_self_contact, checked_property, properties_of
from softbody.model.validation import (
    NO_NUMBERS,
    check_range,
    doubles,
    fixed_particles_of,
    rest_length_of,
    shown,
    stiffness_of,
    tear_at_of,
    vector,
)

ON_A_LINE = 1e-12  # least / greatest moment of inertia, below which a body has no spin about one axis


class SoftBody(SleepyBody):
    """A soft body in a World: what it is, where it is, and what of it may be set between steps."""

    __slots__ = ()

    kind = "soft body"

    def _count(self) -> int:
        return self.store.model.soft_count

    def _rows(self) -> slice:
        row = self.row()
        return slice(*self.store.model.soft_particle_start[row : row + 2])

    def _surface(self) -> tuple[np.ndarray, np.ndarray]:
        return self.positions, self.triangles

    def _edge_rows(self) -> slice:
        row = self.row()
        return slice(*self.store.model.soft_edge_start[row : row + 2])

    def __repr__(self) -> str:
        """Say which body it is, of how many particles, how heavy, and where."""
        if not self.is_there:
            return "<soft body that is gone>"
        where = ", ".join(f"{x:.4g}" for x in self.centre.round(6) + 0.0)
        return f"<{self._title()}: {len(self.positions)} particles, {self.mass:.4g} kg, at ({where}) m>"

    # What it is.

    @property
    def triangles(self) -> np.ndarray:
        """Triangles (t, 3), as rows of `positions`."""
        model, row = self.store.model, self.row()
        rows = slice(*model.soft_triangle_start[row : row + 2])
        return model.triangle_particles[rows] - model.soft_particle_start[row]

    @property
    def edges(self) -> np.ndarray:
        """Edges (e, 2) that the springs are on, as rows of `positions`."""
        return self.store.model.edge_particles[self._edge_rows()] - self._rows().start

    @property
    def mass(self) -> float:
        """Mass [kg], with that of a liquid in it."""
        return mass_of(self.store.model.particle_free_inverse_mass[self._rows()])

    @property
    def masses(self) -> np.ndarray:
        """Mass (n,) of each particle [kg], read-only: equal, but for bodies that were cut or joined."""
        return _read_only(1.0 / self.store.model.particle_free_inverse_mass[self._rows()])

    damping = BodyProperty()
    drag = BodyProperty()
    restitution = BodyProperty()
    friction = BodyProperty()
    deflated_below = BodyProperty()
    sound_speed = BodyProperty()
    liquid_drag = BodyProperty()
    leak = BodyProperty()

    @property
    def self_contact(self) -> float:
        """Distance [m] that its surface keeps from itself; 0: it goes through itself. May be set between steps.

        True: as far as its mesh allows, as it is now. False: 0. What meets itself holds itself once it has parted.
        """
        return abs(float(self.store.model.soft_self_contact[self.row()]))

    @self_contact.setter
    def self_contact(self, value: bool | float) -> None:
        with self.store.exclusive():
            value = properties_of("soft", {"self_contact": value})["soft_self_contact"]
            check_self_contact(self.store.settings, value)
            set_row(self, "soft_self_contact", distance_of_skin(self.store.parts, self.row(), value))
            self.store.clock.shape[0] ^= 1  # the next step is to look where particles are

    @property
    def gas(self) -> float:
        """The gas's nRT [J]; may be changed between steps."""
        return float(self.store.controls.soft_gas[self.row()])

    @gas.setter
    def gas(self, value: float) -> None:
        self.store.controls.soft_gas[self.row()] = check_range(value, "gas", "J", least=0.0)

    @property
    def liquid_density(self) -> float:
        """Density [kg/m³] of the liquid that fills it, in its mesh as it was added; 0: none. May be set between steps.

        Where boxes are inside there is no liquid.

        Its mass goes into the body, or out of it, with the body's velocity.
        """
        return float(self.store.model.soft_liquid_density[self.row()])

    @liquid_density.setter
    def liquid_density(self, value: float) -> None:
        value = checked_property("soft_liquid_density", value)
        with self.store.exclusive():
            model, row = self.store.model, self.row()
            density = model.soft_liquid_density.copy()
            density[row] = value
            after = model._replace(soft_liquid_density=density)
            self.store.replace(model=with_liquid_mass(after, row, liquid_mass(model, row)))

    @property
    def stiffness(self) -> np.ndarray:
        """Stiffness (e,) of the springs [N/m], read-only; `set_springs` changes it."""
        return _read_only(self.store.model.edge_stiffness[self._edge_rows()])

    @property
    def rest_length(self) -> np.ndarray:
        """Rest length (e,) of the springs [m], read-only; `set_springs` changes it."""
        return _read_only(self.store.model.edge_rest_length[self._edge_rows()])

    @property
    def tear_at(self) -> np.ndarray:
        """Length / rest length (e,) beyond which each spring tears, 0: never; read-only, `set_springs` changes it."""
        return _read_only(np.abs(self.store.model.edge_tear_at[self._edge_rows()]))

    @property
    def is_torn(self) -> bool:
        """Whether it has torn, so that its surface has holes."""
        return bool(is_open(self.store.model, self.row()))

    def set_springs(
        self,
        stiffness: ArrayLike | None = None,
        rest_length: ArrayLike | None = None,
        tear_at: ArrayLike | None = None,
    ) -> None:
        """Change `stiffness` [N/m], `rest_length` [m] or `tear_at` of all springs: one, or (e,); see add_soft_body."""
        with self.store.exclusive():
            model, rings, edges = self.store.model, self.store.rings, self._edge_rows()
            count = edges.stop - edges.start
            stiffnesses, lengths = model.edge_stiffness.copy(), model.edge_rest_length.copy()
            limits = model.edge_tear_at.copy()
            if stiffness is not None:
                stiffnesses[edges] = stiffness_of(stiffness, count)
            if rest_length is not None:
                lengths[edges] = rest_length_of(rest_length, count)
            if tear_at is not None:
                limits[edges] = tear_at_of(tear_at, count)
            self.store.replace(
                model=model._replace(edge_stiffness=stiffnesses, edge_rest_length=lengths, edge_tear_at=limits),
                rings=with_springs(rings, lengths, stiffnesses, model.soft_edge_start),
            )

    @property
    def fixed(self) -> np.ndarray:
        """Indices of the particles that stay in place; assign others, or none, to pin and to let go."""
        return np.flatnonzero(self.store.model.particle_inverse_mass[self._rows()] == 0.0)

    @fixed.setter
    def fixed(self, value: ArrayLike) -> None:
        self._pin(value)

    def _pin(self, value: ArrayLike) -> None:
        """Fix these particles, and let go of all others."""
        with self.store.exclusive():
            rows, model = self._rows(), self.store.model
            inverse_mass = model.particle_free_inverse_mass[rows].copy()
            still = fixed_particles_of(value, len(inverse_mass))
            inverse_mass[still] = 0.0
            self.velocities[still] = 0.0  # first: nothing that is fixed moves, be there an interrupt
            set_row(self, "particle_inverse_mass", inverse_mass, rows)

    # Where it is.

    @property
    def positions(self) -> np.ndarray:
        """Positions of the particles (n, 3) [m]; assign (n, 3) to put them elsewhere."""
        return self.store.state.particle_position[self._rows()]

    @positions.setter
    def positions(self, value: ArrayLike) -> None:
        self.positions[:] = _each(value, "positions", "m", self.positions.shape)

    @property
    def velocities(self) -> np.ndarray:
        """Velocities of the particles (n, 3) [m/s]; assign (n, 3), or (3,) for all. What is fixed stays at rest."""
        return self.store.state.particle_velocity[self._rows()]

    @velocities.setter
    def velocities(self, value: ArrayLike) -> None:
        velocity = _each(value, "velocities", "m/s", self.positions.shape)
        velocity[self.fixed] = 0.0
        self.velocities[:] = velocity

    @property
    def centre(self) -> np.ndarray:
        """Centre of mass (3,) [m]."""
        return self._mean(self.positions)

    @property
    def velocity(self) -> np.ndarray:
        """Velocity of the centre of mass (3,) [m/s]; assign another, and what is not fixed moves by that much more."""
        return self._mean(self.velocities)

    @velocity.setter
    def velocity(self, value: ArrayLike) -> None:
        self.velocities = self.velocities + (vector(value, "velocity") - self.velocity)

    @property
    def angular_velocity(self) -> np.ndarray:
        """Angular velocity (3,) [rad/s] of all of it about its centre: of a rigid body with its spin, in its shape.

        Assign another, and what is not fixed turns by that much more. Raises ParameterError for a body whose particles
        lie on a line.
        """
        arms = self.positions - self.centre
        return self._turn(self.masses @ np.cross(arms, self.velocities))

    @angular_velocity.setter
    def angular_velocity(self, value: ArrayLike) -> None:
        change = vector(value, "angular_velocity") - self.angular_velocity
        self.velocities = self.velocities + np.cross(change, self.positions - self.centre)

    def apply_impulse(self, impulse: ArrayLike, point: ArrayLike | None = None) -> None:
        """Strike it by `impulse` (3,) [N s] at `point` (3,) [m] of the world, or at the centre: velocities change now.

        As if it were rigid at this moment, in the shape that it has. What is fixed stays at rest. Raises
        ParameterError, with a point, for a body whose particles lie on a line.
        """
        self.velocities = self.velocities + self._as_if_rigid(vector(impulse, "impulse"), point)

    def _as_if_rigid(self, push: np.ndarray, point: ArrayLike | None) -> np.ndarray:
        """Return what a push (3,) at a point, by the mass, adds to each particle (n, 3) of a rigid body."""
        change = push / self.mass
        if point is None:
            return np.broadcast_to(change, self.positions.shape)
        turn = self._turn(np.cross(vector(point, "point") - self.centre, push))
        return np.asarray(change + np.cross(turn, self.positions - self.centre))

    def _turn(self, moment: np.ndarray) -> np.ndarray:
        """Return I⁻¹ M (3,) of a moment about its centre; raises ParameterError if its particles lie on a line."""
        arms = self.positions - self.centre
        squares = np.einsum("ij,ij->i", arms, arms)
        inertia = (self.masses @ squares) * np.eye(3) - (arms.T * self.masses) @ arms
        least, _, most = np.linalg.eigvalsh(inertia)
        if not least > ON_A_LINE * most:
            raise ParameterError(f"{self!r} lies on a line, and has no spin; push it at its centre, without a point")
        return np.linalg.solve(inertia, moment)

    def _mean(self, values: np.ndarray) -> np.ndarray:
        """Return the mean (3,) over the mass, of (n, 3); of equal ones exactly that."""
        masses = self.masses
        return np.asarray(values[0] + masses @ (values - values[0]) / masses.sum())

    @property
    def volume(self) -> float:
        """Enclosed volume [m³], with that of boxes inside."""
        return soft_volume(self.store.model, self.store.state.particle_position, self.row())

    @property
    def pressure(self) -> float:
        """Pressure in it above that outside [Pa]; of a body that is full of liquid, at the height of its centre.

        It may be assigned between steps: then it has so much `gas`, in the volume that it has now.
        """
        room = self._room()
        return gas_pressure(self.gas, room) + self._liquid_pressure(room)

    @pressure.setter
    def pressure(self, value: float) -> None:
        room = self._room()
        least = self._liquid_pressure(room)
        gas = (check_range(value, "pressure", "Pa", least=least) - least) * room
        self.gas = check_range(gas, f"gas, for a pressure of {value} Pa,", "J", least=0.0)

    def _room(self) -> float:
        """Return the room [m³] for gas and liquid."""
        return room_in(self.store.model, self.store.state.particle_position, self.row())

    def _liquid_pressure(self, room: float) -> float:
        """Return the pressure [Pa] of a liquid in it."""
        return liquid_pressure(self.store.model, self.store.controls.gravity, self.row(), room)

    @property
    def strain(self) -> np.ndarray:
        """Strain (e,) of the springs: length / rest length − 1."""
        a, b = self.positions[self.edges.T]
        return np.linalg.norm(b - a, axis=1) / self.rest_length - 1.0

    # What becomes of it.

    def cut(self, point: ArrayLike, normal: ArrayLike, *, radius: float = inf) -> tuple[SoftBody, ...]:
        """Cut it by the plane through `point` (3,) [m] across `normal` (3,); return all pieces, the largest first.

        That one is this body still; the others come last in the world, and are called "ball.1", … after "ball". Of
        equal ones the largest is that where the normal points. All are closed by caps, whose springs are at rest.
        They share the gas by their volume, so that its pressure stays; mass by area, liquid by volume. The cut passes
        through vertices that are nearer than a fifth of an edge, or less where its caps would meet the skin. Both
        momenta and the centre of mass stay, and so do the springs' and the gas's energy. Joints stay where they are,
        boxes inside go with their piece.

        `radius` [m]: only parts of the section are cut that are within it of the point, so that a ring becomes a
        string. Raises ParameterError, and changes nothing, where the plane misses the body, goes through a box inside,
        or the section meets itself; and if something hangs in the body.
        """
        pieces = tuple(SoftBody(self.world, number) for number in cut_body(self, point, normal, radius))
        self.store.events.append(Event("cut", self.store.time, vector(point, "point")[None], pieces))
        return pieces

    # What acts on it.

    @property
    def external_force(self) -> np.ndarray:
        """Force on each particle (n, 3) [N] besides springs, gas and gravity; assign an (n, 3) array, or (3,) for all.

        It stays until it is changed.
        """
        force = self.store.controls.particle_force
        return force[self._rows()] if len(force) else np.zeros_like(self.positions)

    @external_force.setter
    def external_force(self, value: ArrayLike) -> None:
        force = _each(value, "external_force", "N", self.positions.shape)
        with self.store.exclusive():
            controls = self.store.controls
            if not len(controls.particle_force):
                none = np.zeros_like(self.store.state.particle_position)
                self.store.replace(controls=controls._replace(particle_force=none))
            self.store.controls.particle_force[self._rows()] = force

    def apply_force(self, force: ArrayLike, point: ArrayLike | None = None) -> None:
        """Let `force` (3,) [N] act at `point` (3,) [m] of the world, or at the centre, until `clear_forces`.

        Adds to `external_force` what would move a rigid body of its shape so: F in all, with the torque r × F of the
        arm as it is now. To push at one place only, set `external_force` of the particles there. Raises
        ParameterError, with a point, for a body whose particles lie on a line.
        """
        each = self.masses[:, None] * self._as_if_rigid(vector(force, "force"), point)
        self.external_force = self.external_force + each

    def apply_torque(self, torque: ArrayLike) -> None:
        """Let `torque` (3,) [N m], in the world frame, act on it until `clear_forces`, as if it were rigid."""
        turn = self._turn(vector(torque, "torque"))
        each = self.masses[:, None] * np.cross(turn, self.positions - self.centre)
        self.external_force = self.external_force + each

    def clear_forces(self) -> None:
        """Let nothing but springs, gas, liquids and gravity act on it: `external_force` is 0."""
        self.external_force = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Event:
    """One soft body of a world has torn, or was cut, or two were joined.

    Of `bodies` the first is the one that was there before, and the largest. There are others where it fell apart.
    """

    kind: str  # "tear", "cut" or "join"
    time: float  # [s] at the end of the step, or when it was done
    places: np.ndarray  # (k, 3) [m] where particles have split; or one, where it was cut or joined
    bodies: tuple[SoftBody, ...]


def soft_bodies_of(world: HasStore) -> tuple[SoftBody, ...]:
    """Return handles of all soft bodies of a world, as they were added."""
    return tuple(SoftBody(world, i) for i in range(world.store.model.soft_count))


def _each(value: ArrayLike, name: str, unit: str, shape: tuple[int, ...]) -> np.ndarray:
    """Return three numbers a particle, given so or once for all, as a new array; raises ParameterError."""
    try:
        numbers = np.broadcast_to(doubles(value), shape).copy()
    except NO_NUMBERS as error:
        raise ParameterError(f"{name} does not fit; give (3,) or {shape} numbers [{unit}]") from error
    if not np.isfinite(numbers).all():
        row = int(np.argmin(np.isfinite(numbers).all(axis=1)))
        raise ParameterError(f"{name} of particle {row} is {shown(numbers[row])}; give finite numbers [{unit}]")
    return numbers


def _read_only(array: np.ndarray) -> np.ndarray:
    view = array.view()
    view.flags.writeable = False
    return view
