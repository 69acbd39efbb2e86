"""A joint of a World, a damped spring between two points: a handle, and what a user may say of its ends."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from softbody.bodies.body import Body
from softbody.bodies.builder import end_in_world, end_inside, end_on_box, end_on_soft
from softbody.bodies.rigid_box import Box
from softbody.bodies.soft_body import SoftBody
from softbody.bodies.store import Store
from softbody.bodies.suspended import Suspended
from softbody.dynamics.joint_forces import joint_ends
from softbody.errors import ParameterError
from softbody.geometry import MeshQuery
from softbody.linalg.quaternion import rotation_matrix
from softbody.model.arrays import NOBODY, Joints
from softbody.model.validation import check_range, check_whole, shown, vector

End = ArrayLike | tuple[SoftBody | Box | Suspended, ArrayLike]


class JointNumber:
    """A number of a joint, as an attribute of its handle: checked when it is set."""

    def __init__(self, name: str, unit: str, doc: str) -> None:
        self._name, self._unit = name, unit
        self.__doc__ = doc

    def __get__(self, joint: Joint | None, kind: type) -> Any:
        """Return the number [float] of a joint."""
        return self if joint is None else float(getattr(joint.arrays(), f"joint_{self._name}")[joint.row()])

    def __set__(self, joint: Joint, value: float) -> None:
        """Set it, from the next step on; raises ParameterError if it is less than 0 or not finite."""
        value = check_range(value, self._name, self._unit, least=0.0)
        with joint.store.exclusive():
            array = getattr(joint.arrays(), f"joint_{self._name}").copy()
            array[joint.row()] = value
            joint.store.replace(joints=joint.arrays()._replace(**{f"joint_{self._name}": array}))


class Joint(Body):
    """A damped spring between points of two bodies, or of a body and a place in the world; see `World.add_joint`."""

    __slots__ = ()

    kind = "joint"

    stiffness = JointNumber("stiffness", "N/m", "Stiffness [N/m], ≥ 0.")
    damping = JointNumber("damping", "N s/m", "Force against the speed at which the ends part [N s/m], ≥ 0.")
    rest_length = JointNumber("rest_length", "m", "Length at rest [m], ≥ 0; of 0, one end is pulled to the other.")

    def _count(self) -> int:
        return len(self.arrays().joint_box)

    def arrays(self) -> Joints:
        """Return the arrays of all joints."""
        return self.store.joints

    def __repr__(self) -> str:
        """Say which joint it is, how long, and how stiff."""
        if not self.is_there:
            return "<joint that is gone>"
        return f"<{self._title()}: {self.length:.4g} m, {self.stiffness:.4g} N/m>"

    @property
    def ends(self) -> np.ndarray:
        """Where its two ends are now (2, 3) [m]."""
        parts, row = self.store.parts, self.row()
        joints = parts.joints._asdict().items()
        one = {name: array[row : row + 1] for name, array in joints if name.startswith("joint_")}
        return np.asarray(joint_ends(parts.joints._replace(**one), parts.state)[0])

    @property
    def length(self) -> float:
        """How far its ends are apart [m]."""
        a, b = self.ends
        return float(np.linalg.norm(a - b))

    @property
    def target(self) -> np.ndarray:
        """The place (3,) [m] of the end that is in the world; may be assigned. ParameterError if both are on bodies."""
        return self._place_of_target()

    @target.setter
    def target(self, value: ArrayLike) -> None:
        self.target[:] = vector(value, "target")

    def _place_of_target(self) -> np.ndarray:
        joints, row = self.arrays(), self.row()
        for end in (1, 0):
            bodies = joints.joint_box[row, end], joints.joint_particles[row, 3 * end], joints.joint_inside[row, 2 * end]
            if max(bodies) == NOBODY:
                return joints.joint_place[row, 3 * end : 3 * end + 3]
        raise ParameterError(f"joint {row} is between two bodies; it has no target to move")


def ends_of(store: Store, a: End, b: End) -> list[dict[str, ArrayLike]]:
    """Return both ends of a joint, checked; raises ParameterError."""
    ends = [_end(store, a, "a"), _end(store, b, "b")]
    if not (_is_on_body(a) or _is_on_body(b)):
        raise ParameterError("a and b are two places in the world; give a body with one of them, (body, place)")
    return ends


def _is_on_body(end: Any) -> bool:
    return isinstance(end, tuple) and len(end) == 2


def _end(store: Store, end: Any, name: str) -> dict[str, ArrayLike]:
    if not _is_on_body(end):
        return end_in_world(vector(end, name))
    body, where = end
    if not isinstance(body, (SoftBody, Box, Suspended)) or body.store is not store:
        raise ParameterError(f"{name} is on {shown(body)}, which is no body of this world; give a handle of one")
    if isinstance(body, Box):
        away = vector(where, f"place of {name}") - body.position
        return end_on_box(body.row(), rotation_matrix(body.orientation).T @ away)
    if isinstance(body, Suspended):
        return end_inside(body.row(), check_whole(where, f"point of {name}", 0, len(body) - 1))
    first = int(store.model.soft_particle_start[body.row()])
    if np.isscalar(where) or getattr(where, "ndim", None) == 0:
        particle = check_whole(where, f"particle of {name}", 0)
        if particle >= len(body.positions):
            raise ParameterError(
                f"particle of {name} is {particle}, and {body!r} has {len(body.positions)}: give one of those"
            )
        return end_on_soft(np.full(3, first + particle), (1.0, 0.0, 0.0))
    triangles = body.triangles
    place = vector(where, f"place of {name}")
    found = MeshQuery(body.positions, triangles).closest(place[None])
    weights = found.weights[0]
    return end_on_soft(first + triangles[found.triangle[0]], weights / weights.sum())
