"""A soft body and a box of a World: handles, whose arrays are views of the world's."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from softbody.dynamics.pressure import gas_pressure, soft_volume
from softbody.dynamics.vertex_rings import with_springs
from softbody.errors import ParameterError
from softbody.interrupts import assign_together
from softbody.parameters import NO_NUMBERS, check_range, check_whole, doubles, rest_length_of, stiffness_of, vector

if TYPE_CHECKING:
    from softbody.world import World


class SoftBody:
    """A soft body in a World: its arrays are views of the world's, good until the next body is added.

    It goes by its number: in a world that was restored it is the body of that number, and ParameterError is raised
    wherever there is none.
    """

    def __init__(self, world: World, index: int) -> None:
        check_whole(index, "index", 0)
        self.world = world
        self.index = int(index)
        self._row()

    def _row(self) -> int:
        """Return the body's row; raises ParameterError if it is not in the world."""
        _check_is_there("soft body", self.index, self.world.model.soft_count)
        return self.index

    def _rows(self) -> slice:
        row = self._row()
        return slice(*self.world.model.soft_particle_start[row : row + 2])

    @property
    def positions(self) -> np.ndarray:
        """Positions of the particles (n, 3) [m]."""
        return self.world.state.particle_position[self._rows()]

    @property
    def triangles(self) -> np.ndarray:
        """Triangles (t, 3), as rows of `positions`."""
        model, row = self.world.model, self._row()
        rows = slice(*model.soft_triangle_start[row : row + 2])
        return model.triangle_particles[rows] - model.soft_particle_start[row]

    @property
    def velocities(self) -> np.ndarray:
        """Velocities of the particles (n, 3) [m/s]."""
        return self.world.state.particle_velocity[self._rows()]

    @property
    def centre(self) -> np.ndarray:
        """Centre of mass (3,) [m]; all particles have the same mass."""
        return self.positions.mean(axis=0)

    @property
    def volume(self) -> float:
        """Enclosed volume [m³]."""
        return soft_volume(self.world.model, self.world.state.particle_position, self._row())

    @property
    def pressure(self) -> float:
        """Pressure of the gas [Pa]."""
        return gas_pressure(self.gas, self.volume)

    @property
    def gas(self) -> float:
        """The gas's nRT [J]; may be changed between steps."""
        return float(self.world.controls.soft_gas[self._row()])

    @gas.setter
    def gas(self, value: float) -> None:
        self.world.controls.soft_gas[self._row()] = check_range(value, "gas", "J", least=0.0)

    @property
    def external_force(self) -> np.ndarray:
        """Force on each particle (n, 3) [N] besides springs, gas and gravity; assign an (n, 3) array, or (3,) for all.

        It stays until it is changed.
        """
        force = self.world.controls.particle_force
        return force[self._rows()] if len(force) else np.zeros_like(self.positions)

    @external_force.setter
    def external_force(self, value: ArrayLike) -> None:
        try:
            force = np.broadcast_to(doubles(value), self.positions.shape)
        except NO_NUMBERS as error:
            raise ParameterError(
                f"external_force does not fit; give (3,) or {self.positions.shape} numbers [N]"
            ) from error
        if not np.isfinite(force).all():
            raise ParameterError("external_force is not finite; give finite numbers [N]")
        controls = self.world.controls
        if not len(controls.particle_force):
            self.world.controls = controls._replace(particle_force=np.zeros_like(self.world.state.particle_position))
        self.world.controls.particle_force[self._rows()] = force

    def set_springs(self, stiffness: ArrayLike | None = None, rest_length: ArrayLike | None = None) -> None:
        """Change `stiffness` [N/m] or `rest_length` [m] of all springs: one number, or (e,) as in add_soft_body."""
        model, rings, row = self.world.model, self.world.rings, self._row()
        edges = slice(*model.soft_edge_start[row : row + 2])
        count = edges.stop - edges.start
        stiffnesses, lengths = model.edge_stiffness.copy(), model.edge_rest_length.copy()
        if stiffness is not None:
            stiffnesses[edges] = stiffness_of(stiffness, count)
        if rest_length is not None:
            lengths[edges] = rest_length_of(rest_length, count)
        self.world.replace(
            model=model._replace(edge_stiffness=stiffnesses, edge_rest_length=lengths),
            rings=with_springs(rings, lengths, stiffnesses, model.soft_edge_start),
        )


class Box:
    """A rigid box in a World: its arrays are views of the world's, good until the next body is added.

    It goes by its number, as a SoftBody does.
    """

    def __init__(self, world: World, index: int) -> None:
        check_whole(index, "index", 0)
        self.world = world
        self.index = int(index)
        self._row()

    def _row(self) -> int:
        """Return the box's row; raises ParameterError if it is not in the world."""
        _check_is_there("box", self.index, self.world.model.box_count)
        return self.index

    @property
    def position(self) -> np.ndarray:
        """Position of the centre (3,) [m]."""
        return self.world.state.box_position[self._row()]

    @property
    def orientation(self) -> np.ndarray:
        """Orientation (4,): unit quaternion (w, x, y, z), box frame to world."""
        return self.world.state.box_orientation[self._row()]

    @property
    def velocity(self) -> np.ndarray:
        """Velocity of the centre (3,) [m/s]."""
        return self.world.state.box_velocity[self._row()]

    @property
    def angular_velocity(self) -> np.ndarray:
        """Angular velocity (3,) [rad/s] in the world frame."""
        return self.world.state.box_angular_velocity[self._row()]

    def apply_force(self, force: ArrayLike, point: ArrayLike | None = None) -> None:
        """Let `force` (3,) [N] act at `point` (3,) [m] of the world, or at the centre; paper §10.13.

        Adds F and τ = r × F, with the arm r as it is now, to what acts on the box. Both stay, in every step to come,
        until `clear_forces`.
        """
        newtons, row, controls = vector(force, "force"), self._row(), self.world.controls
        torque = controls.box_torque[row].copy()
        if point is not None:
            torque += vector(np.cross(vector(point, "point") - self.position, newtons), "torque")
        pushed = controls.box_force[row] + newtons
        assign_together((controls.box_force[row], pushed), (controls.box_torque[row], torque))

    def apply_torque(self, torque: ArrayLike) -> None:
        """Let `torque` (3,) [N m], in the world frame, act on the box until `clear_forces`."""
        self.world.controls.box_torque[self._row()] += vector(torque, "torque")

    def clear_forces(self) -> None:
        """Let nothing but gravity act on the box."""
        self.world.controls.box_force[self._row()] = 0.0
        self.world.controls.box_torque[self._row()] = 0.0


def _check_is_there(kind: str, index: int, count: int) -> None:
    if not 0 <= index < count:
        raise ParameterError(f"{kind} {index} is not in this world: there are {count}; take a handle of one that is")
