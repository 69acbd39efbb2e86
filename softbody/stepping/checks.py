"""Checks of a world before a step and after the first one, and the names of faults."""

from __future__ import annotations

from math import ceil, hypot, inf, isfinite

import numpy as np

from softbody.bodies.names import Names, Who
from softbody.bodies.tearing import has_torn, may_tear
from softbody.collision.contact import Contacts
from softbody.collision.pressed import FIRST, GONE_THROUGH, NOW, Pressed
from softbody.collision.soft.surface import Surfaces
from softbody.dynamics.integrators import STABILITY_LIMIT
from softbody.dynamics.joint_forces import joint_rates, no_joints
from softbody.dynamics.liquid_forces import corners_of
from softbody.dynamics.liquid_rates import feels_liquid, liquid_rates
from softbody.dynamics.pressure import soft_volume
from softbody.dynamics.rigid_boxes import MOST_TURN, RESOLVED, UNIT
from softbody.dynamics.soft_bodies import COLLAPSED
from softbody.dynamics.stability import longest_stable_step, shortest_stable_step
from softbody.errors import (
    MassRatioWarning,
    OverlapWarning,
    OverloadWarning,
    ParameterError,
    SimulationError,
    warn_user,
)
from softbody.geometry.polyhedron import point_in_polyhedron
from softbody.model.arrays import NOBODY, Controls, Joints, Model, State
from softbody.model.settings import Settings, integrator_name

STABLE_FOR = 100  # steps for which an estimate of the stable step is trusted; making one costs about a step
MOST_CARRIED = {"soft body": 1e4, "box": 1e6}  # times its own mass by a box; with more, it may be pressed through
TINY = np.finfo(float).tiny
DEEP = 0.1  # of the thickness of the thinner of two bodies, from which an overlap at the start is worth a warning


def check_finite(model: Model, controls: Controls, state: State, joints: Joints) -> None:
    """Raise ParameterError for the first body, or joint, of which a position, velocity or force is not finite."""
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
        ("target", "joint", joints.joint_place),
    ):
        # A sum is quicker than a look at every number; it is finite only if they are.
        if len(rows) and not isfinite(np.add.reduce(rows, None)) and not np.isfinite(rows).all():
            row = int(np.argmin(np.isfinite(rows).all(axis=1)))
            first = model.soft_particle_start if kind == "soft body" else np.arange(len(rows))
            body = int(np.searchsorted(first, row, side="right")) - 1
            where = f" of particle {row - first[body]}" if kind == "soft body" else ""
            raise ParameterError(f"{name}{where} of {kind} {body} is not finite: {rows[row]}; set it to numbers")


def stable_time_step(model: Model, controls: Controls, state: State, settings: Settings, of_forces: float) -> float:
    """Return a time step [s] stable for every soft body as it is now, all joints and liquids; inf if there is none.

    `of_forces` is what `longest_step_of_forces` says.
    From an upper bound of the highest frequency, so often a little shorter than need be. Contacts and motion that
    stretches a body further can ask for a shorter one. Raises ParameterError where no step is stable.
    """
    limit = STABILITY_LIMIT[settings.integrator]
    shortest, unstable = shortest_stable_step(model, controls, state.particle_position, limit)
    if unstable >= 0:
        raise ParameterError(f"no time step is stable: {_unstable(model, controls, state, unstable)}")
    if not of_forces > 0.0:
        if feels_liquid(model) and not longest_step_of_liquid(model, controls, state) > 0.0:
            raise ParameterError(
                "no time step is stable: a liquid is too dense, or its drag too great, for what is in it or around it; "
                "make that heavier"
            )
        raise ParameterError(
            "no time step is stable: joints are too stiff, damp too much, or are too far out on boxes, for what they "
            "hold; make them softer, or what they hold heavier"
        )
    # A joint and what it is on swing no faster than √(ω² of both).
    shorter, longer = sorted((float(shortest), of_forces))
    return shorter / hypot(1.0, shorter / longer) if longer < inf else shorter


def longest_step_of_forces(model: Model, controls: Controls, state: State, joints: Joints) -> float:
    """Return the longest step [s] for joints and liquids: half of ω h = 2, which is stable; inf if there are none."""
    frequency, damping = joint_rates(joints, model) if len(joints.joint_box) else (0.0, 0.0)
    of_liquid, drag = liquid_rates(model, controls.gravity, state)
    return float(longest_stable_step(hypot(frequency, of_liquid), damping + drag, 1.0))


