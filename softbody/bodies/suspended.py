"""Points that hang in a soft body of a World: a handle, what carries them, and how a box hangs on them."""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from softbody.bodies.body import Body
from softbody.bodies.builder import Parts, end_inside, end_on_box, with_box_inside, with_joint, with_suspension
from softbody.bodies.rigid_box import Box
from softbody.bodies.soft_body import SoftBody
from softbody.dynamics.integrators import STABILITY_LIMIT
from softbody.dynamics.joint_forces import carried, joint_rates, no_joints, weights_of
from softbody.dynamics.stability import highest_damping, highest_frequency, longest_stable_step
from softbody.errors import ParameterError
from softbody.geometry import points_in_mesh
from softbody.geometry.box import corner_signs
from softbody.geometry.mean_value import mean_value_weights, tetrahedron_weights
from softbody.model.arrays import NOBODY
from softbody.model.settings import Settings
from softbody.model.validation import NO_NUMBERS, doubles, shown

WEIGHTS = {"mean-value": mean_value_weights, "tetrahedron": tetrahedron_weights}

LONGEST = 1.0 / 240.0  # [s] of a step for which what a box hangs by is made, where that of the soft body is longer


class Suspended(Body):
    """Points that hang in a soft body, carried by weights of all its particles; see `World.suspend`."""

    __slots__ = ()

    kind = "suspension"

    def _count(self) -> int:
        return len(self.store.joints.suspension_box)

    def __len__(self) -> int:
        """Return how many points there are."""
        return len(self.weights)

    def __repr__(self) -> str:
        """Say which it is, how many points, and in which body."""
        if not self.is_there:
            return "<suspension that is gone>"
        return f"<{self._title()}: {len(self)} points in soft body {self.body.index}>"

    @property
    def body(self) -> SoftBody:
        """The soft body that carries them."""
        first = self.store.joints.suspension_particles[self.row(), 0]
        start = self.store.model.soft_particle_start
        return SoftBody(self.world, int(np.searchsorted(start, first, side="right")) - 1)

    @property
    def box(self) -> Box | None:
        """The box that hangs by them, at its corners; None for points alone."""
        box = int(self.store.joints.suspension_box[self.row()])
        return None if box == NOBODY else Box(self.world, box)

    @property
    def weights(self) -> np.ndarray:
        """Weights (k, n) of the body's particles for each point, read-only: each row sums to 1."""
        view = weights_of(self.store.joints, self.row())
        view.flags.writeable = False
        return view

    @property
    def positions(self) -> np.ndarray:
        """Where the points are now (k, 3) [m]: Σ w x."""
        return carried(self.store.joints, self.row(), self.store.state.particle_position)

    @property
    def velocities(self) -> np.ndarray:
        """Velocities of the points (k, 3) [m/s]: Σ w v."""
        return carried(self.store.joints, self.row(), self.store.state.particle_velocity)


def checked_points(what: ArrayLike) -> np.ndarray:
    """Return points (k, 3) [m], of which there is one at least, as a new array; raises ParameterError."""
    try:
        points = doubles(what)
    except NO_NUMBERS as error:
        raise ParameterError(f"what is {shown(what)}; give a box of this world, or points (k, 3) [m]") from error
    points = points.reshape(1, 3) if points.shape == (3,) else points
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise ParameterError(f"what has shape {points.shape}; give a box of this world, or points (k, 3) [m]")
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        raise ParameterError(
            f"point {np.argmin(finite)} of what is {points[np.argmin(finite)]}; give finite numbers [m]"
        )
    return points


def weights_in(body: SoftBody, points: np.ndarray, weights: str, called: str) -> np.ndarray:
    """Return the weights (k, n) of `points` (k, 3) [m] in a soft body, by their name.

    `called`: one of them in words, with {} for its number.

    Raises ParameterError for a name that there is none of, and for points that are not inside.
    """
    if not isinstance(weights, str) or weights not in WEIGHTS:
        raise ParameterError(f"weights is {shown(weights)}; choose from {', '.join(WEIGHTS)}")
    vertices, triangles = body.positions, body.triangles
    inside = points_in_mesh(points, vertices, triangles)
    if not inside.all():
        k = int(np.argmin(inside))
        raise ParameterError(
            f"{called.format(k)}, at {points[k]} m, is not inside {body!r}: move it in, or take a larger body"
        )
    found = WEIGHTS[weights](points, vertices, triangles)
    nowhere = np.isnan(found[:, 0])
    if nowhere.any():
        k = int(np.argmax(nowhere))
        raise ParameterError(
            f"{called.format(k)}, at {points[k]} m, is in no tetrahedron of {body!r}: let weights be 'mean-value'"
        )
    return found


def with_box_hung(
    parts: Parts,
    settings: Settings,
    pair: tuple[int, int],
    weights: np.ndarray,
    stiffness: float | None,
    damping: float | None,
) -> Parts:
    """Return the parts where a box hangs in a soft body, `pair` (body, box), by eight joints of its corners.

    `weights` (8, n) of the corners; `stiffness` [N/m] and `damping` [N s/m] of each joint. By default they are as stiff
    as they may be while the step that is stable for the soft body alone is so for them. By the bounds of `joint_rates`
    joints of k and c have ω = Ω √k and γ = Ω² c, where Ω is that of 1 N/m; c is critical for the fastest, 2 √k / Ω.
    Raises ParameterError where neither can move.
    """
    parts = with_box_inside(parts, pair[1], pair[0])
    if stiffness is None or damping is None:
        alone = _hung(parts._replace(joints=no_joints()), pair, weights, 1.0, 0.0)
        one, _ = joint_rates(alone.joints, parts.model)
        if not one > 0.0:
            raise ParameterError(
                f"box {pair[1]} has no mass, and all that carries it is fixed; give stiffness and damping"
            )
        if stiffness is None:
            # ω h where (ω h)² + γ h / 2 = 1 and γ = 2 ω.
            step = min(_stable_step(parts, settings, pair[0]), LONGEST)
            stiffness = ((sqrt(1.25) - 0.5) / (one * step)) ** 2
        damping = 2.0 * sqrt(stiffness) / one if damping is None else damping
    return _hung(parts, pair, weights, stiffness, damping)


def _stable_step(parts: Parts, settings: Settings, body: int) -> float:
    """Return a step [s] that is stable for a soft body alone."""
    frequency = highest_frequency(parts.model, parts.controls, parts.state.particle_position, body)
    damping = highest_damping(parts.model, body)
    return settings.substeps * longest_stable_step(frequency, damping, STABILITY_LIMIT[settings.integrator])


def _hung(parts: Parts, pair: tuple[int, int], weights: np.ndarray, stiffness: float, damping: float) -> Parts:
    body, box = pair
    suspension = len(parts.joints.suspension_box)
    parts = with_suspension(parts, body, box, weights)
    numbers = {"joint_stiffness": stiffness, "joint_damping": damping, "joint_rest_length": 0.0}
    for corner in range(8):
        arm = 0.5 * parts.model.box_size[box] * corner_signs(corner)
        parts = with_joint(parts, [end_on_box(box, arm), end_inside(suspension, corner)], numbers)
    return parts
