import numpy as np
import pytest
from numpy.testing import assert_allclose

from references import analytic

STILL = np.zeros((1, 3))
UPRIGHT = np.array([[1.0, 0.0, 0.0, 0.0]])


def six_volumes(vertices, triangles):
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return np.einsum("tk,tk->t", a, np.cross(b, c)), a, b, c


def test_a_box_turns_hardest_about_its_short_axis():
    assert_allclose(analytic.box_inertia((1.0, 2.0, 3.0), 12.0), [13.0, 10.0, 5.0], rtol=1e-15)
    assert_allclose(
        analytic.box_inertia([[1, 1, 1], [2, 0, 0]], [6.0, 3.0]), [[1, 1, 1], [0, 1, 1]], rtol=1e-15, atol=1e-15
    )


def test_the_inertia_of_a_box_is_the_mean_over_its_points():
    size = np.array([0.3, 1.1, 0.7])
    line = (np.arange(40) + 0.5) / 40 - 0.5
    p = size * np.stack(np.meshgrid(line, line, line), axis=-1).reshape(-1, 3)
    sampled = [
        np.mean(p[:, 1] ** 2 + p[:, 2] ** 2),
        np.mean(p[:, 0] ** 2 + p[:, 2] ** 2),
        np.mean(p[:, 0] ** 2 + p[:, 1] ** 2),
    ]
    assert_allclose(analytic.box_inertia(size, 2.5), 2.5 * np.array(sampled), rtol=1e-3)


def test_the_volume_of_boxes_is_the_product_of_their_sides():
    assert_allclose(analytic.box_volume([[1, 2, 3], [0.5, 4, 1]]), [6.0, 2.0], rtol=1e-15)


@pytest.mark.parametrize("name", ["tetrahedron", "octahedron", "icosahedron"])
def test_a_regular_solid_is_as_large_as_its_tetrahedra_together(name, cases):
    volumes, *_ = six_volumes(*cases.solid(name, 1.7))
    assert_allclose(analytic.regular_solid_volume(name, 1.7), volumes.sum() / 6, rtol=1e-14)


@pytest.mark.parametrize(("nu", "nv"), [(3, 4), (5, 9), (48, 24)])
def test_a_faceted_torus_has_the_volume_and_inertia_of_its_tetrahedra(nu, nv, cases):
    volumes, a, b, c = six_volumes(*cases.torus(1.3, 0.4, nu, nv))
    s = a + b + c
    second = sum(np.einsum("t,ti,tj->ij", volumes, x, x) for x in (a, b, c, s)) / 120  # ∫ x xᵀ dV
    volume = volumes.sum() / 6
    assert_allclose(analytic.faceted_torus_volume(1.3, 0.4, nu, nv), volume, rtol=1e-13)
    inertia = 2.0 / volume * (np.trace(second) * np.eye(3) - second)
    assert_allclose(analytic.faceted_torus_inertia(1.3, 0.4, nu, nv, 2.0), np.diag(inertia), rtol=1e-12)


def test_a_fine_torus_tends_to_the_smooth_one():
    assert_allclose(analytic.faceted_torus_volume(1.0, 0.4, 4000, 4000), 2 * np.pi**2 * 0.16, rtol=3e-6)
    assert_allclose(analytic.faceted_torus_inertia(1.0, 0.4, 4000, 4000, 1.0)[2], 1.12, rtol=3e-6)


def test_the_inertia_of_a_torus_with_triangular_section_is_refused():
    with pytest.raises(ValueError, match="3 × 4"):
        analytic.faceted_torus_inertia(1.0, 0.4, 8, 3, 1.0)


def test_equilibrium_is_where_springs_and_gas_agree():
    gas, k = np.array([0.0, 1.0, 40.0]), np.array([2.0, 3.0, 0.5])
    scale = analytic.equilibrium_scale(gas, k)
    assert_allclose(scale**2 - scale, 3 * gas / k, rtol=1e-14, atol=1e-15)
    assert scale[0] == 1.0


