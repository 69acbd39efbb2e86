"""How often do two random boxes overlap? The separating-axis test, called from a kernel of one's own."""

import numba
import numpy as np

from softbody.collision.boxes.sat_boxes import PlacedBoxes, box_box_separation, placed_box


@numba.njit
def overlaps(boxes: PlacedBoxes) -> int:
    """Count how many of the boxes 0 and 1, 2 and 3, … overlap."""
    count = 0
    for i in range(0, boxes.size.shape[0], 2):
        gap, _, _ = box_box_separation(placed_box(boxes, i), placed_box(boxes, i + 1))
        count += gap <= 0.0
    return count


rng = np.random.default_rng(0)
turns = rng.normal(size=(200_000, 4))
turns /= np.linalg.norm(turns, axis=1, keepdims=True)
boxes = PlacedBoxes(rng.uniform(0.2, 1.0, (200_000, 3)), rng.uniform(-0.5, 0.5, (200_000, 3)), turns)
print(f"{overlaps(boxes)} of 100000 pairs overlap")
