"""Frame of a world at one instant: arrays that share no memory with it, for another thread to draw."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.bodies.energies import energy_of
from softbody.bodies.soft_body import soft_bodies_of
from softbody.dynamics.energy import kinetic_energy
from softbody.dynamics.joint_forces import joint_ends
from softbody.render.quantities import QUANTITIES
from softbody.stepping.runner import Steppable

TOUCHING = 1e-9  # of a metre above the ground: where what was lifted on to it lies, up to rounding


class Frame(NamedTuple):
    """One instant of a world."""

    time: float  # [s]
    soft: list[np.ndarray]  # vertices (n, 3) [m] of each soft body, single precision
    triangles: list[np.ndarray]  # (t, 3) of each, which a tear changes
    quantity: str | None  # that colours show
    values: list[np.ndarray]  # (n,) of it, of each soft body; or none
    box_position: np.ndarray  # (m, 3) [m]
    box_orientation: np.ndarray  # (m, 4)
    contacts: np.ndarray  # (c, 3) points [m]
    joints: np.ndarray  # (j, 2, 3) ends [m], single precision
    pull: np.ndarray | None  # (2, 3) ends of the spring that pulls [m]
    kinetic: float  # energy [J]
    total: float  # energy [J]


def frame_of(world: Steppable, quantity: str | None = None, pull: np.ndarray | None = None) -> Frame:
    """Return what is shown of a world now, with a quantity of QUANTITIES for each vertex if it is named."""
    store = world.store
    bodies = soft_bodies_of(world)
    return Frame(
        store.time,
        [body.positions.astype(np.float32) for body in bodies],
        [body.triangles for body in bodies],
        quantity,
        [QUANTITIES[quantity](body) for body in bodies] if quantity else [],
        store.state.box_position.copy(),
        store.state.box_orientation.copy(),
        contact_points(world).astype(np.float32),
        joint_ends(store.joints, store.state).astype(np.float32),
        pull,
        kinetic_energy(store.model, store.state),
        energy_of(store),
    )


def contact_points(world: Steppable) -> np.ndarray:
    """Return where bodies touch (c, 3) [m]: contacts of the last step, and particles that lie on the ground."""
    touching, positions = world.runner.contact_points().point, world.store.state.particle_position
    lying = positions[positions[:, 2] <= world.store.model.ground_height + TOUCHING]
    return np.concatenate([touching, lying])