def test_a_rotation_matrix_turns_as_its_quaternion_says():
    half = np.sqrt(0.5)
    assert_allclose(analytic.rotation_matrix([half, 0, 0, half]) @ [1, 0, 0], [0, 1, 0], atol=1e-15)
    assert_allclose(analytic.rotation_matrix([2.0, 0, 0, 1.0]) @ [5, 0, 0], [3, 4, 0], atol=1e-14)


def test_a_rotation_matrix_turns_every_vector_as_the_quaternion_product_does(rng):
    q, v = rng.normal(size=(20, 4)), rng.normal(size=(20, 3))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    t = 2 * np.cross(q[:, 1:], v)
    turned = np.einsum("mij,mj->mi", analytic.rotation_matrix(q), v)
    assert_allclose(turned, v + q[:, :1] * t + np.cross(q[:, 1:], t), atol=1e-14)


def test_a_box_that_lands_on_its_edge_starts_to_tip():
    # mass 6, sides 1: I = 1. Landing at (½, 0, −½): r × n = (0, −½, 0), give = 1/6 + ¼, j = 1/(5/12) = 2.4
    after = analytic.box_impact(
        np.ones((1, 3)), [6.0], STILL, UPRIGHT, [[0, 0, -1.0]], STILL,
        [[9, 9, 1.0]], [np.inf], [[0, 0, -1.0]], UPRIGHT, STILL, STILL,
        [[0.5, 0, -0.5]], [[0, 0, 1.0]], 0.0,
    )  # fmt: skip
    assert_allclose(after.velocity_a, [[0, 0, -0.6]], atol=1e-15)
    assert_allclose(after.angular_velocity_a, [[0, -1.2, 0]], atol=1e-15)
    assert_allclose(after.velocity_b, STILL, atol=0)
    assert_allclose(after.angular_velocity_b, STILL, atol=0)


def test_a_turned_box_bounces_as_the_box_of_the_turned_size():
    half = np.sqrt(0.5)
    common = ([2.0], STILL), ([[0.1, 0.2, -1.0]], [[0.3, -0.4, 0.5]])
    floor = [[9, 9, 1.0]], [np.inf], [[0, 0, -1.0]], UPRIGHT, STILL, STILL, [[0.2, 0.7, -0.5]], [[0, 0, 1.0]], 0.5
    turned = analytic.box_impact([[1.0, 2.0, 3.0]], *common[0], [[half, 0, 0, half]], *common[1], *floor)
    plain = analytic.box_impact([[2.0, 1.0, 3.0]], *common[0], UPRIGHT, *common[1], *floor)
    for got, want in zip(turned, plain):
        assert_allclose(got, want, atol=1e-14)


@pytest.mark.parametrize("kind", ["corner", "edge"])
@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_an_impact_keeps_momentum_and_obeys_newton(kind, restitution, cases, rng):
    case, n = cases.impacts(rng, 300, kind)
    size_a, mass_a, x_a, q_a, v_a, w_a, size_b, mass_b, x_b, q_b, v_b, w_b = case
    point = x_a + rng.normal(size=x_a.shape)
    after = analytic.box_impact(*case, point, n, restitution)
    both = np.isfinite(mass_a) & np.isfinite(mass_b)

    def speed(v_a, w_a, v_b, w_b):
        return np.sum((v_a + np.cross(w_a, point - x_a) - v_b - np.cross(w_b, point - x_b)) * n, axis=1)

    def spin(size, mass, q, w):
        R = analytic.rotation_matrix(q)
        return np.einsum("mij,mj,mkj,mk->mi", R, analytic.box_inertia(size, np.where(np.isfinite(mass), mass, 0)), R, w)

    def momenta(v_a, w_a, v_b, w_b):
        p_a, p_b = mass_a[:, None] * v_a, mass_b[:, None] * v_b
        angular = (
            np.cross(x_a, p_a) + np.cross(x_b, p_b) + spin(size_a, mass_a, q_a, w_a) + spin(size_b, mass_b, q_b, w_b)
        )
        energy = 0.5 * np.sum(p_a * v_a + p_b * v_b, axis=1)
        for size, mass, q, w in ((size_a, mass_a, q_a, w_a), (size_b, mass_b, q_b, w_b)):
            energy = energy + 0.5 * np.sum(w * spin(size, mass, q, w), axis=1)
        return (p_a + p_b)[both], angular[both], energy[both]

    before = v_a, w_a, v_b, w_b
    approach = speed(*before)
    meets = approach < 0
    assert 50 < meets.sum() < 250
    assert_allclose(speed(*after)[meets], -restitution * approach[meets], atol=1e-12)
    for got, kept in zip(after, before):
        assert np.array_equal(got[~meets], kept[~meets])
    with np.errstate(invalid="ignore"):  # ∞ × 0 of the static bodies, which `both` leaves out
        p, angular, energy = momenta(*before)
        p_after, angular_after, energy_after = momenta(*after)
    assert_allclose(p_after, p, atol=1e-12)
    assert_allclose(angular_after, angular, atol=1e-11)
    if restitution == 1.0:
        assert_allclose(energy_after, energy, rtol=1e-12)
    else:
        assert np.all(energy_after <= energy + 1e-12)


