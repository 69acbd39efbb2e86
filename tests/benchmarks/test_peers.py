"""Who does the same work comes to the same positions: a race against a peer that computes something else is void."""

import numpy as np
import pytest

import softbody
from benchmarks import cpp_peers, mujoco_peer, newton_peer, peers, taichi_peer, warp_peer

STEP, STEPS, CALLS = 1e-4, 20, 3


@pytest.fixture(scope="module")
def mesh():
    return softbody.icosphere(2, radius=0.5)


@pytest.fixture(scope="module")
def velocity(mesh):
    """Random, for bodies without gas: springs that nothing stretches do no work."""
    return np.random.default_rng(20081).normal(size=mesh.vertices.shape)


def core_after(mesh, gas, integrator, velocity=0.0):
    world = softbody.World(integrator=integrator)
    body = world.add_soft_body(mesh, peers.MASS, peers.STIFFNESS, gas, damping=0.0)
    body.velocities[:] = velocity
    world.step(STEP, STEPS * CALLS)
    return body.positions


def peer_after(call):
    for _ in range(CALLS):
        positions = call()
    # Taichi's fields say to_numpy, Warp's arrays numpy.
    for name in ("to_numpy", "numpy"):
        if hasattr(positions, name):
            return getattr(positions, name)()
    return positions


@pytest.mark.skipif(cpp_peers.plain_stepping(softbody.tetrahedron(), STEP, 1) is None, reason="there is no compiler")
@pytest.mark.parametrize("made", [cpp_peers.plain_stepping, cpp_peers.ring_stepping])
@pytest.mark.parametrize(
    "shape",
    [
        softbody.icosphere(2, 0.5),
        softbody.box((0.5, 0.4, 0.3)),
        softbody.torus(0.4, 0.15, 9, 7),
        softbody.tetrahedron(),
    ],
)
def test_cpp_takes_the_same_steps(made, shape):
    positions = peer_after(made(shape, STEP, STEPS))
    assert positions == pytest.approx(core_after(shape, peers.GAS, "rk4_velocity"), abs=1e-14)


@pytest.mark.skipif(taichi_peer.taichi is None, reason="taichi is not installed")
def test_taichi_takes_the_same_steps(mesh):
    positions = peer_after(taichi_peer.taichi_stepping(mesh, STEP, STEPS))
    assert positions == pytest.approx(core_after(mesh, peers.GAS, "rk4_velocity"), abs=1e-14)


@pytest.mark.skipif(warp_peer.warp is None, reason="warp-lang is not installed")
@pytest.mark.parametrize(("precision", "error"), [("float64", 1e-14), ("float32", 2e-6)])
def test_warp_takes_the_same_steps(mesh, precision, error):
    positions = peer_after(warp_peer.warp_stepping(mesh, STEP, STEPS, precision))
    assert positions == pytest.approx(core_after(mesh, peers.GAS, "rk4_velocity"), abs=error)


@pytest.mark.skipif(newton_peer.newton is None, reason="newton is not installed")
def test_newton_takes_the_steps_of_symplectic_euler_without_gas(mesh, velocity):
    positions = peer_after(newton_peer.newton_stepping(mesh, STEP, STEPS, velocity))
    assert positions == pytest.approx(core_after(mesh, 0.0, "symplectic_euler", velocity), abs=2e-6)


def test_mujoco_takes_the_steps_of_symplectic_euler_without_gas(mesh, velocity):
    positions = peer_after(mujoco_peer.mujoco_stepping(mesh, STEP, STEPS, velocity))
    assert positions == pytest.approx(core_after(mesh, 0.0, "symplectic_euler", velocity), abs=1e-14)


def test_gas_and_springs_move_the_body_by_more_than_the_errors_allowed(mesh, velocity):
    still = core_after(mesh, 0.0, "rk4_velocity")
    assert np.abs(core_after(mesh, peers.GAS, "rk4_velocity") - still).max() > 1e-4
    thrown = mesh.vertices + STEP * STEPS * CALLS * velocity
    assert np.abs(core_after(mesh, 0.0, "symplectic_euler", velocity) - thrown).max() > 1e-3