def longest_step_of_liquid(model: Model, controls: Controls, state: State) -> float:
    """Return the same for liquids alone."""
    return longest_step_of_forces(model, controls, state, no_joints())


def _unstable(model: Model, controls: Controls, state: State, body: int) -> str:
    """Say why a soft body has no stable time step, and what to do."""
    volume = soft_volume(model, state.particle_position, body)
    if not isfinite(volume):
        return (
            f"the particles of soft body {body} are not finite, or too far apart to compute its volume; put them back"
        )
    if volume == 0.0:
        return f"soft body {body} is flat and has no volume; put its particles back in place"
    return (
        f"soft body {body} is too light for its springs, gas and damping, {controls.soft_gas[body]:.3g} J in "
        f"{volume:.3g} m³; give it more mass, or less of those"
    )


class StableStep:
    """An estimate of the stable step, kept as long as bodies, gas and integrator stay, and for STABLE_FOR steps.

    It is made anew, too, where somebody has moved particles since the last step, and before a step is refused.
    """

    def __init__(self) -> None:
        self._model: Model | None = None  # held on to: another one cannot come to lie in its place
        self._joints: Joints | None = None
        self._acting = b""  # gas, and where there are liquids gravity
        self._integrator = -1
        self._made_at = 0
        self._seconds = self._of_forces = inf

    def allows(
        self, time_step: float, model: Model, controls: Controls, settings: Settings, joints: Joints, steps: int
    ) -> bool:
        """Tell whether a step [s] is known to be stable, if nobody has moved particles; `steps` done so far."""
        if not _may_be_too_long(model, joints):
            return True
        return (
            self._model is model
            and self._joints is joints
            and time_step / settings.substeps <= self._seconds
            and time_step <= self._of_forces
            and self._made_at <= steps < self._made_at + STABLE_FOR
            and self._integrator == settings.integrator
            and self._acting == _acting(model, controls)
        )

    def check(
        self,
        time_step: float,
        model: Model,
        controls: Controls,
        state: State,
        settings: Settings,
        joints: Joints,
        steps: int,
    ) -> None:
        """Make the estimate anew; raise ParameterError if a sub-step [s] is too long."""
        if not _may_be_too_long(model, joints):
            return
        is_known = self._model is model and self._joints is joints and not feels_liquid(model)
        self._model = None  # until all that follows is as new
        if not is_known:
            self._of_forces = longest_step_of_forces(model, controls, state, joints)
        self._seconds = stable_time_step(model, controls, state, settings, self._of_forces)
        self._acting, self._integrator, self._made_at = _acting(model, controls), settings.integrator, steps
        self._model, self._joints = model, joints
        part = time_step / settings.substeps
        if not time_step <= self._of_forces:
            who, cure = "joints allow", "make joints softer or what they hold heavier"
            if time_step > longest_step_of_liquid(model, controls, state):
                who, cure = "liquids allow", "make what is in them or around them heavier, or their drag less"
            raise ParameterError(
                f"time_step is {time_step:.6g} s, and {who} {self._of_forces:.6g} s here, with any substeps: "
                f"take that, {cure}, or say allow_unstable=True"
            )
        if not part <= self._seconds:
            raise ParameterError(
                f"time_step / substeps is {part:.6g} s, and a stable time step here is {self._seconds:.6g} s with "
                f"{integrator_name(settings)}: take that, {_in_parts(time_step / self._seconds)}or say "
                "allow_unstable=True"
            )


def _may_be_too_long(model: Model, joints: Joints) -> bool:
    """Tell whether there is something for which a step can be too long."""
    return bool(model.soft_count or len(joints.joint_box) or feels_liquid(model))


def _acting(model: Model, controls: Controls) -> bytes:
    """Return what of the controls a stable step depends on."""
    return controls.soft_gas.tobytes() + (controls.gravity.tobytes() if feels_liquid(model) else b"")


def _in_parts(parts: float) -> str:
    """Return the sub-steps that make a step stable, if there are not too many."""
    return f"or substeps={ceil(parts)}, " if parts < 2.0**53 else ""


