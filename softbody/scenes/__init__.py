"""Scenes, each one file with a `build` that returns a World ready to run: the paper's four (§9), and eight more.

All take a `world` to fill, such as `World.paper()`, in place of a new one. `from_file` builds any other, from TOML.
"""

from softbody.scenes import (
    ball_drop,
    box_pile,
    box_stack,
    boxes_in_bags,
    boxes_on_torus,
    limp,
    pool,
    rolling_torus,
    sphere_on_torus,
    torus_stack,
    tray,
    water_bags,
)
from softbody.scenes.scene_file import from_file as from_file

__all__ = [
    "ball_drop",
    "box_pile",
    "box_stack",
    "boxes_in_bags",
    "boxes_on_torus",
    "limp",
    "pool",
    "rolling_torus",
    "sphere_on_torus",
    "torus_stack",
    "tray",
    "water_bags",
]
