"""What the bodies are (Model), what acts on them (Controls) and where they are now (State): plain arrays.

A step is a function of the three. Fields are named by what has a row in them: a `particle_` of a soft body, an
`edge_`, a `triangle_`, a `soft_` body, a `box_`. A soft body's particles, edges and triangles are numbered over all
bodies; those of body i are rows start[i] … start[i + 1]. Whoever numbers both kinds of bodies numbers boxes after soft
bodies.
"""

from __future__ import annotations

from math import inf
from typing import Annotated, NamedTuple

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.vec import load, store

NOBODY = -1  # no box, no particle: the ground, a place in the world, or a side of another kind


class Rows(NamedTuple):
    """What the rows of an array are, if not one real number each, of any size."""

    columns: int = 0  # numbers a row, 0 for an array of one axis
    whole: bool = False
    least: float = -inf
    above: float = -inf
    most: float = inf
    beyond: float = -inf  # in size, or 0


class Property(NamedTuple):
    """A number that a user may give each body, as a keyword of `add_soft_body` or `add_box`: the field without `soft_`.

    A field of a Model that is annotated with one is filled in, checked, a key of scene files, saved and restored. Files
    of formats before `since` do not have it: bodies in them get the default. A line `name = BodyProperty()` in the
    class of the handle makes it an attribute, with `doc` as its docstring.
    """

    default: float | None  # None: `softbody.bodies.builder` works it out from what the body is
    doc: str
    unit: str = ""
    least: float = 0.0
    most: float = inf
    since: int = 1  # format of snapshots and files
    is_chosen: bool = False  # for True the builder works it out, and False is 0


RESTITUTION = "Restitution in contacts, 0 … 1."
FRICTION = "Coulomb coefficient of friction in contacts, ≥ 0."