def helpful_step(
    model: Model, controls: Controls, state: State, settings: Settings, joints: Joints, body: int
) -> tuple[float, str]:
    """Return a time step [s] that helps a body that has diverged, as it was before, or 0 and why none does.

    It is stable for all soft bodies, and no particle of any crosses half of its body, as seen from its middle. No box
    moves by more than its size, or turns by more than a radian: or another one would diverge next.
    """
    try:
        stable = stable_time_step(
            model, controls, state, settings, longest_step_of_forces(model, controls, state, joints)
        )
    except ParameterError as error:
        return 0.0, str(error)
    for soft in range(model.soft_count):
        rows = slice(*model.soft_particle_start[soft : soft + 2])
        extent = float(np.ptp(state.particle_position[rows], axis=0).max())
        velocity = state.particle_velocity[rows]
        with np.errstate(all="ignore"):
            speed = float(np.abs(velocity - velocity.mean(axis=0)).max())
        stable = min(stable, 0.5 * extent / speed if speed > 0.0 else inf)
    size = model.box_size.min(axis=1)
    with np.errstate(all="ignore"):
        push = np.abs(controls.gravity + model.box_inverse_mass[:, None] * controls.box_force).max(axis=1)
        twist = model.box_inverse_inertia.max(axis=1) * np.abs(controls.box_torque).max(axis=1)
        speed, spin = (np.abs(rows).max(axis=1) for rows in (state.box_velocity, state.box_angular_velocity))
        each = np.array([size / speed, np.sqrt(size / push), 1.0 / spin, np.sqrt(1.0 / twist)])
    longest = float(np.fmin.reduce(each, axis=None, initial=stable))
    return longest if 0.0 < longest < inf else 0.0, ""


def check_box_motion(model: Model, state: State, h: float, box: int) -> None:
    """Raise ParameterError if a box is, before any step of `h` [s], where or as fast as nothing can be computed."""
    size, position = model.box_size[box], state.box_position[box]
    spin, speed = hypot(*state.box_angular_velocity[box]), hypot(*state.box_velocity[box])
    if abs(float(np.square(state.box_orientation[box]).sum()) - 1.0) > UNIT:
        raise ParameterError(
            f"orientation of box {box} is {state.box_orientation[box]}: no unit quaternion; divide it by its length"
        )
    if not np.abs(position).sum() <= RESOLVED * size.min():
        raise ParameterError(f"position of box {box} is {position}: so far away that its size is lost in rounding")
    if not h * np.abs(state.box_angular_velocity[box]).sum() <= MOST_TURN:
        raise ParameterError(
            f"angular_velocity of box {box} is {spin:.3g} rad/s, too fast for a step of {h:.3g} s, in which at most "
            f"{MOST_TURN:.0e} rad are computed; take a time step up to {MOST_TURN / spin / 2.0:.3g} s"
        )
    if not np.abs(position).sum() + h * np.abs(state.box_velocity[box]).sum() <= RESOLVED * size.min():
        raise ParameterError(
            f"velocity of box {box} is {speed:.3g} m/s, which a step of {h:.3g} s takes so far away that its size is "
            f"lost in rounding; take a shorter time step, such as {size.min() / speed:.3g} s"
        )


def warn_of_overlap(model: Model, surfaces: Surfaces, names: Names) -> None:
    """Warn of bodies whose deepest contact, of those noted, is a DEEP one."""
    depth = float(surfaces.deepest[0])
    if not depth > 0.0:
        return
    pair = np.array(sides_of(model, surfaces.deepest_sides))
    thickness = np.append(model.soft_thickness, model.box_size.min(axis=1))
    if depth > DEEP * thickness[pair].min():
        a, b = (title_of(model, int(k), names) for k in pair)
        warn_user(
            f"{a} and {b} start {depth:.3g} m inside each other: they are pushed apart, from deep inside not all "
            f"the way; {_parted(pair, model)}",
            OverlapWarning,
        )


def _parted(pair: np.ndarray, model: Model) -> str:
    """Say what a user can do for a pair that starts inside each other."""
    body, box = int(pair[0]), int(pair[1]) - model.soft_count
    if body >= model.soft_count or box < 0:
        return "move one of them first"
    if model.box_host[box] == body:
        return "move the box in first, or let its inside be None"
    return "move one of them first, or say inside= if the box is to be in there"


