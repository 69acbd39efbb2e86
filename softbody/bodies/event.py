"""What has happened to the soft bodies of a world: they tore, were cut, or were joined."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softbody.bodies.soft_body import SoftBody


@dataclass(frozen=True, eq=False)
class Event:
    """One body has torn, or was cut, or two were joined.

    Of `bodies` the first is the one that was there before, and the largest. There are others where it fell apart.
    """

    kind: str  # "tear", "cut" or "join"
    time: float  # [s] at the end of the step, or when it was done
    places: np.ndarray  # (k, 3) [m] where particles have split; or one, where it was cut or joined
    bodies: tuple[SoftBody, ...]
