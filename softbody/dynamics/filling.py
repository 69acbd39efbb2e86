"""Liquid that fills soft bodies: its weight, as a pressure on the skin that grows with depth.

The liquid is in the whole body but for boxes inside, of one density ρ = m / V at every moment, with its mass m shared
by the particles. At the height of its centre its pressure is c² (ρ − ρ0), and none where it has more room than it
needs; c is its speed of sound. For each metre below it is ρ g more, besides the pressure of a gas. So forces are
−∂U/∂x, with U the energy of its weight at that centre and of what it is pressed together. The liquid moves as the skin
does: sloshing is left out, and in a free fall the pressure is that of a liquid at rest.
"""

from __future__ import annotations

from math import log
from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.compiler.simd import LANES, first_lanes, spread, sum_of_lanes
from softbody.dynamics.liquid_forces import Moving, place_of
from softbody.dynamics.ring_pressure import (
    RingWork,
    add_to_particles,
    origin_of_rows,
    place_of_rows,
    pressed,
    sum_around,
    turn_of_rows,
)
from softbody.geometry.submerged import double_area
from softbody.linalg.vec import Vec, add, dot, load, norm, scale, sub
from softbody.model.arrays import FIRST, NUMBER, Model, State

# Of c² over that of a liquid which its own weight would press together by all of it: as for weakly compressible liquids
# (Monaghan 1994), it gives way by about a hundredth.
STIFFER = 100.0


class Filling(NamedTuple):
    """A liquid in a soft body."""

    density: float  # [kg/m³] of now
    middle: float  # g·(c − o) [m²/s²], with c the centre of the liquid and o the body's first particle
    pressure: float  # [Pa] at the height of c, besides that of the gas


@jit
def liquid_mass(model: Model, body: int) -> float:
    """Return the mass [kg] of the liquid that fills a soft body."""
    return model.soft_liquid_density[body] * (model.soft_mesh_volume[body] - model.soft_boxes_volume[body])


@jit
def square_of_sound(model: Model, gravity: Vec, body: int) -> float:
    """Return c² [m²/s²] of the liquid that fills a soft body."""
    c, size = model.soft_sound_speed[body], model.soft_mesh_volume[body] ** (1.0 / 3.0)
    return c * c if c > 0.0 else STIFFER * norm(gravity) * size


@jit
def liquid_pressure(model: Model, gravity: np.ndarray, body: int, room: float) -> float:
    """Return the pressure [Pa] of the liquid in a soft body, at the height of its centre; `room` [m³] for it."""
    lost = (model.soft_mesh_volume[body] - model.soft_boxes_volume[body]) / room - 1.0
    c2 = square_of_sound(model, (gravity[0], gravity[1], gravity[2]), body)
    return c2 * model.soft_liquid_density[body] * lost if lost > 0.0 else 0.0


@jit
def add_filling_forces(
    model: Model, gravity: np.ndarray, work: RingWork, moving: Moving, box_position: np.ndarray, force: np.ndarray
) -> None:
    """Add to the `force` (n, 3) [N] on particles what liquid in them adds to m g: it presses where it is deep.

    `box_position` (m, 3) [m]: boxes inside are where no liquid is.
    """
    g = gravity[0], gravity[1], gravity[2]
    for body in range(model.soft_count):
        mass = liquid_mass(model, body)
        if mass > 0.0:
            sum_around(work, body, moving, g)
            origin = origin_of_rows(work)
            whole = _middle_of_rows(g, work, body)
            room, middle = _around_boxes(model, g, box_position, body, origin, whole)
            filling = Filling(mass / room, middle, liquid_pressure(model, gravity, body, room))
            each = scale(-mass / (model.soft_particle_start[body + 1] - model.soft_particle_start[body]), g)
            _press(g, work, body, filling, each, force)


@jit_lean
def _middle_of_rows(g: Vec, work: RingWork, body: int) -> tuple[float, float]:
    """Return what `_middle` does of a body, with o its first particle in the rings."""
    rings, origin, six, sums = work.rings, origin_of_rows(work), spread(0.0), spread(0.0)
    for block in range(rings.block_start[body], rings.block_start[body + 1]):
        first, number = rings.block[block, FIRST], rings.block[block, NUMBER]
        for q in range(0, number, LANES):
            arm = sub(place_of_rows(work, first + q), origin)
            volumes = first_lanes(dot(arm, turn_of_rows(work, first + q)), number - q)
            six = six + volumes
            sums = sums + dot(g, arm) * volumes
    whole = sum_of_lanes(six) / 3.0
    return whole / 6.0, 0.25 * sum_of_lanes(sums) / whole