class Model(NamedTuple):
    """What the bodies are; `softbody.bodies.builder` makes Models."""

    soft_count: int  # soft bodies, b
    box_count: int  # boxes, m
    particle_free_inverse_mass: Annotated[np.ndarray, Rows(above=0.0)]  # (n,) [1/kg], of those that are fixed, too
    particle_inverse_mass: Annotated[np.ndarray, Rows(least=0.0)]  # (n,) [1/kg]; the same, or 0: the particle is fixed
    edge_particles: Annotated[np.ndarray, Rows(2, whole=True)]  # (e, 2) that the edge's spring joins
    edge_rest_length: Annotated[np.ndarray, Rows(above=0.0)]  # (e,) [m]
    edge_stiffness: Annotated[np.ndarray, Rows(least=0.0)]  # (e,) [N/m]
    # (e,) length / rest length beyond which the surface tears there; 0: never; < 0: not before it is within that once
    edge_tear_at: Annotated[np.ndarray, Rows(beyond=1.0)]
    triangle_particles: Annotated[np.ndarray, Rows(3, whole=True)]  # (t, 3) counter-clockwise seen from outside
    soft_particle_start: Annotated[np.ndarray, Rows(whole=True)]  # (b + 1,)
    soft_edge_start: Annotated[np.ndarray, Rows(whole=True)]  # (b + 1,)
    soft_triangle_start: Annotated[np.ndarray, Rows(whole=True)]  # (b + 1,)
    # (b,) 2 V/A at rest [m]: of a plate its thickness, of a ball two thirds of its radius
    soft_thickness: Annotated[np.ndarray, Rows(above=0.0)]
    soft_edge_length: Annotated[np.ndarray, Rows(above=0.0)]  # (b,) mean, of the mesh as it was added [m]
    soft_mesh_volume: Annotated[np.ndarray, Rows(above=0.0)]  # (b,) of the mesh as it was added [m³]
    soft_boxes_volume: Annotated[np.ndarray, Rows(least=0.0)]  # (b,) [m³] of all boxes inside it
    soft_deflated_below: Annotated[
        np.ndarray, Property(0.0, "Fraction of the mesh's volume at which it has collapsed, 0 … 1.", most=1.0)
    ]  # (b,)
    soft_damping: Annotated[
        np.ndarray,
        Property(None, "Damping of the springs [N s/m], against the speed at which their ends part.", "N s/m"),
    ]  # (b,)
    soft_drag: Annotated[np.ndarray, Property(0.0, "Rate at which all velocities fade [1/s].", "1/s")]  # (b,)
    soft_restitution: Annotated[np.ndarray, Property(0.0, RESTITUTION, most=1.0)]  # (b,)
    soft_friction: Annotated[np.ndarray, Property(0.5, FRICTION)]  # (b,)
    # (b,) [m]; 0: it goes through itself; < 0: it did so when it was to begin to hold itself, and does not yet
    soft_self_contact: Annotated[
        np.ndarray,
        Property(
            0.0, "Distance [m] that its surface keeps from itself; 0: it does not.", "m", -inf, since=8, is_chosen=True
        ),
    ]
    soft_leak: Annotated[
        np.ndarray,
        Property(200.0, "Speed [m/s] at which gas leaks out where it has torn; 0: none does.", "m/s", since=13),
    ]  # (b,)
    # (b,) [kg/m³], of the liquid in the mesh as it was added, but for boxes inside: its mass is in that of particles
    soft_liquid_density: Annotated[
        np.ndarray, Property(0.0, "Density [kg/m³] of the liquid that fills it; 0: none does.", "kg/m³", since=10)
    ]
    soft_sound_speed: Annotated[
        np.ndarray,
        Property(0.0, "Speed of sound [m/s] in that; 0: its weight presses it together by 1 %.", "m/s", since=10),
    ]  # (b,)
    soft_liquid_drag: Annotated[
        np.ndarray,
        Property(0.0, "Drag [N s/m³] of that on boxes inside, by their speed and surface.", "N s/m³", since=11),
    ]  # (b,)
    box_size: Annotated[np.ndarray, Rows(3, above=0.0)]  # (m, 3) full extent [m]
    box_inverse_mass: Annotated[np.ndarray, Rows(least=0.0)]  # (m,) [1/kg]; 0 for a static or kinematic box
    box_inverse_inertia: Annotated[np.ndarray, Rows(3, least=0.0)]  # (m, 3) diagonal in the box's own frame [1/(kg m²)]
    box_restitution: Annotated[np.ndarray, Property(0.0, RESTITUTION, most=1.0)]  # (m,)
    box_friction: Annotated[np.ndarray, Property(0.5, FRICTION)]  # (m,)
    box_host: Annotated[np.ndarray, Rows(whole=True, least=-1)]  # (m,) soft body that it is inside, or −1
    ground_height: float  # the ground is z ≤ height [m]; −inf: no ground
    ground_restitution: float  # 0 … 1
    ground_friction: float  # Coulomb coefficient, ≥ 0
    liquid_density: float  # [kg/m³]; 0: no liquid
    liquid_surface_height: float  # z [m] below which there is liquid
    liquid_drag: float  # [N s/m³] against the liquid, by wet area
    liquid_velocity: Annotated[np.ndarray, Rows()]  # (3,) [m/s] with which it flows


@jit_lean
def has_border(edges: int, triangles: int) -> bool:
    """Tell whether a surface of so many edges and triangles is open: each edge within has two triangles."""
    return 2 * edges > 3 * triangles


@jit_lean
def is_open(model: Model, body: int) -> bool:
    """Tell whether a soft body has torn, so that its surface has borders."""
    edges = model.soft_edge_start[body + 1] - model.soft_edge_start[body]
    return has_border(edges, model.soft_triangle_start[body + 1] - model.soft_triangle_start[body])


class Controls(NamedTuple):
    """What acts on the bodies: what a user sets between steps. It stays until it is changed."""

    gravity: np.ndarray  # (3,) [m/s²]
    soft_gas: Annotated[np.ndarray, Rows(least=0.0)]  # (b,) nRT [J]
    particle_force: Annotated[np.ndarray, Rows(3)]  # (n, 3) [N] on each particle, or (0, 3) where there is none
    box_force: Annotated[np.ndarray, Rows(3)]  # (m, 3) [N] through the centre, besides gravity
    box_torque: Annotated[np.ndarray, Rows(3)]  # (m, 3) [N m], world frame


