"""Does a body hold itself when it is told to, say why it cannot, and never lock?"""

import warnings

import numpy as np
import pytest

import softbody
from softbody import ParameterError, SelfIntersectionWarning, World
from softbody.geometry.self_intersections import self_intersections
from softbody.scenes.scene_file import read_scene


def meets_itself(body):
    pairs, same = self_intersections(np.array(body.positions), body.triangles, np.arange(len(body.positions)))
    return len(pairs) + len(same) > 0


def limp_ball(self_contact=True, **more):
    world = World()
    world.add_ground()
    body = world.add_soft_body(
        softbody.icosphere(2, 0.4), 1.0, 20.0, 0.05, (0.0, 0.0, 0.5), self_contact=self_contact, **more
    )
    return world, body


def folded_through_itself(body):
    """Push a cap of a ball of 0.5 m far in, and the opposite one out through it."""
    x = body.positions.copy()
    x[:, 2] = np.where(x[:, 2] > 0.3, -0.1 * x[:, 2] - 0.3, x[:, 2])
    x[:, 2] = np.where(x[:, 2] < -0.3, 0.3, x[:, 2])
    return x


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (-1.0, "self_contact is -1.0; give True, False, or a distance"),
        (0.1, r"self_contact is 0.1 m; give True, or at most 0.0016 m for this mesh"),
        ("yes", "self_contact is 'yes'; give a number"),
        (np.nan, "self_contact is nan"),
    ],
)
def test_a_distance_that_cannot_be_is_refused_before_anything_is_added(value, message):
    world = World()
    with pytest.raises(ParameterError, match=message):
        world.add_soft_body(softbody.icosphere(2, 0.4), 1.0, 20.0, 1.0, self_contact=value)
    assert not world.soft_bodies
    body = world.add_soft_body(softbody.icosphere(2, 0.4), 1.0, 20.0, 1.0)
    with pytest.raises(ParameterError, match=message):
        body.self_contact = value
    assert body.self_contact == 0.0


def test_the_papers_world_has_none():
    with pytest.raises(ParameterError, match='self_contact needs a world whose soft_contact is "together"'):
        World.paper().add_soft_body(softbody.icosphere(1, 0.4), 1.0, 20.0, 1.0, self_contact=True)
    body = World.paper().add_soft_body(softbody.icosphere(1, 0.4), 1.0, 20.0, 1.0)
    with pytest.raises(ParameterError, match="the paper has none"):
        body.self_contact = True
    with pytest.raises(ParameterError, match="the paper has none"):
        World.paper(self_contact=True)


def test_a_world_says_it_for_all_that_are_added(tmp_path):
    world = World(self_contact=True)
    given = {"mesh": softbody.icosphere(2, 0.4), "mass": 1.0, "stiffness": 20.0, "gas": 1.0}
    bodies = [world.add_soft_body(**given), world.add_soft_body(**given, self_contact=False)]
    bodies += [world.add_soft_body(**given, self_contact=1e-4)]
    world.save(tmp_path / "world.npz")
    other = World.load(tmp_path / "world.npz")
    bodies += [other.add_soft_body(**given)]
    assert [body.self_contact for body in bodies] == pytest.approx([1.6e-3, 0.0, 1e-4, 1.6e-3], rel=1e-2)


def test_the_distance_is_small_beside_the_mesh_and_between_its_features():
    world = World()
    ball = world.add_soft_body(softbody.icosphere(2, 0.4), 1.0, 20.0, 1.0, self_contact=True)
    given = world.add_soft_body(softbody.icosphere(2, 0.4), 1.0, 20.0, 1.0, self_contact=1e-4)
    flat = world.add_soft_body(softbody.box((1.0, 1.0, 2e-3), 4), 1.0, 20.0, 1.0, self_contact=True)
    none = world.add_soft_body(softbody.icosphere(2, 0.4), 1.0, 20.0, 1.0, self_contact=False)
    assert ball.self_contact == pytest.approx(1.6e-3)
    assert given.self_contact == 1e-4
    assert flat.self_contact <= 1e-3
    assert none.self_contact == 0.0


