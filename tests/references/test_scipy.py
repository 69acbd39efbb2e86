import numpy as np
import pytest
from numpy.testing import assert_allclose

from references import analytic, scipy


def lengths(x, edges):
    return np.linalg.norm(x[edges[:, 1]] - x[edges[:, 0]], axis=1)


def volume(x, triangles):
    a, b, c = (x[triangles[:, k]] for k in range(3))
    return np.sum(a * np.cross(b, c)) / 6


@pytest.mark.parametrize("name", ["tetrahedron", "octahedron", "icosahedron"])
def test_a_regular_solid_comes_to_rest_at_the_scale_of_the_closed_form(name, cases):
    x, triangles = cases.solid(name, 0.7)
    edges = cases.edges(triangles)
    rest = lengths(x, edges)
    got = scipy.equilibrium(x, edges, rest, 50.0, triangles, 7.0)
    scale = analytic.equilibrium_scale(7.0, 50.0 * np.sum(rest**2))
    assert scale > 1.02
    assert_allclose(got.positions, scale * x, atol=1e-13)
    assert got.residual < 1e-14


@pytest.mark.parametrize("gas", [0.5, 5.0, 50.0])
def test_a_torus_at_rest_obeys_the_virial_identity(gas, cases, rng):
    x, triangles = cases.torus(1.0, 0.4, 16, 8)
    edges = cases.edges(triangles)
    rest, stiffness = lengths(x, edges), rng.uniform(20.0, 80.0, len(edges))
    got = scipy.equilibrium(x, edges, rest, stiffness, triangles, gas)
    assert got.residual < 1e-14
    length = lengths(got.positions, edges)
    assert np.sum(stiffness * (length - rest) * length) == pytest.approx(3 * gas, rel=1e-11)


def test_no_way_leads_downhill_from_the_equilibrium(cases, rng):
    x, triangles = cases.torus(1.0, 0.4, 12, 6)
    edges = cases.edges(triangles)
    rest, gas = lengths(x, edges), 5.0
    at_rest = scipy.equilibrium(x, edges, rest, 50.0, triangles, gas).positions

    def energy(x):
        return 0.5 * np.sum(50.0 * (lengths(x, edges) - rest) ** 2) - gas * np.log(volume(x, triangles))

    for size in (1e-4, 1e-2):
        for _ in range(50):
            assert energy(at_rest + size * rng.normal(size=x.shape)) > energy(at_rest)


def test_the_equilibrium_lies_as_near_to_the_start_as_a_rigid_motion_can_bring_it(cases):
    x, triangles = cases.solid("icosahedron", 1.0)
    edges = cases.edges(triangles)
    start = x + 0.2 * np.sin(np.arange(36)).reshape(12, 3)
    rest = lengths(x, edges)
    got = scipy.equilibrium(start, edges, rest, 9.0, triangles, 2.0)
    scale = analytic.equilibrium_scale(2.0, 9.0 * np.sum(rest**2))
    assert_allclose(lengths(got.positions, edges), scale * rest, rtol=1e-12)
    assert_allclose(got.positions.mean(axis=0), start.mean(axis=0), atol=1e-14)
    centred = start - start.mean(axis=0)
    assert_allclose(np.sum(np.cross(centred, got.positions), axis=0), 0.0, atol=1e-12)  # no turn brings it nearer


def test_a_body_far_away_comes_to_rest_all_the_same(cases):
    x, triangles = cases.solid("icosahedron", 1.0)
    edges = cases.edges(triangles)
    away = np.array([2.0**20, -(2.0**18), 2.0**17])
    here, there = (scipy.equilibrium(y, edges, lengths(x, edges), 9.0, triangles, 2.0).positions for y in (x, x + away))
    assert_allclose(there - away, here, atol=1e-9)


def test_without_gas_springs_return_to_their_rest_lengths(cases):
    x, triangles = cases.solid("octahedron", 1.0)
    edges = cases.edges(triangles)
    got = scipy.equilibrium(x * [1.1, 0.9, 1.05], edges, lengths(x, edges), 10.0, triangles, 0.0)
    assert_allclose(lengths(got.positions, edges), lengths(x, edges), rtol=1e-12)


def test_the_pressure_gradient_is_the_derivative_of_the_volume(cases):
    vertices, triangles = cases.torus(1.0, 0.4, 7, 5)
    x = vertices * [1.0, 0.8, 1.2] + [3.0, -2.0, 1.0]
    want = np.zeros_like(x)
    for i, k in np.ndindex(*x.shape):
        step = x.astype(complex)
        step[i, k] += 1e-30j
        want[i, k] = volume(step, triangles).imag / 1e-30
    assert_allclose(scipy.pressure_gradient(x, triangles), want, atol=1e-14)


def test_without_gas_the_scale_swings_as_a_cosine():
    time = np.linspace(0.0, 3.0, 17)
    scale, rate = scipy.scale_motion(time, 1.2, 0.0, 2.0, 50.0, 0.0)
    assert_allclose(scale, 1.0 + 0.2 * np.cos(5.0 * time), atol=1e-12)
    assert_allclose(rate, -np.sin(5.0 * time), atol=1e-11)


