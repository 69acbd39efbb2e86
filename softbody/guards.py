"""May this world be stepped? What is looked at before a step and after the first one, and what a fault is called."""

from __future__ import annotations

import warnings
from math import ceil, inf, isfinite

import numpy as np

from softbody.collision.contact import NOBODY, Contacts
from softbody.collision.surface import Surfaces
from softbody.dynamics.integrators import STABILITY_LIMIT
from softbody.dynamics.soft_bodies import COLLAPSED
from softbody.dynamics.stability import highest_damping, highest_frequency, longest_stable_step
from softbody.errors import MassRatioWarning, OverlapWarning, ParameterError, SimulationError
from softbody.settings import Settings, integrator_name
from softbody.state import Controls, Model, State

STABLE_FOR = 100  # steps for which an estimate of the stable step is trusted; making one costs about a step
MOST_CARRIED = {"soft body": 1e4, "box": 1e6}  # times its own mass by a box; with more, it may be pressed through
TINY = np.finfo(float).tiny
DEEP = 0.1  # of the thickness of the thinner of two bodies, from which an overlap at the start is worth a warning


def check_finite(model: Model, controls: Controls, state: State) -> None:
    """Raise ParameterError for the first body of which a position, velocity or force is not finite."""
    for name, kind, rows in (
        ("position", "soft body", state.particle_position),
        ("velocity", "soft body", state.particle_velocity),
        ("external_force", "soft body", controls.particle_force),
        ("position", "box", state.box_position),
        ("orientation", "box", state.box_orientation),
        ("velocity", "box", state.box_velocity),
        ("angular_velocity", "box", state.box_angular_velocity),
        ("force", "box", controls.box_force),
        ("torque", "box", controls.box_torque),
    ):
        # A sum is quicker than a look at every number; it is finite only if they are.
        if len(rows) and not isfinite(rows.sum()) and not np.isfinite(rows).all():
            row = int(np.argmin(np.isfinite(rows).all(axis=1)))
            first = model.soft_particle_start if kind == "soft body" else np.arange(len(rows))
            body = int(np.searchsorted(first, row, side="right")) - 1
            where = f" of particle {row - first[body]}" if kind == "soft body" else ""
            raise ParameterError(f"{name}{where} of {kind} {body} is not finite: {rows[row]}; set it to numbers")


def stable_time_step(model: Model, controls: Controls, state: State, settings: Settings) -> float:
    """Return a time step [s] that is stable for every soft body as it is now; inf if there is none.

    From an upper bound of the highest frequency, so often a little shorter than need be. Contacts and motion that
    stretches a body further can ask for a shorter one.
    """
    limit, steps = STABILITY_LIMIT[settings.integrator], []
    for body in range(model.soft_count):
        frequency = highest_frequency(model, controls, state.particle_position, body)
        steps.append(longest_stable_step(frequency, highest_damping(model, body), limit))
    return min(steps, default=inf)


class StableStep:
    """An estimate of the stable step, kept as long as bodies, gas and integrator stay, and for STABLE_FOR steps."""

    def __init__(self) -> None:
        self._model: Model | None = None  # held on to: another one cannot come to lie in its place
        self._gas = b""
        self._integrator = -1
        self._made_at = 0
        self._seconds = inf

    def check(
        self, time_step: float, model: Model, controls: Controls, state: State, settings: Settings, steps: int
    ) -> None:
        """Raise ParameterError if a sub-step [s] is too long; `steps` that the world has done."""
        known = (
            self._model is model
            and self._gas == controls.soft_gas.tobytes()
            and self._integrator == settings.integrator
            and self._made_at <= steps < self._made_at + STABLE_FOR
        )
        if not known:
            self._seconds = stable_time_step(model, controls, state, settings)
            self._model, self._gas, self._integrator = model, controls.soft_gas.tobytes(), settings.integrator
            self._made_at = steps
        part = time_step / settings.substeps
        if part > self._seconds:
            raise ParameterError(
                f"time_step / substeps is {part:.6g} s, and a stable time step here is {self._seconds:.6g} s with "
                f"{integrator_name(settings)}: take that, or substeps={ceil(time_step / self._seconds)}, or say "
                "allow_unstable=True"
            )


