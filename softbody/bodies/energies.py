"""The energies of all that is in a world, or of one body."""

from __future__ import annotations

import numpy as np

from softbody.bodies.names import Who
from softbody.bodies.store import Store
from softbody.dynamics.energy import Energies, kinetic_energy, potential_energies, total_energy
from softbody.dynamics.joint_forces import joint_energy
from softbody.model.arrays import NOBODY, Controls, Model


def energy_of(store: Store) -> float:
    """Do what `World.energy` says."""
    return total_energy(store.model, store.controls, store.state) + joint_energy(store.joints, store.state)


def energies_of(store: Store) -> Energies:
    """Do what `World.energies` says."""
    energies = _energies(store, store.model, store.controls)
    return energies._replace(spring=energies.spring + joint_energy(store.joints, store.state))


def energies_of_one(store: Store, who: Who) -> Energies:
    """Return the energies of one body, without those of joints."""
    kind, number = who
    only = _only_soft_body if kind == "soft" else _only_box
    return _energies(store, *only(store.model, store.controls, number))


def _energies(store: Store, model: Model, controls: Controls) -> Energies:
    """Return the energies of all bodies of a model, in the state that there is."""
    spring, gas, gravity, external, liquid = potential_energies(model, controls, store.state)
    filled = controls.soft_gas > 0.0
    room = model.soft_mesh_volume - model.soft_boxes_volume
    gas += float((controls.soft_gas[filled] * np.log(room[filled])).sum())
    return Energies(kinetic_energy(model, store.state), spring, gas, gravity, external, liquid)


def _only_soft_body(model: Model, controls: Controls, body: int) -> tuple[Model, Controls]:
    """Return a model with one of the soft bodies, whose boxes inside take room but cannot move; no rows move."""
    model, controls = _with_soft_bodies(model, controls, slice(body, body + 1))
    nothing = np.zeros_like(model.box_inverse_mass)
    return model._replace(box_inverse_mass=nothing, box_host=np.where(model.box_host == body, 0, NOBODY)), controls


def _only_box(model: Model, controls: Controls, box: int) -> tuple[Model, Controls]:
    """Return a model without soft bodies, of whose boxes one can move, if it could before; no rows move."""
    model, controls = _with_soft_bodies(model, controls, slice(0, 0))
    inverse_mass = np.zeros_like(model.box_inverse_mass)
    inverse_mass[box] = model.box_inverse_mass[box]
    return model._replace(box_inverse_mass=inverse_mass), controls


def _with_soft_bodies(model: Model, controls: Controls, which: slice) -> tuple[Model, Controls]:
    """Return a model with some of the soft bodies: particles of others are fixed."""
    fields = {name: rows for name, rows in model._asdict().items() if name.startswith("soft_") and np.ndim(rows)}
    starts = slice(which.start, which.stop + 1)
    rows = {name: array[starts if name.endswith("_start") else which] for name, array in fields.items()}
    particles = slice(*rows["soft_particle_start"][[0, -1]])
    inverse_mass = np.zeros_like(model.particle_inverse_mass)
    inverse_mass[particles] = model.particle_inverse_mass[particles]
    return (
        model._replace(soft_count=which.stop - which.start, particle_inverse_mass=inverse_mass, **rows),
        controls._replace(soft_gas=controls.soft_gas[which]),
    )
