"""What the bodies are (Model) and where they are now (State): plain arrays, owned body by body through offsets."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from softbody.jit import jit


def appended(array: np.ndarray, rows: ArrayLike) -> np.ndarray:
    """Return `array` followed by `rows`, in memory with room for more: adding n bodies costs O(n), not O(n²).

    The result may share memory with `array`, of which only the newest result may be appended to.
    """
    more = np.asarray(rows, array.dtype).reshape(-1, *array.shape[1:])
    old, new = len(array), len(array) + len(more)
    room = array.base
    if room is None or room.shape[1:] != array.shape[1:] or len(room) < new or room.dtype != array.dtype:
        room = np.empty((max(new, 2 * old), *array.shape[1:]), array.dtype)
        room[:old] = array
    room[old:new] = more
    return room[:new]


class Rings(NamedTuple):
    """The soft bodies once more, in the order and the form in which the fast kernels read them.

    A place is a particle's number within its body in that order. Every particle has its neighbours in cyclic order
    (its one-ring), so that springs and the triangles between them come from the same coordinates. Particles of the
    same number of neighbours lie in blocks. See softbody/dynamics/rings.py, which makes them.
    """

    order: np.ndarray  # (n,) row in State.position of the particle at each place, body by body
    block: np.ndarray  # (c, 5) first place, end place, degree, first entry, first entry of `following` or −1
    block_start: np.ndarray  # (b + 1,)
    edge: np.ndarray  # (r,) row in Model.edges of the spring of each entry
    neighbour: np.ndarray  # (r,) place; entry first + d m + q: neighbour d of particle q of the m of a block
    stiffness: np.ndarray  # (r,) [N/m]
    rest_pull: np.ndarray  # (r,) stiffness × rest length [N]
    following: np.ndarray  # (f,) next place around the ring, for blocks whose entries are not all one cycle
    common_stiffness: np.ndarray  # (b,) [N/m], NaN for a body whose springs differ


class Model(NamedTuple):
    """What the bodies are. Soft body i owns rows start[i] … start[i + 1] of the arrays of its kind."""

    inverse_mass: np.ndarray  # (n,) [1/kg] of each particle; 0 for one that is pinned
    edges: np.ndarray  # (e, 2) particles that a spring joins, numbered over all bodies
    rest_length: np.ndarray  # (e,) [m]
    stiffness: np.ndarray  # (e,) [N/m]
    triangles: np.ndarray  # (t, 3) particles, numbered over all bodies
    particle_start: np.ndarray  # (b + 1,)
    edge_start: np.ndarray  # (b + 1,)
    triangle_start: np.ndarray  # (b + 1,)
    gas: np.ndarray  # (b,) nRT [J]; may change between steps
    thickness: np.ndarray  # (b,) 2 V/A at rest [m]: of a plate its thickness, of a ball two thirds of its radius
    edge_length: np.ndarray  # (b,) mean, of the mesh as it was added [m]
    least_volume: np.ndarray  # (b,) [m³]; at or below it the body counts as collapsed
    damping: np.ndarray  # (b,) of the springs, along their edges [N s/m]
    drag: np.ndarray  # (b,) rate at which velocities fade [1/s]
    external_force: np.ndarray  # (n, 3) [N] on each particle, or (0, 3) where there is none
    soft_restitution: np.ndarray  # (b,) 0 … 1
    soft_friction: np.ndarray  # (b,) Coulomb coefficient, ≥ 0
    box_size: np.ndarray  # (m, 3) full extent [m]
    box_inverse_mass: np.ndarray  # (m,) [1/kg]; 0 for a static box
    box_inverse_inertia: np.ndarray  # (m, 3) diagonal in the box's own frame [1/(kg m²)]; 0 for a static box
    box_restitution: np.ndarray  # (m,) 0 … 1
    box_friction: np.ndarray  # (m,) Coulomb coefficient, ≥ 0
    box_force: np.ndarray  # (m, 3) [N] through the centre, besides gravity; stays until it is changed
    box_torque: np.ndarray  # (m, 3) [N m], world frame; stays until it is changed
    gravity: np.ndarray  # (3,) [m/s²]
    ground_height: float  # the ground is z ≤ height [m]; −inf: no ground
    ground_restitution: float  # 0 … 1
    ground_friction: float  # Coulomb coefficient, ≥ 0


class State(NamedTuple):
    """Where the bodies are now."""

    position: np.ndarray  # (n, 3) [m] of each particle
    velocity: np.ndarray  # (n, 3) [m/s]
    box_position: np.ndarray  # (m, 3) [m]
    box_orientation: np.ndarray  # (m, 4) unit quaternion (w, x, y, z), box frame to world
    box_velocity: np.ndarray  # (m, 3) [m/s]
    box_angular_velocity: np.ndarray  # (m, 3) [rad/s], world frame

    def copy(self) -> State:
        """Return a State that shares no memory with this one."""
        return copied(self)


@jit
def copied(state: State) -> State:
    """Return a State that shares no memory with this one."""
    return State(
        state.position.copy(),
        state.velocity.copy(),
        state.box_position.copy(),
        state.box_orientation.copy(),
        state.box_velocity.copy(),
        state.box_angular_velocity.copy(),
    )


class Rules(NamedTuple):
    """By which rules bodies move and collide; a ceiling of inf and a floor of 0 do nothing."""

    paper_axes: bool  # separating axes: face normals only
    single_contact: bool  # one impulse a pair, as in the paper, instead of manifolds solved together
    exhaustive_pairs: bool  # try all pairs, as in the paper, instead of a grid
    iterations: int  # of the contact solver, a step
    edge_contacts: bool  # of soft bodies, and not only contacts of vertices, as in the paper
    split_steps: bool  # where bodies would jump through each other
    gyroscopic: bool  # a free box keeps I ω instead of ω
    speed_ceiling: float  # [m/s]; paper §6
    angular_speed_ceiling: float  # [rad/s]; paper §6
    angular_speed_floor: float  # [rad/s] below which a box on the ground stops turning and snaps to 90°; paper §6
    frictionless: bool  # whatever is added has friction 0, as everything in the paper


class RigidBodies(NamedTuple):
    """What an impulse between rigid bodies reads and changes, gathered from a Model and a State."""

    inverse_mass: np.ndarray  # (m,) [1/kg]; 0 for a static body
    inverse_inertia: np.ndarray  # (m, 3) diagonal in the body's frame [1/(kg m²)]; 0 for a static body
    position: np.ndarray  # (m, 3) centre of mass [m]
    orientation: np.ndarray  # (m, 4) unit quaternion (w, x, y, z), body frame to world
    velocity: np.ndarray  # (m, 3) [m/s]
    angular_velocity: np.ndarray  # (m, 3) [rad/s], world frame


@jit
def boxes_of(model: Model, state: State) -> RigidBodies:
    """Return the boxes of a world as RigidBodies that share its memory."""
    return RigidBodies(
        model.box_inverse_mass,
        model.box_inverse_inertia,
        state.box_position,
        state.box_orientation,
        state.box_velocity,
        state.box_angular_velocity,
    )
