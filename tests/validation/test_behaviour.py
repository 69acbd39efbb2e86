"""What is watched of a scene that is run by several rules."""

from __future__ import annotations

import pytest

import softbody
from validation.behaviour import Watched


@pytest.mark.parametrize(("integrator", "drift"), [("rk4", 1e-12), ("symplectic_euler", 0.01)])
def test_what_a_constant_push_does_is_counted_once(integrator: str, drift: float) -> None:
    world = softbody.World(gravity=(0.0, 0.0, 0.0), integrator=integrator)
    body = world.add_soft_body(softbody.icosphere(1), mass=2.0, stiffness=100.0, gas=0.0)
    body.external_force = (3.0 / 42, 0.0, 0.0)
    watched = Watched(world)
    before = watched.energy()
    world.run(1.0, 0.2 * watched.step)
    work = 3.0 * body.centre[0]
    assert work > 2.0
    assert watched.energy() == pytest.approx(before, abs=drift * work)