def sides_of(model: Model, sides: np.ndarray) -> tuple[int, int]:
    """Return the bodies on both `sides` (2, 2) of a contact, box and particle each; −1 is the ground."""
    box, particle = sides.T
    of_soft = np.where(particle == NOBODY, -1, np.searchsorted(model.soft_particle_start, particle, side="right") - 1)
    one, other = np.sort(np.where(box == NOBODY, of_soft, model.soft_count + box))
    return int(one), int(other)


def pairs_inside(model: Model, contacts: Contacts) -> set[tuple[int, int]]:
    """Return who is with whom in contacts that are DEEP, for the thinnest body that there is."""
    thinnest = min(model.soft_thickness.min(initial=inf), model.box_size.min(initial=inf))
    rows = np.flatnonzero(contacts.depth[: contacts.number[0]] > DEEP * thinnest)
    return {sides_of(model, np.stack([contacts.box[k], contacts.particles[k, :, 0]], axis=1)) for k in rows}


def warn_of_pressed(pressed: Pressed, pair: tuple[int, int], model: Model, names: Names) -> None:
    """Warn of a pair that is pressed deep into each other."""
    part = float(pressed.part[FIRST])
    limit = f"{GONE_THROUGH:.0%} would be an error" if part < GONE_THROUGH else "they may go through each other"
    warn_user(
        f"{_pressed(pressed, FIRST, pair, model, names)} since step {pressed.step[0]}: {part:.0%} of "
        f"{_room_of(pair, model)}, and {limit}; {_press_less(pair, model)}",
        OverloadWarning,
    )


def pressed_through(pressed: Pressed, model: Model, steps: int, names: Names) -> SimulationError:
    """Return what to raise where bodies would be pressed through each other, after `steps`."""
    pair = sides_of(model, pressed.sides[NOW])
    return SimulationError(
        f"{_pressed(pressed, NOW, pair, model, names)} in step {steps}: more than {GONE_THROUGH:.0%} of "
        f"{_room_of(pair, model)}, and they would go through; {_press_less(pair, model)}. "
        "The state is the last good one.",
        steps,
        title_of(model, max(pair), Names()),
        0.0,
    )


def warn_of_what_is_out(model: Model, state: State, told: set[int], names: Names) -> None:
    """Warn of boxes that are outside of the soft body that they are to be inside: of each once, by `told`."""
    for box in np.flatnonzero(model.box_host != NOBODY).tolist():
        if box not in told:
            host, corners = int(model.box_host[box]), corners_of(model, state, box)
            triangles = model.triangle_particles[slice(*model.soft_triangle_start[host : host + 2])]
            if not any(point_in_polyhedron(tuple(p), state.particle_position, triangles) for p in corners):
                told.add(box)
                where, out = (title_of(model, k, names) for k in (host, model.soft_count + box))
                x, y, z = state.box_position[box]
                warn_user(
                    f"{out}, at ({x:.3g}, {y:.3g}, {z:.3g}) m, is outside of {where}, which it is to be inside: what "
                    "of them touches draws it back; put it in, or let its inside be None",
                    OverloadWarning,
                )


def _room_of(pair: tuple[int, int], model: Model) -> str:
    """Say of what a part tells how deep a pair is pressed into each other."""
    return "two edges of their meshes, or of a thickness" if _both_soft(pair, model) else "the thinner one's thickness"


def _press_less(pair: tuple[int, int], model: Model) -> str:
    """Say what a user can do for a pair that is pressed too deep into each other."""
    firmer = "fill them with more gas" if _both_soft(pair, model) else "make the thinner one thicker"
    return f"take a shorter time step, {firmer}, or press less"


def _both_soft(pair: tuple[int, int], model: Model) -> bool:
    return min(pair) >= 0 and max(pair) < model.soft_count


def _pressed(pressed: Pressed, row: int, pair: tuple[int, int], model: Model, names: Names) -> str:
    """Say who is pressed into each other, how deep, where and by what."""
    one, other = ("the ground" if k < 0 else title_of(model, k, names) for k in pair)
    x, y, z = pressed.point[row]
    return (
        f"{other} and {one} are pressed {pressed.depth[row]:.3g} m into each other, at ({x:.3g}, {y:.3g}, {z:.3g}) m "
        f"by {pressed.force[row]:.3g} N"
    )


def may_carry_too_much(model: Model) -> bool:
    """Tell whether a box is so much lighter than something else that it could not carry it."""
    mass = masses(model)
    return bool(
        mass[mass < inf].max(initial=0.0) > min(MOST_CARRIED.values()) * mass[model.soft_count :].min(initial=inf)
    )


