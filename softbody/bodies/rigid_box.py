"""A rigid box of a World: a handle, whose arrays are views of the world's."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from softbody.bodies.body import BodyProperty, SleepyBody
from softbody.bodies.inside import with_box_put
from softbody.bodies.soft_body import SoftBody
from softbody.bodies.store import HasStore
from softbody.compiler.interrupts import assign_together
from softbody.dynamics.filling import liquid_mass, volume_of_box
from softbody.dynamics.liquid_forces import BOX_TRIANGLES, corners_of
from softbody.dynamics.pressure import room_in
from softbody.errors import ParameterError
from softbody.linalg.quaternion import rotation_between, rotation_matrix
from softbody.model.arrays import NOBODY
from softbody.model.validation import check_range, unit_quaternion, vector


class Box(SleepyBody):
    """A rigid box in a World: what it is, where it is, and what of it may be set between steps."""

    __slots__ = ()

    kind = "box"

    def _count(self) -> int:
        return self.store.model.box_count

    def _surface(self) -> tuple[np.ndarray, np.ndarray]:
        return corners_of(self.store.model, self.store.state, self.row()), BOX_TRIANGLES

    def _in_liquid(self) -> tuple[float, float]:
        model, host = self.store.model, int(self.store.model.box_host[self.row()])
        if host == NOBODY:
            return super()._in_liquid()
        mass, room = liquid_mass(model, host), room_in(model, self.store.state.particle_position, host)
        return mass / room, volume_of_box(model, self.row()) if mass > 0.0 else 0.0

    def __repr__(self) -> str:
        """Say which box it is, how large and heavy, and where."""
        if not self.is_there:
            return "<box that is gone>"
        size, where = (", ".join(f"{x:.4g}" for x in of.round(6) + 0.0) for of in (self.size, self.position))
        weight = f"{self.mass:.4g} kg" if self.mass else "kinematic" if self.is_kinematic else "static"
        return f"<{self._title()}: ({size}) m, {weight}, at ({where}) m>"

    @property
    def size(self) -> np.ndarray:
        """Full extent (3,) [m] along its own axes."""
        return self.store.model.box_size[self.row()].copy()

    @property
    def mass(self) -> float | None:
        """Mass [kg]; None for a static or kinematic box."""
        inverse = float(self.store.model.box_inverse_mass[self.row()])
        return 1.0 / inverse if inverse > 0.0 else None

    @property
    def is_kinematic(self) -> bool:
        """Whether it has no mass, and moves: by its velocities, which nothing in the world changes."""
        return self.mass is None and bool(self.velocity.any() or self.angular_velocity.any())

    @property
    def inside(self) -> SoftBody | None:
        """The soft body that it is inside, whose skin holds it from within; None for none. May be set between steps.

        Raises ParameterError where it does not fit, and where it hangs by a suspension.
        """
        host = int(self.store.model.box_host[self.row()])
        return None if host == NOBODY else SoftBody(self.world, host)

    @inside.setter
    def inside(self, value: SoftBody | None) -> None:
        with self.store.exclusive():
            store, row = self.store, self.row()
            if (store.joints.suspension_box == row).any():
                raise ParameterError(f"{self!r} hangs in {self.inside!r}; remove that suspension first")
            store.replace(model=with_box_put(store, store.parts, row, value).model)

    restitution = BodyProperty()
    friction = BodyProperty()

    @property
    def position(self) -> np.ndarray:
        """Position of the centre (3,) [m]; may be assigned, as all that follow."""
        return self.store.state.box_position[self.row()]

    @position.setter
    def position(self, value: ArrayLike) -> None:
        self.position[:] = vector(value, "position")

    @property
    def orientation(self) -> np.ndarray:
        """Orientation (4,): unit quaternion (w, x, y, z), box frame to world."""
        return self.store.state.box_orientation[self.row()]

    @orientation.setter
    def orientation(self, value: ArrayLike) -> None:
        self.orientation[:] = unit_quaternion(value)

    @property
    def velocity(self) -> np.ndarray:
        """Velocity of the centre (3,) [m/s]. A box without mass keeps it, whatever it meets: it is kinematic.

        To set it, or the angular velocity, ends what `move_to` began; what is written into the array lasts until then.
        """
        return self.store.state.box_velocity[self.row()]

    @velocity.setter
    def velocity(self, value: ArrayLike) -> None:
        self._go(velocity=vector(value, "velocity"))

    @property
    def angular_velocity(self) -> np.ndarray:
        """Angular velocity (3,) [rad/s] in the world frame. A box without mass keeps it."""
        return self.store.state.box_angular_velocity[self.row()]

    @angular_velocity.setter
    def angular_velocity(self, value: ArrayLike) -> None:
        self._go(angular_velocity=vector(value, "angular_velocity"))

    def move_to(
        self, position: ArrayLike | None = None, orientation: ArrayLike | None = None, *, seconds: float
    ) -> None:
        """Let a box without mass be there after `seconds` [s], and stop; None: where it is now.

        On a straight way, by the shorter turn about one axis, both even: it has the velocities for that from now on,
        and pushes what it meets with them. Another call, or velocities that are set, end that. Raises ParameterError
        for a box that has a mass, which forces move.
        """
        if self.mass is not None:
            raise ParameterError(
                f"box {self.index} has a mass of {self.mass:.4g} kg, and is moved by forces; add it with mass None"
            )
        seconds = check_range(seconds, "seconds", "s", above=0.0)
        way, turn = np.zeros(3), np.zeros(3)
        if position is not None:
            way = vector(position, "position") - self.position
        if orientation is not None:
            turn = rotation_between(self.orientation, unit_quaternion(orientation))
        with np.errstate(over="ignore"):
            velocity, spin = vector(way / seconds, "velocity"), vector(turn / seconds, "angular_velocity")
        self._go(velocity, spin, seconds)

    def _go(
        self,
        velocity: np.ndarray | None = None,
        angular_velocity: np.ndarray | None = None,
        seconds: float = 0.0,
    ) -> None:
        """Set velocities, if they are given, and for how long they last; 0: until others are."""
        row, state = self.row(), self.store.state
        assign_together(
            (state.box_velocity[row], self.velocity if velocity is None else velocity),
            (state.box_angular_velocity[row], self.angular_velocity if angular_velocity is None else angular_velocity),
            (state.box_time_left[row : row + 1], seconds),
        )

    def apply_impulse(self, impulse: ArrayLike, point: ArrayLike | None = None) -> None:
        """Strike it by `impulse` (3,) [N s] at `point` (3,) [m] of the world, or at the centre: velocities change now.

        Raises ParameterError for a box without mass, which nothing moves.
        """
        blow, row, model = vector(impulse, "impulse"), self.row(), self.store.model
        if self.mass is None:
            raise ParameterError(f"{self!r} has no mass, and nothing moves it; add it with one, or set its velocity")
        turn = np.zeros(3)
        if point is not None:
            arm = vector(point, "point") - self.position
            axes = rotation_matrix(self.orientation)
            turn = axes @ (model.box_inverse_inertia[row] * (np.cross(arm, blow) @ axes))
        self._go(
            vector(self.velocity + blow / self.mass, "velocity"),
            vector(self.angular_velocity + turn, "angular_velocity"),
        )

    def apply_force(self, force: ArrayLike, point: ArrayLike | None = None) -> None:
        """Let `force` (3,) [N] act at `point` (3,) [m] of the world, or at the centre; paper §10.13.

        Adds F and τ = r × F, with the arm r as it is now, to what acts on the box. Both stay, in every step to come,
        until `clear_forces`.
        """
        newtons, row, controls = vector(force, "force"), self.row(), self.store.controls
        torque = controls.box_torque[row].copy()
        if point is not None:
            torque += vector(np.cross(vector(point, "point") - self.position, newtons), "torque")
        pushed = controls.box_force[row] + newtons
        assign_together((controls.box_force[row], pushed), (controls.box_torque[row], torque))

    def apply_torque(self, torque: ArrayLike) -> None:
        """Let `torque` (3,) [N m], in the world frame, act on the box until `clear_forces`."""
        self.store.controls.box_torque[self.row()] += vector(torque, "torque")

    def clear_forces(self) -> None:
        """Let nothing but gravity act on the box."""
        controls, row = self.store.controls, self.row()
        assign_together((controls.box_force[row], 0.0), (controls.box_torque[row], 0.0))


def boxes_of(world: HasStore) -> tuple[Box, ...]:
    """Return handles of all boxes of a world, as they were added."""
    return tuple(Box(world, i) for i in range(world.store.model.box_count))
