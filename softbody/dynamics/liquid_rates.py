"""How fast bodies swing in liquids, and with liquids in them: for which a step can be too long."""

from __future__ import annotations

import numpy as np

from softbody.dynamics.filling import square_of_sound
from softbody.dynamics.pressure import soft_volume
from softbody.model.arrays import Model, State


def feels_liquid(model: Model) -> bool:
    """Tell whether there is a liquid, around bodies or in one."""
    return bool(model.liquid_density > 0.0 or model.soft_liquid_density.any())


def liquid_rates(model: Model, g: np.ndarray, state: State) -> tuple[float, float]:
    """Return upper bounds of the highest frequency [1/s] and of the fastest damping rate [1/s] that liquids have.

    Of a particle with the area a around it, by the row sums of ∂F/∂x: ρ g a of the depth, and the pressure at the
    body's deepest point times those of ∂²V/∂x² (see softbody/dynamics/stability.py). A liquid in the body is no deeper
    than its extent d; it has 2 ρ g a d A / V more, with A of the whole body, as its density and centre go with all
    particles, and is pressed together at ω² = ρ c² Σ (a² / m) / V. Of a box, whose points move by no more than 7 / m
    times its energy, twice: ρ g times its largest section; and ρ g V for how its centre of buoyancy turns about an
    axis, over the moment of inertia of which the lever is at most 3 / (m r).
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
            volume = np.abs(np.array([soft_volume(model, state.particle_position, body) for body in bodies]))
            sound = np.array([square_of_sound(model, (g[0], g[1], g[2]), body) for body in bodies])
            filled = model.soft_liquid_density * model.soft_mesh_volume / volume
            deepest = np.maximum(model.liquid_surface_height - lowest[:, 2], 0.0)
            lost = 2.0 * extent * np.add.reduceat(area, first) / volume
            inside = filled * np.linalg.norm(g)
            pressed = sound * np.maximum(filled - model.soft_liquid_density, 0.0)
            together = np.add.reduceat(area**2 * model.particle_inverse_mass, first) * sound * filled / volume
            each = [deepest, inside * (1.0 + lost), inside * extent + pressed, together]
            each = [np.repeat(of, np.diff(model.soft_particle_start)) for of in each]
            forces = weight * (area + each[0] * bend) + each[1] * area + each[2] * bend
            stiffness = float((forces * model.particle_inverse_mass + each[3]).max())
            damping = float((drag * area * model.particle_inverse_mass).max())
        size = np.sort(model.box_size, axis=1)
        faces = np.column_stack([size[:, 0] * size[:, 1], size[:, 0] * size[:, 2], size[:, 1] * size[:, 2]])
        lever = 0.5 * np.hypot(size[:, 0], size[:, 1])
        of_boxes = 7.0 * np.linalg.norm(faces, axis=1) + 3.0 * size.prod(axis=1) / lever
        stiffness = max(stiffness, float((weight * of_boxes * model.box_inverse_mass).max(initial=0.0)))
        damping = max(damping, float((14.0 * drag * faces.sum(axis=1) * model.box_inverse_mass).max(initial=0.0)))
    return float(np.sqrt(stiffness)), damping