def test_two_static_boxes_are_left_alone():
    wall = np.ones((1, 3)), [np.inf], STILL, UPRIGHT, [[0, 0, -1.0]], STILL
    after = analytic.box_impact(*wall, *wall[:4], STILL, STILL, STILL, [[0, 0, 1.0]], 1.0)
    assert np.array_equal(after.velocity_a, [[0, 0, -1.0]])


def one_step(integrator, z, x, y):
    """The scheme as it is run, stage by stage, for a = −x in the unit of time 1/ω."""
    if integrator == "symplectic_euler":
        y = y - z * x
        return x + z * y, y
    if integrator == "rk4_velocity":
        a0 = -x
        a1 = -(x + (y + a0 * z / 2) * z / 2)
        a2 = -(x + (y + a1 * z / 2) * z / 2)
        a3 = -(x + (y + a2 * z) * z)
        y = y + z * (a0 + 2 * a1 + 2 * a2 + a3) / 6
        return x + z * y, y
    slope = lambda s: np.array([s[1], -s[0]])  # noqa: E731
    s = np.array([x, y])
    k1 = slope(s)
    k2 = slope(s + z / 2 * k1)
    k3 = slope(s + z / 2 * k2)
    k4 = slope(s + z * k3)
    return s + z / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


@pytest.mark.parametrize("integrator", ["rk4_velocity", "rk4", "symplectic_euler"])
def test_an_amplification_matrix_is_one_step_of_its_scheme(integrator):
    for z in (0.0, 1e-3, 0.7, 1.9, 3.1):
        columns = [one_step(integrator, z, 1.0, 0.0), one_step(integrator, z, 0.0, 1.0)]
        assert_allclose(analytic.amplification_matrix(integrator, z), np.array(columns).T, rtol=1e-14, atol=1e-15)


@pytest.mark.parametrize(("integrator", "limit"), [("rk4_velocity", 2.0), ("rk4", 8**0.5), ("symplectic_euler", 2.0)])
def test_each_scheme_is_stable_up_to_its_limit_and_not_beyond(integrator, limit):
    z = np.linspace(0.01, limit - 1e-6, 500)
    radius = analytic.spectral_radius(analytic.amplification_matrix(integrator, z))
    assert np.all(radius <= 1.0 + 1e-12)
    assert analytic.spectral_radius(analytic.amplification_matrix(integrator, limit + 1e-6)) > 1.0 + 1e-7


@pytest.mark.parametrize(("integrator", "order"), [("rk4_velocity", 1), ("rk4", 4), ("symplectic_euler", 1)])
def test_each_scheme_converges_at_its_order(integrator, order):
    turn = np.array([[np.cos(1.0), np.sin(1.0)], [-np.sin(1.0), np.cos(1.0)]])
    errors = [
        np.abs(np.linalg.matrix_power(analytic.amplification_matrix(integrator, 1.0 / n), n) - turn).max()
        for n in (64, 128)
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.05)


