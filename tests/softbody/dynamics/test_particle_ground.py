"""Are particles lifted on to the ground, and do they bounce there, within a run as between steps?"""

import numpy as np
import pytest

import softbody
from softbody.dynamics.particle_ground import bounce_particle, resolve_ground
from softbody.model.material import Material


@pytest.mark.parametrize(
    ("velocity", "restitution", "friction", "after"),
    [
        ((0.0, 0.0, -2.0), 0.5, 0.0, (0.0, 0.0, 1.0)),
        ((3.0, 4.0, -2.0), 0.0, 0.0, (3.0, 4.0, 0.0)),
        ((3.0, 4.0, -2.0), 0.0, 0.5, (2.4, 3.2, 0.0)),
        ((3.0, 4.0, -2.0), 1.0, 0.5, (1.8, 2.4, 2.0)),
        ((3.0, 4.0, -2.0), 0.0, 9.0, (0.0, 0.0, 0.0)),
        ((3.0, 4.0, 2.0), 0.5, 0.5, (3.0, 4.0, 2.0)),
        ((3.0, 4.0, 0.0), 0.5, 0.5, (3.0, 4.0, 0.0)),
    ],
)
def test_a_particle_bounces_and_slides_by_hand(velocity, restitution, friction, after):
    velocities = np.array([[9.0, 9.0, 9.0], velocity])
    bounce_particle(velocities.T, 1, Material(restitution, friction))
    assert velocities[1] == pytest.approx(np.array(after), abs=1e-15)
    assert velocities[0].tolist() == [9.0, 9.0, 9.0]


def test_only_particles_below_the_ground_are_lifted_on_to_it():
    world = softbody.World()
    world.add_ground(height=-0.5)
    world.add_soft_body(softbody.octahedron(), 1.0, 1.0, 0.0, velocity=(0.0, 0.0, -3.0), restitution=1.0)
    impulse = np.full((6, 3), np.nan)
    resolve_ground(world.model, world.state, impulse, None, True)
    assert world.state.particle_position[:, 2].tolist() == [0.0, 0.0, 0.0, 0.0, 1.0, -0.5]
    assert world.state.particle_velocity[:, 2].tolist() == [-3.0] * 5 + [3.0]
    assert impulse.tolist() == [[0.0, 0.0, 0.0]] * 5 + [[0.0, 0.0, 1.0]]


@pytest.mark.parametrize("integrator", ["rk4_velocity", "rk4", "symplectic_euler"])
@pytest.mark.parametrize("threads", [1, 2])
def test_a_body_lands_within_a_run_as_it_does_step_by_step(integrator, threads):
    runs = []
    # More steps than there are between two looks at a body; at once, one by one, and beside a body that is far away.
    for steps, bodies in ((75, 1), (1, 1), (75, 2)):
        world = softbody.World(integrator=integrator, threads=threads)
        world.add_ground(0.1, restitution=0.2, friction=0.3)
        for k in range(bodies):
            world.add_soft_body(
                softbody.icosphere(2, 0.5), 1.0, 200.0, 30.0, (9.0 * k, 0.0, 0.62), (1.0, 0.0, -1.0), friction=0.8
            )
        for _ in range(75 // steps):
            world.step(3e-3, steps, substeps=5)
        runs.append(world.state.particle_position[:162].copy())
    assert runs[0][:, 2].min() == 0.1
    assert (runs[0] == runs[1]).all()
    assert (runs[0] == runs[2]).all()


def run_in_calls(world, steps):
    for _ in range(400 // steps):
        world.step(0.012, steps, allow_unstable=True)


def test_what_diverges_on_the_ground_leaves_the_last_good_step():
    states = []
    for steps in (400, 1):
        world = softbody.World()
        world.add_ground()
        world.add_soft_body(softbody.icosphere(1, 0.5), 1.0, 5_000.0, 30.0, (0.0, 0.0, 0.5))
        with pytest.raises(softbody.SimulationError):
            run_in_calls(world, steps)
        states.append((world.steps, world.state_hash()))
    assert states[0] == states[1]
