"""Bodies full of a liquid: what is refused, and what is set."""

from __future__ import annotations

import numpy as np
import pytest

import softbody
from softbody import ParameterError, SnapshotError, SoftBody, World


def a_bag(density: float = 1000.0) -> SoftBody:
    return World().add_soft_body(softbody.icosphere(1, 0.5), 2.0, 1e4, 1e3, liquid_density=density)


def test_a_liquid_keeps_its_volume_without_gas_also_where_there_is_no_weight() -> None:
    for gravity, sound in ((9.81, 0.0), (0.0, 30.0)):
        world = World(gravity=(0.0, 0.0, -gravity))
        filled = {"liquid_density": 1000.0, "sound_speed": sound, "drag": 5.0}
        bag = world.add_soft_body(softbody.icosphere(1, 0.5), 2.0, 1e3, 0.0, rest_length=0.1, **filled)
        bag.fixed = (0, 1, 2)
        whole = bag.volume
        world.run(2.0)
        assert 0.97 * whole < bag.volume < whole
        assert bag.pressure > 0.0


def test_a_liquid_that_goes_in_and_out_leaves_the_skin() -> None:
    bag = a_bag(0.0)
    for density in (1000.0, 10.0, 0.0):
        bag.liquid_density = density
        assert bag.mass == pytest.approx(2.0 + density * bag.volume, rel=1e-12)
    bag.fixed = (3,)
    bag.liquid_density = 500.0
    assert list(bag.fixed) == [3]
    assert bag.mass == pytest.approx(2.0 + 500.0 * bag.volume, rel=1e-12)


def test_a_liquid_that_is_too_heavy_is_refused() -> None:
    with pytest.raises(ParameterError, match="too light or too heavy"):
        World().add_soft_body(softbody.icosphere(1, 5.0), 2.0, 1e4, 1e3, liquid_density=1e308)
    bag = a_bag()
    with pytest.raises(ParameterError, match="liquid_density"):
        bag.liquid_density = np.inf


def test_a_step_that_is_too_long_for_the_liquid_is_refused() -> None:
    world = World(gravity=(0.0, 0.0, -1e9))
    world.add_soft_body(softbody.icosphere(1, 0.5), 2.0, 1e-3, 1e-3, liquid_density=1000.0)
    with pytest.raises(ParameterError, match="liquids allow"):
        world.step(1e-3, substeps=1000)


def test_a_snapshot_of_a_liquid_heavier_than_its_body_is_refused() -> None:
    bag = a_bag()
    snapshot = bag.world.snapshot()
    snapshot["model.soft_liquid_density"] = np.array([1e6])
    with pytest.raises(SnapshotError, match="make that more"):
        World().restore(snapshot)