def test_with_gas_the_scale_keeps_its_energy_and_swings_about_the_equilibrium():
    time = np.linspace(0.0, 5.0, 201)
    scale, rate = scipy.scale_motion(time, 1.0, 0.3, 2.0, 50.0, 10.0)
    energy = 0.5 * 2.0 * rate**2 + 0.5 * 50.0 * (scale - 1.0) ** 2 - 3 * 10.0 * np.log(scale)
    assert_allclose(energy, energy[0], rtol=0, atol=1e-11)
    rest = analytic.equilibrium_scale(10.0, 50.0)
    assert scale.min() < rest < scale.max()
    still, _ = scipy.scale_motion(time[:5], rest, 0.0, 2.0, 50.0, 10.0)
    assert_allclose(still, rest, rtol=1e-13)


def test_the_scale_at_a_time_does_not_depend_on_the_other_times():
    sparse, _ = scipy.scale_motion(np.array([0.0, 2.0]), 1.0, 0.0, 2.0, 50.0, 10.0)
    dense, _ = scipy.scale_motion(np.linspace(0.0, 2.0, 41), 1.0, 0.0, 2.0, 50.0, 10.0)
    assert sparse[0] == 1.0
    assert sparse[1] == pytest.approx(dense[-1], abs=1e-12)


def test_a_hanging_body_is_at_rest_under_its_load_and_held_where_it_is(cases, rng):
    x, triangles = cases.solid("icosahedron", 0.5)
    edges = cases.edges(triangles)
    rest, stiffness = lengths(x, edges) * rng.uniform(0.9, 1.1, len(edges)), rng.uniform(50.0, 100.0, len(edges))
    load, fixed = np.tile([0.0, 0.0, -0.5], (len(x), 1)), [0, 3, 7, 9]
    found = scipy.hanging(x, edges, rest, stiffness, triangles, 5.0, load, fixed)
    left = scipy.forces(found.positions, edges, rest, stiffness, triangles, 5.0) + load
    assert found.residual < 1e-13
    assert np.abs(np.delete(left, fixed, axis=0)).max() < 1e-11
    assert np.array_equal(found.positions[fixed], x[fixed])
    assert left[fixed].sum(axis=0) == pytest.approx(load.sum(axis=0)), "what is fixed carries all"


def test_what_is_between_plates_obeys_the_virial_identity_with_their_force_and_its_weight(cases, rng):
    x, triangles = cases.solid("icosahedron", 0.5)
    edges = cases.edges(triangles)
    rest, stiffness = lengths(x, edges) * rng.uniform(0.9, 1.1, len(edges)), rng.uniform(50.0, 100.0, len(edges))
    found, force = scipy.between_plates(x - (0.0, 0.0, x[:, 2].min()), edges, rest, stiffness, triangles, 5.0, 3.0, 0.6)
    length = lengths(found, edges)
    assert force > 5.0
    assert (found[:, 2].min(), found[:, 2].max()) == (0.0, 0.6)
    held = (stiffness * (length - rest) * length).sum() + force * 0.6 + 3.0 * found[:, 2].mean()
    assert held == pytest.approx(3.0 * 5.0, abs=1e-5)


def test_chains_are_joined_to_their_first_and_what_is_farther_is_not():
    points = np.array([(0.9 * k, 0.0, 0.0) for k in (0, 3, 1, 2)] + [(0.0, 1.1, 0.0), (9.0, 0.0, 0.0)])
    assert scipy.places_joined(points, 1.0).tolist() == [0, 0, 0, 0, 4, 5]


def test_dampers_act_along_their_edges_and_keep_momentum():
    x, v = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 5.0, 0.0]]), np.zeros((3, 3))
    v[1] = 1.0, 3.0, 0.0
    force = scipy.dampers(x, v, np.array([[0, 1]]), 2.0)
    assert_allclose(force, [[2.0, 0.0, 0.0], [-2.0, 0.0, 0.0], [0.0, 0.0, 0.0]])


def test_a_regular_solid_of_damped_springs_swings_as_the_oscillator_of_its_scale(cases):
    x, triangles = cases.solid("octahedron", 1.0)
    edges = cases.edges(triangles)
    rest = lengths(x, edges)
    squared, moment = np.sum(rest**2), np.sum(x**2) / len(x)
    frequency, damping = np.sqrt(30.0 * squared / moment), 0.1
    springs = edges, rest, np.full(len(edges), 30.0)
    found, _ = scipy.motion(1.1 * x, np.zeros_like(x), *springs, triangles, 0.0, 1.0 / len(x), 0.3, damping=damping)
    swing = float(analytic.damped_oscillation(0.3, frequency, damping * squared / moment))
    assert_allclose(found, (1.0 + 0.1 * swing) * x, atol=1e-11)


def test_the_energy_of_a_gas_is_the_same_far_away(cases):
    x, triangles = cases.solid("icosahedron", 0.7)
    edges = cases.edges(triangles)
    springs = edges, lengths(x, edges), np.full(len(edges), 50.0)
    here, there = (scipy.energy(x + away, *springs, triangles, 7.0) for away in (np.zeros(3), (1e4, -2e4, 3e4)))
    assert here == pytest.approx(there, abs=1e-9)  # places there are rounded to 4e-12 m