def warn_of_mass_ratios(model: Model, controls: Controls, contacts: Contacts, names: Names) -> None:
    """Warn of the box that, in the last step, carried most of those that carry more than MOST_CARRIED."""
    soft, count = model.soft_count, int(contacts.number[0])
    mass = masses(model)
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
        under, above = (title_of(model, int(each[k]), names) for each in (lower, upper))
        warn_user(
            f"{under} carries {above}, {carried[k]:.3g} times its own mass, and may be pressed through what it stands "
            f"on; up to {most[k]:.0e} times are held: make it heavier, or static",
            MassRatioWarning,
        )


def masses(model: Model) -> np.ndarray:
    """Return the mass [kg] of each soft body, then of each box; inf for what is fixed."""
    starts = model.soft_particle_start
    inverse = np.maximum.reduceat(model.particle_inverse_mass, starts[:-1]) if model.soft_count else np.zeros(0)
    with np.errstate(divide="ignore"):
        return 1.0 / np.append(inverse / np.diff(starts), model.box_inverse_mass)


def check_may_tear(model: Model, joints: Joints, names: Names) -> None:
    """Raise ParameterError where a body that may tear, or has torn, is or holds what cannot be torn."""
    tears = may_tear(model)
    if not tears.any():
        return
    hosts = np.zeros(model.soft_count, bool)
    hosts[model.box_host[model.box_host != NOBODY]] = True
    hangs = np.isin(model.soft_particle_start[:-1], joints.suspension_particles[:, 0])
    causes = (
        (model.soft_self_contact != 0.0, "it has self_contact; set that to False"),
        (model.soft_liquid_density > 0.0, "it is full of liquid; set its liquid_density to 0"),
        (hosts, "a box is inside it; let that box's inside be None"),
        (hangs, "something hangs in it; remove that suspension"),
        (np.full(model.soft_count, model.liquid_density > 0.0), "there is a liquid around it; set its density to 0"),
    )
    for has, cause in causes:
        if (tears & has).any():
            title = names.title(("soft", int(np.argmax(tears & has))))
            raise ParameterError(
                f"{title} may tear, or has torn, and {cause}, or its tear_at to 0: not both are computed"
            )


def may_lie_flat(model: Model, controls: Controls) -> Model:
    """Return a model in which no body collapses that may lie flat: without gas and holding itself, or torn."""
    is_flat = ((model.soft_self_contact > 0.0) & (controls.soft_gas == 0.0)) | has_torn(model)
    if not is_flat.any():
        return model
    return model._replace(soft_deflated_below=np.where(is_flat, -np.inf, model.soft_deflated_below))


def who_is(model: Model, body: int) -> Who:
    """Return the kind and number of a body, boxes numbered after soft bodies."""
    return ("soft", body) if body < model.soft_count else ("box", body - model.soft_count)


def title_of(model: Model, body: int, names: Names) -> str:
    """Return what messages call a body, boxes numbered after soft bodies."""
    return names.title(who_is(model, body))


def fault_of(
    fault: int, body: int, model: Model, part: float, advice: tuple[float, str], steps: int, names: Names
) -> SimulationError:
    """Return what to raise for a body that DIVERGED or COLLAPSED in sub-steps of `part` [s], after `steps`.

    `advice` is what `helpful_step` says.
    """
    stable, why = advice
    what = "diverged"
    if fault == COLLAPSED:
        least = max(model.soft_deflated_below[body] * model.soft_mesh_volume[body], model.soft_boxes_volume[body])
        what = f"collapsed (deflated to {least:.3g} m³ or less)" if least else "collapsed (no volume left)"
    if part > stable > 0.0:
        cure = f"a stable time step here is {stable:.3g} s, not {part:.3g} s"
    elif body >= model.soft_count:
        cure = "it meets, or a joint ties it to, something far too heavy, fast or far; make those less unlike"
    elif fault == COLLAPSED:
        cure = "its gas is too weak or its load too strong for its springs; raise gas or stiffness"
    else:
        cure = why or "its loads are too strong for its springs, or it is too light for them; change those"
    return SimulationError(
        f"{title_of(model, body, names)} {what} in step {steps}; {cure}. The state is the last good one.",
        steps,
        title_of(model, body, Names()),
        stable,
    )