def warn_of_overlap(model: Model, surfaces: Surfaces) -> None:
    """Warn of bodies whose deepest contact, of those noted, is a DEEP one."""
    depth, (box, particle) = float(surfaces.deepest[0]), surfaces.deepest_sides.T
    if not depth > 0.0:
        return
    of_soft = np.searchsorted(model.soft_particle_start, particle, side="right") - 1
    pair = np.sort(np.where(box == NOBODY, of_soft, model.soft_count + box))
    thickness = np.append(model.soft_thickness, model.box_size.min(axis=1))
    if depth > DEEP * thickness[pair].min():
        a, b = (name_of(model, int(k)) for k in pair)
        warnings.warn(
            f"{a} and {b} start {depth:.3g} m inside each other: they are pushed apart, from deep inside not all "
            "the way; move one of them first",
            OverlapWarning,
            stacklevel=4,
        )


def warn_of_mass_ratios(model: Model, controls: Controls, contacts: Contacts) -> None:
    """Warn of the box that, in the last step, carried most of those that carry more than MOST_CARRIED."""
    soft, count = model.soft_count, int(contacts.number[0])
    mass = masses(model)
    least = min(MOST_CARRIED.values())
    if not mass[mass < inf].max(initial=0.0) > least * mass[soft:].min(initial=inf):
        return
    # Who is above whom, of all contacts of a box with something that is not the ground.
    rows = np.flatnonzero(contacts.box[:count, 1] != NOBODY)
    of_soft = np.searchsorted(model.soft_particle_start, contacts.particles[rows, 0, 0], side="right") - 1
    a = np.where(contacts.box[rows, 0] == NOBODY, of_soft, soft + contacts.box[rows, 0])
    b = soft + contacts.box[rows, 1]
    steepness = contacts.normal[rows] @ -controls.gravity / max(float(np.linalg.norm(controls.gravity)), TINY)
    upper, lower = np.where(steepness > 0.0, [a, b], [b, a])
    most = np.where(upper < soft, MOST_CARRIED["soft body"], MOST_CARRIED["box"])
    carried = np.where(
        (np.abs(steepness) > 0.5) & (lower >= soft) & (mass[upper] < inf), mass[upper] / mass[lower], 0.0
    )
    if (carried > most).any():
        k = int(np.argmax(carried / most))
        warnings.warn(
            f"box {lower[k] - soft} carries {name_of(model, int(upper[k]))}, {carried[k]:.3g} times its own mass, and "
            f"may be pressed through what it stands on; up to {most[k]:.0e} times are held: make it heavier, or static",
            MassRatioWarning,
            stacklevel=3,
        )


def masses(model: Model) -> np.ndarray:
    """Return the mass [kg] of each soft body, then of each box; inf for what is fixed."""
    starts = model.soft_particle_start
    inverse = np.maximum.reduceat(model.particle_inverse_mass, starts[:-1]) if model.soft_count else np.zeros(0)
    with np.errstate(divide="ignore"):
        return 1.0 / np.append(inverse / np.diff(starts), model.box_inverse_mass)


def name_of(model: Model, body: int) -> str:
    """Return what messages call a body, boxes numbered after soft bodies."""
    return f"soft body {body}" if body < model.soft_count else f"box {body - model.soft_count}"


def fault_of(fault: int, body: int, model: Model, part: float, stable: float, steps: int) -> SimulationError:
    """Return what to raise for a soft body that DIVERGED or COLLAPSED in sub-steps of `part` [s], after `steps`."""
    what = "diverged"
    if fault == COLLAPSED:
        least = model.soft_deflated_below[body] * model.soft_mesh_volume[body]
        what = f"collapsed (deflated to {least:.3g} m³ or less)" if least else "collapsed (no volume left)"
    cure = (
        f"a stable time step here is {stable:.3g} s, not {part:.3g} s"
        if part > stable
        else "its gas is too weak or its load too strong for its springs; raise gas or stiffness"
    )
    return SimulationError(
        f"soft body {body} {what} in step {steps}; {cure}. The state is the last good one.",
        steps,
        f"soft body {body}",
        stable,
    )