def test_the_scheme_of_the_paper_loses_a_quarter_of_z_squared_a_step():
    assert analytic.spectral_radius(analytic.amplification_matrix("rk4_velocity", 1e-2)) == pytest.approx(
        1 - 0.25e-4, abs=1e-8
    )


def test_an_unknown_integrator_is_named():
    with pytest.raises(ValueError, match="verlet"):
        analytic.amplification_matrix("verlet", 0.1)


def test_boxes_pass_each_other_with_the_air_that_is_between_their_outlines():
    unit, upright = np.ones((3, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (3, 1))
    offset = np.array([[-9.0, 0.3, 0.0], [-9.0, 1.2, 0.4], [-9.0, 1.2, 1.5]])
    along_x = np.tile([2.0, 0.0, 0.0], (3, 1))
    assert_allclose(analytic.passing_overlap(unit, upright, unit, upright, offset, along_x), [0.7, -0.2, -0.5])
    # Seen along a diagonal of its faces, a cube is √2 wide.
    diagonal = np.tile([1.0, 1.0, 0.0], (3, 1))
    offset = np.array([[0.0, 0.0, 0.9], [1.0, -1.0, 0.0], [1.1, -1.1, 0.0]])
    passing = analytic.passing_overlap(unit, upright, unit, upright, offset, diagonal)
    assert_allclose(passing, [0.1, 0.0, -0.1 * np.sqrt(2.0)], atol=1e-15)


def test_boxes_that_pass_have_no_points_in_common_on_their_way():
    rng = np.random.default_rng(1)
    size, q = rng.uniform(0.2, 1.0, (2, 200, 3)), rng.normal(size=(2, 200, 4))
    q /= np.linalg.norm(q, axis=2, keepdims=True)
    offset, direction = rng.uniform(-0.8, 0.8, (200, 3)), rng.normal(size=(200, 3))
    overlap = analytic.passing_overlap(size[0], q[0], size[1], q[1], offset, direction)
    frames = analytic.rotation_matrix(q[0]), analytic.rotation_matrix(q[1])
    line = np.linspace(-0.5, 0.5, 8)
    grid = np.stack(np.meshgrid(line, line, line), axis=-1).reshape(-1, 3)
    for k in range(200):
        points = (grid * size[0, k]) @ frames[0][k].T + offset[k]
        way = np.linspace(-3.0, 3.0, 200)[:, None, None] * direction[k] / np.linalg.norm(direction[k])
        seen = np.abs((points + way) @ frames[1][k]) <= 0.5 * size[1, k]
        if seen.all(axis=2).any():
            assert overlap[k] > 0.0
        elif overlap[k] > 0.0:
            assert overlap[k] < 0.35  # so little that the grid's points go by


def test_the_area_of_a_faceted_torus_is_that_of_its_triangles(cases):
    vertices, triangles = cases.torus(1.0, 0.4, 7, 5)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    assert analytic.faceted_torus_area(1.0, 0.4, 7, 5) == pytest.approx(area, rel=1e-13)


@pytest.mark.parametrize(("stiffness", "mass"), [(3.0, 0.5), (1e4, 2e-3)])
def test_critical_damping_is_where_two_particles_stop_swinging(stiffness, mass):
    critical = float(analytic.critical_damping(stiffness, mass))
    for share, swings in (0.999, True), (1.001, False):
        pull, drag = stiffness / mass, share * critical / mass
        opposite = np.array([[-1.0, 1.0], [1.0, -1.0]])  # of two particles along a line
        system = np.block([[np.zeros((2, 2)), np.eye(2)], [pull * opposite, drag * opposite]])
        assert (np.abs(np.linalg.eigvals(system).imag).max() > 1e-3 * np.sqrt(pull)) == swings
