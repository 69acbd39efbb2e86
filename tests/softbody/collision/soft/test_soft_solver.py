"""Impulses of many contacts at once are a projection: what one gives too much is taken back, by SciPy's NNLS."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import nnls

import softbody
from softbody import World
from softbody.collision.contact import Touch, add_contact, box_side, new_contacts, rows_of, soft_side
from softbody.collision.soft.soft_response import Bodies, resolve_contacts, response_memory
from softbody.collision.soft.soft_solver import HELD, LIFTED
from softbody.collision.soft.soft_warm_start import start_from_last_step
from softbody.collision.soft.surface import build_surfaces
from softbody.model.arrays import Particles, RigidBodies
from softbody.model.material import Material
from softbody.model.surface_point import at_particle

pytestmark = pytest.mark.interpreted

H = 1e-3  # [s]


def _after_walls(normals: np.ndarray, before: np.ndarray, on_ground: bool, friction: float) -> np.ndarray:
    """Return the velocity of a particle of 0.5 kg that a step has led through walls of so many `normals` (k, 3)."""
    walls, velocity = len(normals), before[None].copy()
    boxes = RigidBodies(np.zeros(walls), np.zeros((walls, 3)), *(np.zeros((walls, n)) for n in (3, 4, 3, 3)))
    boxes.orientation[:, 0] = 1.0
    contacts = new_contacts(walls)
    for k, normal in enumerate(normals):
        touch = Touch((0.0, 0.0, 0.0), tuple(normal.tolist()), 1e-9, 0)
        add_contact(contacts, soft_side(at_particle(0)), box_side(k), touch, Material(0.0, friction))
    particles = Particles(np.array([2.0]), np.zeros((1, 3)), velocity)
    start = Bodies(Particles(np.array([2.0]), -H * velocity, velocity.copy()), boxes)
    response = response_memory(np.array([0, 1]), walls)
    if on_ground:
        response.ground[0] = (
            LIFTED if (normals[:, 2] + friction * np.sqrt(1.0 - normals[:, 2] ** 2) > 0.0).any() else HELD
        )
    resolve_contacts(contacts, Bodies(particles, boxes), start, response, H)
    return velocity[0]


def _some_walls(seed: int, walls: int, on_ground: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return normals (k, 3) of walls that leave some way out, and a velocity: a level one on the ground."""
    random = np.random.default_rng(seed)
    way_out = random.normal(size=3)
    way_out[2] = 0.0 if on_ground else abs(way_out[2])
    normals = random.normal(size=(walls, 3))
    normals = np.where(normals @ way_out < 0.0, -1.0, 1.0)[:, None] * normals
    velocity = random.normal(size=3) * (1.0, 1.0, 0.0 if on_ground else 1.0)
    return normals / np.linalg.norm(normals, axis=1)[:, None], velocity


@given(st.integers(0, 10**6), st.integers(1, 6), st.booleans())
def test_a_particle_leaves_many_walls_at_the_nearest_velocity_that_enters_none(
    seed: int, walls: int, on_ground: bool
) -> None:
    normals, before = _some_walls(seed, walls, on_ground)
    velocity = _after_walls(normals, before, on_ground, 0.0)
    if on_ground:  # it is one more wall
        normals = np.concatenate([normals, [[0.0, 0.0, 1.0]]])
    impulses, _ = nnls(normals.T, -before)  # in units of the mass: the shortest that leaves no way in
    load = max(0.0, (-normals @ before).max())
    np.testing.assert_allclose(velocity, before + normals.T @ impulses, atol=0.05 * load)
    assert (normals @ velocity >= -load / 256.0 - 1e-12).all()


@given(st.integers(0, 10**6), st.integers(1, 4), st.floats(0.0, 1.5), st.booleans())
def test_walls_and_the_ground_make_no_particle_faster_however_they_rub(
    seed: int, walls: int, friction: float, steep: bool
) -> None:
    normals, before = _some_walls(seed, walls, True)
    if steep:  # all press it down, most of them hardly aside
        normals[:, :2] *= np.random.default_rng(seed).random((walls, 1)) ** 2
        normals[:, 2] = -np.sqrt(1.0 - (normals[:, :2] ** 2).sum(axis=1))
    velocity = _after_walls(normals, before, True, friction)
    assert np.linalg.norm(velocity) <= 1.05 * np.linalg.norm(before)


def test_a_contact_starts_from_its_own_impulse_wherever_it_is_listed() -> None:
    world = World()
    world.add_box((2.0, 2.0, 1.0), None, (0.0, 0.0, -0.5))
    for k in range(2):
        world.add_soft_body(
            softbody.icosphere(1, 0.4), 1.0, 100.0, 20.0, (0.1 * k, 0.0, 0.41 + 0.81 * k), (0.0, 0.0, -2.0 * k)
        )
    first = end = 0
    while end - first < 3:
        world.step(1e-3)
        now, cache = world.store.contacts, world.store.contacts.cache
        first, end = int(now.number[1]), int(now.number[0])
    kept = cache.impulse[first:end].copy()
    assert (np.linalg.norm(kept, axis=1) > 0.0).any()
    order = np.random.default_rng(1).permutation(end - first)
    listed = rows_of(now, now.number, first, end)
    for rows in (listed.box, listed.particles):
        rows[:] = rows[order]
    listed.particles[0, 0] += 1  # one that was not there
    listed.impulse[:] = 0.0
    start_from_last_step(now, build_surfaces(world.model, world.state.particle_position))
    np.testing.assert_array_equal(listed.impulse[1:], kept[order][1:])
    np.testing.assert_array_equal(listed.impulse[0], 0.0)
