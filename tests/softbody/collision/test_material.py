"""Do materials combine by the documented rules?"""

import pytest

from softbody.collision.material import combined_friction, combined_restitution


def test_the_livelier_restitution_wins():
    assert combined_restitution(0.2, 0.7) == combined_restitution(0.7, 0.2) == 0.7


def test_friction_is_the_geometric_mean():
    assert combined_friction(0.4, 0.9) == combined_friction(0.9, 0.4) == pytest.approx(0.6, rel=1e-15)
    assert combined_friction(0.0, 0.9) == 0.0
