"""How fast bodies swing in liquids, and with liquids in them: for which a step can be too long."""

from __future__ import annotations

import numpy as np

from softbody.dynamics.filling import liquid_mass, square_of_sound
from softbody.dynamics.pressure import room_in
from softbody.model.arrays import Model, State


def feels_liquid(model: Model) -> bool:
    """Tell whether there is a liquid, around bodies or in one."""
    return bool(model.liquid_density > 0.0 or model.soft_liquid_density.any())


def liquid_rates(model: Model, g: np.ndarray, state: State) -> tuple[float, float]:
    """Return upper bounds of the highest frequency [1/s] and of the fastest damping rate [1/s] that liquids have.

    Of a particle with the area a around it, by the row sums of ∂F/∂x: ρ g a of the depth, and the pressure at the
    body's deepest point times those of ∂²V/∂x² (see softbody/dynamics/stability.py). A liquid in the body is no deeper
    than its extent d; it has 2 ρ g a d A / V more, with A of the whole body, as its density and centre go with all
    particles, and is pressed together at ω² = ρ c² Σ (a² / m) / V. Boxes inside, of a volume B, add ρ g a B / V, and
    have ρ g A B / V. Of a box in the world's liquid, whose points move by no more than 7 / m times its energy, twice:
    ρ g times its largest section; and ρ g V for how its centre of buoyancy turns about an axis, over the moment of
    inertia of which the lever is at most 3 / (m r).
    """
    if not feels_liquid(model):
        return 0.0, 0.0
    weight, drag = -model.liquid_density * float(g[2]), model.liquid_drag
    stiffness = damping = 0.0
    with np.errstate(all="ignore"):  # what is too much is inf
        corners = model.triangle_particles
        sides = state.particle_position[corners]
        area = np.zeros(len(model.particle_inverse_mass))
        bend = np.zeros_like(area)
        thirds = np.linalg.norm(np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0]), axis=1) / 6.0
        medians = np.linalg.norm(1.5 * (sides - sides.mean(axis=1, keepdims=True)), axis=2)
        for k in range(3):
            np.add.at(area, corners[:, k], thirds)
            np.add.at(bend, corners[:, k], (medians[:, k - 1] + medians[:, k - 2]) / 6.0)
        if model.soft_count:
            first = model.soft_particle_start[:-1]
            lowest = np.minimum.reduceat(state.particle_position, first)
            extent = np.linalg.norm(np.maximum.reduceat(state.particle_position, first) - lowest, axis=1)
            bodies = range(model.soft_count)
            volume = np.abs(np.array([room_in(model, state.particle_position, body) for body in bodies]))
            sound = np.array([square_of_sound(model, (g[0], g[1], g[2]), body) for body in bodies])
            filled = np.array([liquid_mass(model, body) for body in bodies]) / volume
            deepest = np.maximum(model.liquid_surface_height - lowest[:, 2], 0.0)
            whole, of_boxes = np.add.reduceat(area, first), model.soft_boxes_volume / volume
            lost = 2.0 * extent * whole / volume + of_boxes
            inside = filled * np.linalg.norm(g)
            pressed = sound * np.maximum(filled - model.soft_liquid_density, 0.0)
            together = np.add.reduceat(area**2 * model.particle_inverse_mass, first) * sound * filled / volume
            each = [deepest, inside * (1.0 + lost), inside * extent + pressed, together]
            each = [np.repeat(of, np.diff(model.soft_particle_start)) for of in each]
            forces = weight * (area + each[0] * bend) + each[1] * area + each[2] * bend
            stiffness = float((forces * model.particle_inverse_mass + each[3]).max())
            damping = float((drag * area * model.particle_inverse_mass).max())
            damping = max(damping, _drag_inside(model, state))
            stiffness = max(stiffness, _of_boxes_inside(model, inside * whole / volume))
        size = np.sort(model.box_size, axis=1)
        faces = np.column_stack([size[:, 0] * size[:, 1], size[:, 0] * size[:, 2], size[:, 1] * size[:, 2]])
        lever = 0.5 * np.hypot(size[:, 0], size[:, 1])
        of_boxes = 7.0 * np.linalg.norm(faces, axis=1) + 3.0 * size.prod(axis=1) / lever
        stiffness = max(stiffness, float((weight * of_boxes * model.box_inverse_mass).max(initial=0.0)))
        damping = max(damping, float((14.0 * drag * faces.sum(axis=1) * model.box_inverse_mass).max(initial=0.0)))
    return float(np.sqrt(stiffness)), damping


def _of_boxes_inside(model: Model, each: np.ndarray) -> float:
    """Return the greatest ω² [1/s²] of boxes inside soft bodies: `each` (b,) [kg/(m³ s²)] by its volume, over m."""
    host = model.box_host
    lightness = model.box_size.prod(axis=1) * model.box_inverse_mass
    return float((np.append(each, 0.0)[host] * lightness).max(initial=0.0))  # of nobody it is the last


def _drag_inside(model: Model, state: State) -> float:
    """Return a bound of the fastest rate [1/s] at which liquids drag boxes inside them, and they the liquids.

    Of a box as in a pool. A liquid of a mass M turns as its particles do: at a reach r it is the lighter by r² M / I.
    """
    fastest = 0.0
    for body in np.flatnonzero((model.soft_liquid_drag > 0.0) & (model.soft_boxes_volume > 0.0)).tolist():
        rows, boxes = slice(*model.soft_particle_start[body : body + 2]), model.box_host == body
        x, y, z = model.box_size[boxes].T
        drags = 2.0 * model.soft_liquid_drag[body] * (x * y + y * z + z * x)
        arms = state.particle_position[rows] - state.particle_position[rows].mean(axis=0)
        second, reach = arms.T @ arms, float(np.square(arms).sum(axis=1).max())
        least = max(np.trace(second) - np.linalg.norm(second, 2), 1e-300)
        of_liquid = model.particle_inverse_mass[rows].max() * (1.0 / len(arms) + reach / least)
        fastest = max(fastest, float((7.0 * drags * model.box_inverse_mass[boxes]).max() + drags.sum() * of_liquid))
    return fastest
