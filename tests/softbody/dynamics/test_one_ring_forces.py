"""Is the fast force vector code, and do damping and drag act as they should?"""

import os

import llvmlite.binding
import numba
import numpy as np
import pytest

import softbody
from softbody import World
from softbody.dynamics.one_ring_forces import Forces, Springs, ring_sums
from softbody.dynamics.soft_bodies import motion_of, ring_accelerations
from softbody.dynamics.vertex_rings import build_rings
from softbody.model.arrays import soft_bodies_of

compiled = pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="nothing is compiled")


@compiled
@pytest.mark.skipif(not llvmlite.binding.get_host_cpu_features().get("avx2"), reason="narrow registers")
def test_the_force_is_compiled_to_vector_code():
    """Square roots of a whole register, and none of a single real."""
    fresh = numba.njit(error_model="numpy", _nrt=False)(ring_sums.py_func)  # cached code cannot be looked at
    mesh = softbody.icosphere(1)
    e = len(mesh.edges)
    rings = build_rings(len(mesh.vertices), mesh.edges, mesh.triangles, np.ones(e), np.ones(e))
    work = np.random.default_rng(0).uniform(size=(12, len(rings.particle)))
    fresh(rings, Springs(1.0, 1.0, True), 0, Forces(work[:3], work[3:6], work[6:9], work[9:]))
    (assembly,) = fresh.inspect_asm().values()
    assert "vsqrtpd" in assembly
    assert "vsqrtsd" not in assembly


def acceleration(world):
    out = np.empty_like(world.state.particle_position)
    motion = motion_of(world.model.soft_particle_start, world.store.rings)
    ring_accelerations(soft_bodies_of(world.model, world.controls, world.state), motion, out)
    return out


def test_drag_slows_every_particle_at_its_rate():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(softbody.octahedron(), 3.0, 10.0, 0.0, drag=2.0, velocity=(1.0, 2.0, 3.0))
    assert acceleration(world) == pytest.approx(-2.0 * body.velocities, abs=1e-14)


def test_damping_acts_along_edges_and_not_on_a_body_that_turns_or_flies():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(softbody.octahedron(), 6.0, 10.0, 0.0, damping=2.0)
    body.velocities[:] = np.cross([1.0, 2.0, 3.0], body.positions) + [4.0, 5.0, 6.0]
    assert acceleration(world) == pytest.approx(np.zeros((6, 3)), abs=1e-13)
    body.velocities[:] = 0.0
    body.velocities[4, 2] = 1.0  # the top rises: its four springs part at 1/√2 m/s each
    damped = acceleration(world)
    assert damped[4] == pytest.approx([0.0, 0.0, -4 * 2.0 * 0.5], abs=1e-14)
    assert damped.sum(axis=0) == pytest.approx([0.0, 0.0, 0.0], abs=1e-14)
