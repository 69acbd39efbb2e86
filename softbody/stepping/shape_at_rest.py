"""Shape of one soft body of a world at rest, alone."""

from __future__ import annotations

from math import hypot, inf

import numpy as np

from softbody.bodies.builder import Parts, soft_body_alone
from softbody.compiler.interrupts import assign_together, listening
from softbody.dynamics.equilibrium import glide_from_rest, relax
from softbody.dynamics.liquid_rates import liquid_rates
from softbody.dynamics.soft_bodies import Motion, motion_of
from softbody.dynamics.stability import highest_frequency
from softbody.errors import SimulationError
from softbody.model.arrays import Controls, Model, SoftBodies, soft_bodies_of
from softbody.model.validation import check_range, check_whole
from softbody.stepping.runner import Runner

ROUND = 500  # steps of relaxation between two looks at what is left and at the stable step


def _relax_round(model: Model, bodies: SoftBodies, motion: Motion, longest: float, steps: int) -> float:
    """Relax by `steps` steps, and let signals be handled on the way; return the largest acceleration [m/s²] left."""
    glide = glide_from_rest(bodies.position, longest)
    with listening() as flag:
        motion = motion._replace(memory=motion.memory._replace(stop=flag.is_set))
        left = inf
        while steps:
            flag.clear()
            left, steps = relax(model, bodies, motion, longest, steps, glide)
    return left


def _is_pulled(model: Model, controls: Controls) -> bool:
    """Tell whether weight or a force of the user's acts on a particle that can move."""
    is_free = model.particle_inverse_mass > 0.0
    force = controls.particle_force
    return bool(is_free.any() and (controls.gravity.any() or (len(force) and force[is_free].any())))


def shape_at_rest(parts: Parts, body: int, tolerance: float, steps: int) -> tuple[np.ndarray, float]:
    """Return the positions (n, 3) [m] of a soft body at rest, and what is left to relax, as a multiple of `tolerance`.

    It hangs on its fixed particles, or floats without weight. That is the largest acceleration of a particle, in one
    component, times the least mass of one, over the body's stiffness and size; > 1: it is not at rest after `steps`.
    """
    model, controls, state, rings, _ = soft_body_alone(parts, body)
    is_held = (model.particle_inverse_mass == 0.0).any()
    controls = controls._replace(gravity=controls.gravity if is_held else np.zeros(3))
    position = state.particle_position.copy()
    state = state._replace(particle_position=position, particle_velocity=np.zeros_like(position))
    bodies, motion = soft_bodies_of(model, controls, state), motion_of(model.soft_particle_start, rings)
    left, enough = np.inf, 0.0
    for done in range(0, steps, ROUND):
        # Half of the stable step of symplectic Euler: where the mixing adds, less is more.
        frequency = hypot(
            highest_frequency(model, controls, position, 0), *liquid_rates(model, controls.gravity, state)
        )
        if frequency == 0.0:  # neither springs nor gas: it stays as it is, or falls for ever
            return position, inf if _is_pulled(model, controls) else 0.0
        left = _relax_round(model, bodies, motion, 1.0 / frequency, min(steps - done, ROUND))
        size = np.ptp(position, axis=0).max()
        enough = tolerance * model.edge_stiffness.max() * size * model.particle_inverse_mass.max()
        if not left > enough:
            break
    return position, 1.0 if left <= enough else left / enough


def equilibrium(runner: Runner, tolerance: float, steps: int) -> None:
    """Do what `World.equilibrium` says."""
    store = runner.store
    tolerance, steps = check_range(tolerance, "tolerance", above=0.0), check_whole(steps, "steps", 1)
    with store.exclusive():
        positions = store.state.particle_position.copy()
        for body in range(store.model.soft_count):
            shape, left = shape_at_rest(store.parts, body, tolerance, steps)
            if not left <= 1.0:
                title = store.names.title(("soft", body))
                raise SimulationError(
                    f"{title} is not at rest after {steps} steps: a force of {left:.3g} × the tolerance is left; allow "
                    "more steps, or see that external forces cancel or fixed particles hold them",
                    store.steps,
                    f"soft body {body}",
                    runner.stable_time_step(),
                )
            positions[slice(*store.model.soft_particle_start[body : body + 2])] = shape
        assign_together((store.state.particle_position, positions), (store.state.particle_velocity, 0.0))
