"""The energies of all that is in a world."""

from __future__ import annotations

import numpy as np

from softbody.bodies.store import Store
from softbody.dynamics.energy import Energies, kinetic_energy, potential_energies, total_energy
from softbody.dynamics.joint_forces import joint_energy


def energy_of(store: Store) -> float:
    """Do what `World.energy` says."""
    return total_energy(store.model, store.controls, store.state) + joint_energy(store.joints, store.state)


def energies_of(store: Store) -> Energies:
    """Do what `World.energies` says."""
    model, controls = store.model, store.controls
    spring, gas, gravity, external, liquid = potential_energies(model, controls, store.state)
    filled = controls.soft_gas > 0.0
    room = model.soft_mesh_volume - model.soft_boxes_volume
    gas += float((controls.soft_gas[filled] * np.log(room[filled])).sum())
    spring += joint_energy(store.joints, store.state)
    return Energies(kinetic_energy(model, store.state), spring, gas, gravity, external, liquid)
