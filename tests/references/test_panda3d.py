import numpy as np
import pytest

from references.analytic import breathing_frequency, equilibrium_scale

pytest.importorskip("panda3d")
panda3d = pytest.importorskip("references.panda3d")


@pytest.fixture
def octahedron(cases):
    """Vertices at ±1, edges, triangles and Σ l0² = 12 × 2."""
    vertices, triangles = cases.solid("octahedron", 1.0)
    return vertices, cases.edges(triangles), triangles, 24.0


def test_bullets_gas_pushes_by_the_mean_cross_product_over_the_volume(octahedron):
    vertices, _, triangles, _ = octahedron
    # All triangles have sides √2, so |(b−a)×(c−a)| = √3; the volume is 4/3.
    assert panda3d.force_of_gas(vertices, triangles, 2.0, node=3) == pytest.approx(2.0 / (4 / 3) * 3**0.5, rel=1e-5)


@pytest.mark.parametrize("scale", [1.02, 1.5])
def test_an_octahedron_comes_to_rest_at_the_closed_form(octahedron, scale):
    vertices, edges, triangles, rest_squared = octahedron
    gas = (scale**2 - scale) * 50.0 * rest_squared / 3.0
    assert equilibrium_scale(gas, 50.0 * rest_squared) == pytest.approx(scale)
    volume = panda3d.volume_at_rest(vertices, edges, triangles, 50.0, gas)
    assert volume == pytest.approx(4 / 3 * scale**3, rel=5e-5)


def test_its_error_falls_with_the_square_of_the_step(octahedron):
    vertices, edges, triangles, rest_squared = octahedron
    gas, right = 0.24 * 50.0 * rest_squared / 3.0, 4 / 3 * 1.2**3
    bodies = [panda3d._GasBody(vertices, edges, triangles, 50.0, gas, 1.0, phase) for phase in (0.4, 0.2, 0.1)]
    errors = np.array([body.settle() / right - 1.0 for body in bodies])
    assert errors[:-1] / errors[1:] == pytest.approx([4.0, 4.0], rel=0.02)


def test_an_octahedron_breathes_with_the_period_of_the_closed_form(octahedron):
    vertices, edges, triangles, rest_squared = octahedron
    gas, mass = 100.0, 3.0
    frequency = breathing_frequency(gas, 50.0 * rest_squared, mass)  # every particle is 1 m from the centre
    period = panda3d.breathing_period(vertices, edges, triangles, 50.0, gas, mass, swing=0.01)
    assert period == pytest.approx(2.0 * np.pi / frequency, rel=2e-4)


def test_a_body_without_gas_is_refused(octahedron):
    vertices, edges, triangles, _ = octahedron
    with pytest.raises(ValueError, match="positive"):
        panda3d.volume_at_rest(vertices, edges, triangles, 50.0, 0.0)
