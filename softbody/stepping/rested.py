"""For how long the bodies of a world have been at rest, as snapshots tell it."""

from __future__ import annotations

from softbody.bodies.store import Contents
from softbody.model.arrays import Joints
from softbody.model.sleep_state import Rested
from softbody.stepping.sleep import mark_sleepers, wake_changed


def note_sleepers(contents: Contents) -> None:
    """Note how those who sleep are left: what is changed of them from now on wakes them."""
    model, controls, state, _, joints = contents.parts
    if contents.sleep.rest.time.any():
        mark_sleepers(model, controls, state, _if_any(joints), contents.sleep.rest)


def rested(contents: Contents) -> Rested:
    """Return what the coming steps depend on; what was changed meanwhile is at rest no more."""
    model, controls, state, _, joints = contents.parts
    contents.sleep.model_of(model)
    rest = contents.sleep.rest
    if rest.time.any():
        wake_changed(model, controls, state, _if_any(joints), rest)
    return Rested(rest.time, rest.asleep.astype("int64"))


def _if_any(joints: Joints) -> Joints | None:
    return joints if len(joints.joint_box) else None
