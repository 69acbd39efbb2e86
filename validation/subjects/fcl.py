"""FCL as a subject: overlap of boxes."""

from __future__ import annotations

import numpy as np

from references import fcl

PACKAGES = {"fcl": "python-fcl"}  # import name, and the name to install it by
CANNOT = {  # question → why it has no answer
    "move_boxes": "it finds collisions, and moves nothing",
    "gas_volume": "it finds collisions, and has no soft bodies",
    "gas_period": "it finds collisions, and has no soft bodies",
    "points_in_mesh": "its meshes are surfaces, and have no inside",
    "move_soft": "it finds collisions, and has no soft bodies",
}


def boxes_overlap(*pairs: np.ndarray) -> np.ndarray:
    """Tell whether boxes overlap."""
    return fcl.boxes_overlap(*pairs)