def test_a_limp_ball_does_not_go_through_itself_and_its_contacts_are_told():
    world, body = limp_ball()
    for _ in range(8):
        world.step(1e-3, 100)
        assert not meets_itself(body)
    own = world.contact_points().of(body, body)
    assert len(own) > 10
    assert (own.a == own.b).all()
    assert own.impulse.any(axis=1).any()


def test_it_may_be_switched_between_steps():
    world, body = limp_ball(False)
    world.step(1e-3, 50)
    body.self_contact = True
    world.step(1e-3, 500)
    assert not meets_itself(body)
    body.self_contact = False
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SelfIntersectionWarning)
        world.step(1e-3, 300)
    assert body.self_contact == 0.0
    assert meets_itself(body)


def test_what_meets_itself_waits_with_a_warning_and_holds_itself_when_it_has_parted():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(softbody.icosphere(3, 0.5), 1.0, 50.0, 5.0, self_contact=True, name="ball")
    world.step(1e-3)
    body.positions = folded_through_itself(body)
    assert meets_itself(body)
    with pytest.warns(SelfIntersectionWarning, match="soft body 0 'ball' meets itself before step 2: ") as told:
        world.step(1e-3, 10)
    assert len(told) == 1
    assert told[0].filename == __file__
    assert "does not hold itself until they have parted" in str(told[0].message)
    assert world.model.soft_self_contact[0] < 0.0
    assert body.self_contact > 0.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        while world.model.soft_self_contact[0] < 0.0 and world.steps < 3000:
            world.step(1e-3, 10)
    assert not meets_itself(body)
    assert world.model.soft_self_contact[0] > 0.0


def test_surfaces_that_share_a_vertex_do_not_lock():
    one = softbody.octahedron(0.3)
    vertices = np.concatenate([one.vertices, one.vertices + [0.6, 0.0, 0.0]])
    triangles = np.concatenate([one.triangles, one.triangles + len(one.vertices)])
    world = World()
    world.add_ground()
    body = world.add_soft_body(
        softbody.Mesh(vertices, triangles), 1.0, 50.0, 1.0, (0.0, 0.0, 0.5), (1.0, 0.0, 0.0), self_contact=True
    )
    with pytest.warns(SelfIntersectionWarning, match="soft body 0 meets itself before step 1"):
        world.step(1e-3, 600)
    assert body.centre[0] > 0.3


def test_a_bag_without_gas_lies_flat_and_has_not_collapsed():
    ball, world = softbody.icosphere(2, 0.4), World()
    mesh = softbody.Mesh(ball.vertices * [1.0, 1.0, 0.1], ball.triangles)
    world.add_ground()
    body = world.add_soft_body(mesh, 0.5, 30.0, 0.0, (0.0, 0.0, 0.06), self_contact=True)
    world.step(1e-3, 1500)
    assert not meets_itself(body)
    assert 0.0 < body.volume < 0.1 * mesh.volume
    assert body.pressure == 0.0


def test_fixed_particles_stay_where_they_are():
    world, body = limp_ball(fixed=[0, 5, 9])
    held = body.positions[[0, 5, 9]].copy()
    world.step(1e-3, 600)
    assert np.array_equal(body.positions[[0, 5, 9]], held)
    assert not meets_itself(body)


def test_a_snapshot_says_it_and_files_of_before_say_that_nobody_holds_itself():
    world, body = limp_ball()
    kept = world.snapshot()
    other = World()
    other.restore(kept)
    assert other.soft_bodies[0].self_contact == body.self_contact
    since = ("model.soft_self_contact", "settings.self_contact")
    old = {name: value for name, value in kept.items() if name not in since} | {"format": np.array(7)}
    other.restore(old)
    assert other.soft_bodies[0].self_contact == 0.0


