"""The paper's scenes (§9), each one file with a `build` that returns a World ready to run."""

from softbody.scenes import boxes_on_torus, rolling_torus, sphere_on_torus, torus_stack

__all__ = ["boxes_on_torus", "rolling_torus", "sphere_on_torus", "torus_stack"]
