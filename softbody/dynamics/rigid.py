"""How do rigid boxes move over one time step, between contacts?"""

from __future__ import annotations

from softbody.jit import jit
from softbody.quaternion import from_rotation_vector, load_quaternion, normalize_quaternion, product
from softbody.state import Model, State
from softbody.vec import load, scale


@jit
def move_boxes(model: Model, state: State, h: float) -> None:
    """Advance every box by `h` [s] with Euler–Cromer: v' = v + g h, then x' = x + v' h; paper §5.2.

    (The paper prints x' = x + a t.) The orientation turns by the rotation vector ω h. No gyroscopic torque: ω
    keeps its direction, as in the paper, so an asymmetric box in free rotation keeps ω and not I ω.
    """
    for i in range(state.box_position.shape[0]):
        if model.box_inverse_mass[i] > 0.0:
            for c in range(3):
                state.box_velocity[i, c] += h * model.gravity[c]
                state.box_position[i, c] += h * state.box_velocity[i, c]
            turn = from_rotation_vector(scale(h, load(state.box_angular_velocity, i)))
            q = normalize_quaternion(product(turn, load_quaternion(state.box_orientation, i)))
            for c in range(4):
                state.box_orientation[i, c] = q[c]