class Joints(NamedTuple):
    """Damped springs between points of bodies: two ends each, of which columns 0 … and the second half of all tell.

    An end is on a box, or in a triangle of a soft body (a particle is one thrice), or inside a soft body, at a point
    that hangs in it, or, with none of these, in the world. Points that hang in a soft body are in suspensions, of one
    body each; a point is where Σ w x of all its particles is.
    """

    joint_box: Annotated[np.ndarray, Rows(2, whole=True, least=-1)]  # (j, 2) or −1
    joint_particles: Annotated[np.ndarray, Rows(6, whole=True, least=-1)]  # (j, 6) or −1
    joint_weights: Annotated[np.ndarray, Rows(6, least=0.0, most=1.0)]  # (j, 6) barycentric; 0 if not in a triangle
    joint_inside: Annotated[np.ndarray, Rows(4, whole=True, least=-1)]  # (j, 4) suspension, and point of it, or −1
    joint_place: Annotated[np.ndarray, Rows(6)]  # (j, 6) [m] in the box's own frame, or in the world; else 0
    joint_stiffness: Annotated[np.ndarray, Rows(least=0.0)]  # (j,) [N/m]
    joint_damping: Annotated[np.ndarray, Rows(least=0.0)]  # (j,) [N s/m]
    joint_rest_length: Annotated[np.ndarray, Rows(least=0.0)]  # (j,) [m]
    suspension_particles: Annotated[np.ndarray, Rows(2, whole=True, least=0)]  # (s, 2) first of its body, and end
    suspension_box: Annotated[np.ndarray, Rows(whole=True, least=-1)]  # (s,) whose corners the points are for, or −1
    suspension_start: Annotated[np.ndarray, Rows(whole=True, least=0)]  # (s + 1,) of each in the next
    weight: Annotated[np.ndarray, Rows()]  # (w,) of each particle of the body, point after point


class State(NamedTuple):
    """Where the bodies are now."""

    particle_position: Annotated[np.ndarray, Rows(3)]  # (n, 3) [m]
    particle_velocity: Annotated[np.ndarray, Rows(3)]  # (n, 3) [m/s]
    box_position: Annotated[np.ndarray, Rows(3)]  # (m, 3) [m]
    box_orientation: Annotated[np.ndarray, Rows(4)]  # (m, 4) unit quaternion (w, x, y, z), box frame to world
    box_velocity: Annotated[np.ndarray, Rows(3)]  # (m, 3) [m/s]
    box_angular_velocity: Annotated[np.ndarray, Rows(3)]  # (m, 3) [rad/s], world frame
    box_time_left: Annotated[np.ndarray, Rows(least=0.0)]  # (m,) [s] until a kinematic box stops; 0: it does not

    def copy(self) -> State:
        """Return a State that shares no memory with this one."""
        return copied(self)


@jit
def copied(state: State) -> State:
    """Return a State that shares no memory with this one."""
    return State(
        state.particle_position.copy(),
        state.particle_velocity.copy(),
        state.box_position.copy(),
        state.box_orientation.copy(),
        state.box_velocity.copy(),
        state.box_angular_velocity.copy(),
        state.box_time_left.copy(),
    )


@jit
def copy_state(source: State, target: State) -> None:
    """Overwrite the arrays of a State with those of another."""
    copy_particles(source, target, 0, source.particle_position.shape[0])
    copy_boxes(source, target)


@jit_lean
def copy_particles(source: State, target: State, first: int, end: int) -> None:
    """Overwrite the particles from `first` to `end` of a State with those of another."""
    for i in range(first, end):
        store(target.particle_position, i, load(source.particle_position, i))
        store(target.particle_velocity, i, load(source.particle_velocity, i))


@jit_lean
def copy_boxes(source: State, target: State) -> None:
    """Overwrite the boxes of a State with those of another."""
    for i in range(source.box_position.shape[0]):
        store(target.box_position, i, load(source.box_position, i))
        store(target.box_velocity, i, load(source.box_velocity, i))
        store(target.box_angular_velocity, i, load(source.box_angular_velocity, i))
        target.box_time_left[i] = source.box_time_left[i]
        for c in range(4):
            target.box_orientation[i, c] = source.box_orientation[i, c]


class Clock(NamedTuple):
    """How far a world is. Kernels write it with the state, so that no interrupt comes between the two."""

    steps: np.ndarray  # (1,) done since the world was made
    time: np.ndarray  # (1,) [s]
    shape: np.ndarray  # (1,) checksum of where the last run has left the particles
    part: np.ndarray  # (1,) [s] the last step, or its last part: contacts are of that