@jit_lean
def _middle(g: Vec, moving: Moving, triangles: np.ndarray, first: int) -> tuple[float, float]:
    """Return the volume [m³] within `triangles` (t, 3), and g·(c − o) [m²/s²]: c is its centre, o particle `first`."""
    origin, six, sums = place_of(moving, first), 0.0, 0.0
    for t in range(triangles.shape[0]):
        a = sub(place_of(moving, triangles[t, 0]), origin)
        b = sub(place_of(moving, triangles[t, 1]), origin)
        c = sub(place_of(moving, triangles[t, 2]), origin)
        volumes = dot(a, double_area((0.0, 0.0, 0.0), b, c))
        six += volumes
        sums += volumes * (dot(g, a) + dot(g, b) + dot(g, c))
    return six / 6.0, 0.25 * sums / six


@jit_lean
def _around_boxes(
    model: Model, g: Vec, box_position: np.ndarray, body: int, origin: Vec, whole: tuple[float, float]
) -> tuple[float, float]:
    """Return what `_middle` does of a body, the `whole`, for the room in it that no box takes; o is the `origin`."""
    if model.soft_boxes_volume[body] == 0.0:
        return whole
    room, moment = whole[0] - model.soft_boxes_volume[body], whole[0] * whole[1]
    for box in range(model.box_count):
        if model.box_host[box] == body:
            moment -= volume_of_box(model, box) * dot(g, sub(load(box_position, box), origin))
    return room, moment / room


@jit
def volume_in(model: Model, moving: Moving, body: int) -> float:
    """Return the volume [m³] of a soft body, as it will be in a moment, with all that is inside."""
    triangles = model.triangle_particles[model.soft_triangle_start[body] : model.soft_triangle_start[body + 1]]
    return _middle((0.0, 0.0, 0.0), moving, triangles, model.soft_particle_start[body])[0]


@jit_lean
def volume_of_box(model: Model, box: int) -> float:
    """Return the volume [m³] of a box."""
    return model.box_size[box, 0] * model.box_size[box, 1] * model.box_size[box, 2]


@jit_lean
def _press(g: Vec, work: RingWork, body: int, filling: Filling, each: Vec, force: np.ndarray) -> None:
    """Add what a liquid in a body does to the `force` (n, 3) [N] on its particles, and `each` [N] to that on each."""
    origin, density = origin_of_rows(work), filling.density
    base = filling.pressure - density * filling.middle
    for i in range(0, work.rings.start[body + 1] - work.rings.start[body], LANES):
        pressure = base + density * dot(g, sub(place_of_rows(work, i), origin))
        on = scale(1.0 / 24.0, pressed(work, i, pressure, density))
        add_to_particles(work, body, i, add(on, each), force)


@jit
def filling_energies(model: Model, gravity: np.ndarray, state: State) -> tuple[float, float]:
    """Return what liquids in bodies add to the energy in gravity, and what it took to press them together [J].

    The first is Σ m g·(p − c), besides −Σ m g·x of the particles that can move: c is the centre of the liquid, and p
    that of the body's particles, of which those that are fixed count as at the origin.
    """
    weight, squeezed, g = 0.0, 0.0, (gravity[0], gravity[1], gravity[2])
    position = state.particle_position
    moving = Moving(position, position, 0.0)
    for body in range(model.soft_count):
        mass = liquid_mass(model, body)
        if mass > 0.0:
            first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
            triangles = model.triangle_particles[model.soft_triangle_start[body] : model.soft_triangle_start[body + 1]]
            origin = load(position, first)
            whole = _middle(g, moving, triangles, first)
            room, middle = _around_boxes(model, g, state.box_position, body, origin, whole)
            weight -= mass * (middle + dot(g, origin))
            for i in range(first, end):
                if model.particle_inverse_mass[i] > 0.0:
                    weight += mass / (end - first) * dot(g, load(position, i))
            part = room / (model.soft_mesh_volume[body] - model.soft_boxes_volume[body])
            if 0.0 < part < 1.0:
                squeezed += mass * square_of_sound(model, g, body) * (part - 1.0 - log(part))
    return weight, squeezed
