"""Camera from which a picture is taken."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softbody.errors import ParameterError
from softbody.model.validation import check_range, vector

FROM = np.array([0.46, -0.77, 0.44])  # where the camera that is chosen for a scene stands, seen from its middle
MARGIN = 1.08  # of the distance at which everything just fits in
VIEW = 35.0  # [degrees]


@dataclass(frozen=True)
class Camera:
    """Where the picture is taken from: `eye` and `target` (3,) [m], `view` the vertical field of view [degrees].

    z is up in the picture; a camera that looks straight down or up has y there. Raises ParameterError where it has
    nowhere to look.
    """

    eye: tuple[float, float, float]
    target: tuple[float, float, float]
    view: float = VIEW

    def __post_init__(self) -> None:
        """Check all three."""
        eye, target = vector(self.eye, "eye"), vector(self.target, "target")
        check_range(self.view, "view", "degrees", above=0.0, most=170.0)
        if (eye == target).all():
            raise ParameterError(f"eye and target are both {self.eye}; give the camera something to look at")
        object.__setattr__(self, "eye", tuple(eye.tolist()))
        object.__setattr__(self, "target", tuple(target.tolist()))

    def moved(self, offset: np.ndarray) -> Camera:
        """Return the camera moved by `offset` (3,) [m]."""
        eye, target = np.add(self.eye, offset), np.add(self.target, offset)
        return Camera((eye[0], eye[1], eye[2]), (target[0], target[1], target[2]), self.view)

    def axes(self) -> np.ndarray:
        """Return right, up and forward unit vectors as rows (3, 3)."""
        forward = np.subtract(self.target, self.eye)
        forward = forward / np.linalg.norm(forward)
        upward = (0.0, 0.0, 1.0) if np.hypot(forward[0], forward[1]) > 1e-9 else (0.0, 1.0, 0.0)
        right = np.cross(forward, upward)
        right /= np.linalg.norm(right)
        return np.array([right, np.cross(right, forward), forward])


def framing(points: np.ndarray, shape: float) -> Camera:
    """Return a camera that has all `points` (n, 3) [m] in its picture, which is `shape` times as wide as high.

    It looks at the middle of their bounding box, a little from above. With no points it looks at the origin.
    """
    low, high = (points.min(axis=0), points.max(axis=0)) if len(points) else (-np.ones(3), np.ones(3))
    middle = 0.5 * (low + high)
    towards = Camera((FROM[0], FROM[1], FROM[2]), (0.0, 0.0, 0.0))
    right, up, far = towards.axes() @ (points - middle).T if len(points) else np.ones((3, 1))
    half = np.tan(0.5 * np.radians(VIEW))
    # Each point asks for a distance at which it is in the picture, and in front of the camera.
    distance = MARGIN * float(np.max(np.maximum(np.abs(right) / (half * shape), np.abs(up) / half) - far))
    eye = middle + max(distance, 1e-6) * FROM / np.linalg.norm(FROM)
    return Camera((eye[0], eye[1], eye[2]), (middle[0], middle[1], middle[2]))