def test_a_scene_says_true_or_a_distance(tmp_path):
    scene = """[[soft_body]]
shape = { name = "icosphere", subdivisions = 2, radius = 0.4 }
mass = 1.0
stiffness = 20.0
gas = 1.0
self_contact = VALUE
"""
    for value, distance in ("true", 1.6e-3), ("false", 0.0), ("1e-4", 1e-4):
        path = tmp_path / f"{value}.toml"
        path.write_text(scene.replace("VALUE", value))
        assert read_scene(path).world.soft_bodies[0].self_contact == pytest.approx(distance)


def test_what_is_thrown_flat_within_a_step_has_not_collapsed():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(softbody.icosphere(2, 0.4), 1.0, 20.0, 0.05, self_contact=True)
    body.velocities = np.multiply.outer(-60.0 * np.sign(body.positions[:, 2]), [0.0, 0.0, 1.0])
    momentum = world.linear_momentum()
    for _ in range(20):
        world.step(2e-3, allow_unstable=True)
        assert not meets_itself(body)
    assert np.allclose(world.linear_momentum(), momentum, atol=1e-9)


@pytest.mark.parametrize(
    ("mesh", "gas", "how"),
    [
        (softbody.icosphere(2, 0.4), 60.0, {}),
        (softbody.icosphere(2, 0.4), 60.0, {"substeps": 3}),
        (softbody.icosphere(2, 0.4), 60.0, {"integrator": "rk4"}),
        (softbody.icosphere(2, 0.4), 0.05, {}),
        (softbody.icosphere(2, 0.4), 0.05, {"substeps": 2}),
        (softbody.torus(0.4, 0.15, 18, 10), 60.0, {}),
        (softbody.torus(0.4, 0.15, 18, 10), 5.0, {}),
    ],
)
def test_a_body_alone_moves_as_it_does_beside_another(mesh, gas, how):
    """Alone it is moved by many steps at once while it is watched, up to where it might touch itself."""
    ends = []
    for is_alone in (True, False):
        world = World(**how)
        world.add_ground()
        world.add_soft_body(
            mesh, 1.0, 400.0 if gas > 1.0 else 20.0, gas, (0.0, 0.0, 0.6), (1.0, 0.0, 0.0), self_contact=True
        )
        if not is_alone:
            world.add_soft_body(softbody.icosphere(1, 0.4), 1.0, 400.0, 60.0, (100.0, 0.0, 0.6))
        for steps in (1, 300, 7, 200, 1):
            world.step(5e-4, steps)
        count = len(mesh.vertices)
        ends.append((world.state.particle_position[:count], world.state.particle_velocity[:count]))
    assert np.array_equal(ends[0][0], ends[1][0])
    assert np.array_equal(ends[0][1], ends[1][1])


def test_what_has_parted_has_no_contacts_any_more():
    world, body = limp_ball()
    world.step(1e-3, 500)
    assert len(world.contact_points().of(body, body))
    body.gas = 20.0
    world.step(1e-3, 700)
    assert not len(world.contact_points().of(body, body))
    assert not meets_itself(body)


def test_the_model_is_the_same_after_a_call():
    """Else what is known of it, as its stable step, would be found anew in each call."""
    world, _ = limp_ball()
    world.step(1e-3, 2)
    model = world.model
    for _ in range(3):
        world.step(1e-3)
    assert world.model is model


@pytest.mark.parametrize("far", [0.2, 0.3, 0.4])
def test_halves_do_not_go_through_each_other_in_one_step(far):
    """The body begins each step with nothing near itself."""
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(softbody.torus(0.5, 0.2, 20, 10), 1.0, 1e-3, 0.0, damping=0.0, self_contact=True)
    x = body.positions[:, 0]
    body.velocities = np.outer(-np.sign(x) * np.minimum(np.abs(x) / 0.3, 1.0), (far, 0.0, 0.0))
    for _ in range(2):
        world.step(1.0, allow_unstable=True)
        assert not meets_itself(body)
