"""Do materials combine by the documented rules?"""

import pytest

from softbody.model.material import Material, combined


def both_ways(a, b):
    """The material of a and b, which is that of b and a."""
    assert combined(a, b) == combined(b, a)
    return combined(a, b)


def test_the_livelier_restitution_wins():
    assert both_ways(Material(0.2, 0.5), Material(0.7, 0.5)).restitution == 0.7


def test_friction_is_the_geometric_mean():
    assert both_ways(Material(0.0, 0.4), Material(0.0, 0.9)).friction == pytest.approx(0.6, rel=1e-15)
    assert both_ways(Material(0.0, 0.0), Material(0.0, 0.9)).friction == 0.0