class VertexRings(NamedTuple):
    """The soft bodies once more, in the order and the form in which the fast kernels read them.

    An index is a particle's place within its body in that order. Every particle has its neighbours in cyclic order
    (its one-ring), so that springs and the triangles between them come from the same coordinates. Particles of the
    same number of neighbours lie in blocks, which twins of their last particle fill up to whole lanes: they move as it
    does, and count nowhere. See softbody/dynamics/vertex_rings.py, which makes them.
    """

    particle: np.ndarray  # (s,) uint32: row in State.particle_position of the particle at each index, body by body
    number: np.ndarray  # (s,) uint32: the first of its three numbers there, row after row
    start: np.ndarray  # (b + 1,) of each body in `particle`
    block: np.ndarray  # (c, 7) see FIRST … STIFFNESS
    block_start: np.ndarray  # (b + 1,)
    edge: np.ndarray  # (r,) row in Model.edge_stiffness of the spring of each entry
    neighbour: np.ndarray  # (r,) index; entry first + d m + q: neighbour d of particle q of the m of a block
    rest_tension: np.ndarray  # (r,) stiffness × rest length [N]
    next_neighbour: np.ndarray  # (f,) index that comes next in the ring, for blocks whose entries are not all one cycle
    stiffness: np.ndarray  # (g,) [N/m] of each entry, for bodies whose springs differ
    common_stiffness: np.ndarray  # (b,) [N/m], NaN for a body whose springs differ
    border: np.ndarray  # (c,) indices along the borders of holes, hole by hole
    hole: np.ndarray  # (h, 2) rows of each hole in `border`
    hole_start: np.ndarray  # (b + 1,) of each body in `hole`


# Columns of `VertexRings.block`: first index and end, how many of them are no twins, how many neighbours each has, and
# the first of their entries in `neighbour`, and in `next_neighbour` and `stiffness`, where they are not in them: −1.
FIRST, END, NUMBER, DEGREE, ENTRY, NEXT, STIFFNESS = range(7)


class SoftBodies(NamedTuple):
    """What moves soft bodies between contacts, gathered from a Model, Controls and a State."""

    inverse_mass: np.ndarray  # (n,) [1/kg]; 0 for a fixed particle
    position: np.ndarray  # (n, 3) [m]
    velocity: np.ndarray  # (n, 3) [m/s]
    force: np.ndarray  # (n, 3) [N] from outside, or (0, 3)
    start: np.ndarray  # (b + 1,) first particle of each body
    gas: np.ndarray  # (b,) nRT [J]
    damping: np.ndarray  # (b,) [N s/m]
    drag: np.ndarray  # (b,) [1/s]
    mesh_volume: np.ndarray  # (b,) [m³]
    boxes_volume: np.ndarray  # (b,) [m³] of boxes inside
    deflated_below: np.ndarray  # (b,) of it
    gravity: np.ndarray  # (3,) [m/s²]


@jit
def soft_bodies_of(model: Model, controls: Controls, state: State) -> SoftBodies:
    """Return the soft bodies of a world, which share its memory."""
    return SoftBodies(
        model.particle_inverse_mass,
        state.particle_position,
        state.particle_velocity,
        controls.particle_force,
        model.soft_particle_start,
        controls.soft_gas,
        model.soft_damping,
        model.soft_drag,
        model.soft_mesh_volume,
        model.soft_boxes_volume,
        model.soft_deflated_below,
        controls.gravity,
    )


class Particles(NamedTuple):
    """What an impulse on a soft body's surface reads and changes."""

    inverse_mass: np.ndarray  # (n,) [1/kg]; 0 for a fixed particle
    position: np.ndarray  # (n, 3) [m]
    velocity: np.ndarray  # (n, 3) [m/s]


@jit
def particles_of(model: Model, state: State) -> Particles:
    """Return the particles of a world, which share its memory."""
    return Particles(model.particle_inverse_mass, state.particle_position, state.particle_velocity)


def mass_of(free_inverse_mass: np.ndarray) -> float:
    """Return the mass [kg] of particles (n,) of such inverse masses [1/kg]; of equal ones n divided by theirs."""
    one = free_inverse_mass[0]
    return float((one / free_inverse_mass).sum() / one)


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
