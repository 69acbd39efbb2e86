"""Do handles of bodies change what they say they change, and refuse nonsense?"""

import numpy as np
import pytest

import softbody
from softbody import ParameterError, World

pytestmark = pytest.mark.interpreted

BALL = softbody.icosphere(1)
SOLID = softbody.octahedron()


def test_changing_the_gas_between_steps_inflates_the_body():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(SOLID, 1.0, 100.0, 1.0)
    world.step(0.005, 4000)
    thin = body.volume
    body.gas = 100.0
    world.step(0.005, 4000)
    assert body.gas == 100.0
    assert body.volume > 1.1 * thin


@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf, None])
def test_gas_cannot_be_changed_to_nonsense(filled, value):
    body = softbody.SoftBody(filled, 0)
    with pytest.raises(ParameterError, match="gas"):
        body.gas = value
    assert body.gas == 1.0


def test_gas_may_not_become_negative():
    body = World().add_soft_body(SOLID, 1.0, 10.0, 1.0)
    with pytest.raises(ParameterError, match="gas is -1"):
        body.gas = -1.0


@pytest.mark.parametrize("force", [(np.inf, 0.0, 0.0), np.zeros((2, 3)), "up"])
def test_an_external_force_must_fit(force):
    body = World().add_soft_body(SOLID, 1.0, 10.0, 1.0)
    with pytest.raises(ParameterError, match="external_force"):
        body.external_force = force
    assert not body.external_force.any()


def test_an_external_force_belongs_to_its_body_and_stays_when_bodies_are_added():
    world = World(gravity=(0.0, 0.0, 0.0))
    world.add_soft_body(SOLID, 1.0, 10.0, 1.0)
    pushed = world.add_soft_body(SOLID, 1.0, 10.0, 1.0, position=(5.0, 0.0, 0.0))
    pushed.external_force = (0.0, 0.0, 2.0)
    third = world.add_soft_body(SOLID, 1.0, 10.0, 1.0, position=(10.0, 0.0, 0.0))
    assert world.controls.particle_force.sum(axis=0) == pytest.approx([0.0, 0.0, 12.0])
    assert not third.external_force.any()


def test_springs_can_be_changed_between_steps():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(SOLID, 1.0, 10.0, 0.0, damping=0.0)
    body.set_springs(rest_length=0.5 * 2.0**0.5)
    world.equilibrium()
    assert body.volume == pytest.approx(SOLID.volume / 8.0, rel=1e-9)
    stable = world.stable_time_step()
    body.set_springs(stiffness=40.0)
    assert world.stable_time_step() == pytest.approx(0.5 * stable, rel=1e-9)
    with pytest.raises(ParameterError, match="stiffness of edge 0 is -1"):
        body.set_springs(stiffness=-1.0)


def test_a_handle_of_a_body_that_is_not_there_says_so():
    world = World()
    fewer = world.snapshot()
    soft, box = world.add_soft_body(SOLID, 1.0, 10.0, 1.0), world.add_box((1.0, 1.0, 1.0), 1.0)
    for index in (1, -1, 1.5, None):
        with pytest.raises(ParameterError, match=r"soft body 1 is not in this world: there are 1|index is"):
            softbody.SoftBody(world, index)
        with pytest.raises(ParameterError, match=r"box 1 is not in this world: there are 1|index is"):
            softbody.Box(world, index)
    world.restore(fewer)
    for ask in ("positions", "velocities", "triangles", "centre", "volume", "pressure", "gas", "external_force"):
        with pytest.raises(ParameterError, match="soft body 0 is not in this world: there are 0"):
            getattr(soft, ask)
    for ask in ("position", "orientation", "velocity", "angular_velocity", "clear_forces"):
        with pytest.raises(ParameterError, match="box 0 is not in this world: there are 0"):
            getattr(box, ask)()
    for change in (
        lambda: setattr(soft, "gas", 1.0),
        lambda: setattr(soft, "external_force", (0.0, 0.0, 1.0)),
        lambda: soft.set_springs(1.0),
        lambda: box.apply_force((0.0, 0.0, 1.0)),
        lambda: box.apply_torque((0.0, 0.0, 1.0)),
    ):
        with pytest.raises(ParameterError, match="0 is not in this world"):
            change()


@pytest.fixture
def crowd():
    """A world of three soft bodies and three boxes, and their handles."""
    world = World(gravity=(0.0, 0.0, -1.0))
    world.add_ground()
    soft = [
        world.add_soft_body(BALL if i else SOLID, 1.0 + i, 100.0 + i, 10.0, (3.0 * i, 0.0, 0.95), friction=0.1 * i)
        for i in range(3)
    ]
    boxes = [world.add_box((1.0, 1.0, 0.2), 1.0 + i, (3.0 * i, 5.0, 0.1)) for i in range(3)]
    return world, soft, boxes


def test_a_world_lists_its_bodies_and_handles_of_one_body_are_equal(crowd):
    world, soft, boxes = crowd
    assert list(world.soft_bodies) == soft
    assert list(world.boxes) == boxes
    assert soft[0] != soft[1]
    assert soft[0] != boxes[0]
    assert len({*soft, *world.soft_bodies}) == 3
    assert repr(world).startswith("<World: 3 soft bodies of 90 particles, 3 boxes, ground at 0 m; 0 steps")
    assert repr(soft[1]) == "<soft body 1: 42 particles, 2 kg, at (3, 0, 0.95) m>"
    assert repr(boxes[2]) == "<box 2: (1, 1, 0.2) m, 3 kg, at (6, 5, 0.1) m>"


@pytest.mark.parametrize("which", [0, 1, 2])
@pytest.mark.parametrize("kind", ["soft", "box"])
def test_a_world_without_a_body_is_one_that_never_had_it(crowd, kind, which):
    """Bodies do not meet, so that none feels the one that is taken out."""
    world, soft, boxes = crowd
    world.step(2e-3, 20)
    twin = World(gravity=(0.0, 0.0, -1.0))
    twin.add_ground()
    for i in range(3):
        if (kind, i) != ("soft", which):
            mesh = BALL if i else SOLID
            twin.add_soft_body(mesh, 1.0 + i, 100.0 + i, 10.0, (3.0 * i, 0.0, 0.95), friction=0.1 * i)
    for i in range(3):
        if (kind, i) != ("box", which):
            twin.add_box((1.0, 1.0, 0.2), 1.0 + i, (3.0 * i, 5.0, 0.1))
    twin.step(2e-3, 20)
    gone = (soft if kind == "soft" else boxes)[which]
    world.remove(gone)
    for both in (world, twin):
        both.step(2e-3, 20)
    assert world.state_hash() == twin.state_hash()
    assert not gone.is_there
    assert repr(gone).endswith("that is gone>")
    with pytest.raises(ParameterError, match="was removed from its world"):
        world.remove(gone)


def test_handles_follow_their_bodies_when_others_are_removed(crowd):
    world, soft, boxes = crowd
    masses = soft[2].mass, boxes[2].mass
    world.remove(soft[0])
    world.remove(boxes[1])
    assert (soft[2].mass, boxes[2].mass) == masses
    assert (soft[1].index, soft[2].index, boxes[0].index, boxes[2].index) == (0, 1, 0, 1)
    later = world.add_box((1.0, 1.0, 1.0), 9.0, (0.0, 20.0, 0.0))
    assert (later.index, later.mass) == (2, 9.0)


def test_a_body_of_another_world_cannot_be_removed(crowd):
    world, soft, _ = crowd
    with pytest.raises(ParameterError, match="is no body of this world"):
        World().remove(soft[0])
    assert world.model.soft_count == 3


def test_what_is_set_between_steps_is_checked_and_read_again(crowd):
    _, soft, boxes = crowd
    before = [body.damping for body in soft]
    for body, names in (
        (soft[1], ("damping", "drag", "restitution", "friction", "deflated_below")),
        (
            boxes[1],
            ("restitution", "friction"),
        ),
    ):
        for name in names:
            setattr(body, name, 0.25)
            assert getattr(body, name) == 0.25
            with pytest.raises(ParameterError, match=f"^{name} is -1"):
                setattr(body, name, -1.0)
    assert [body.damping for body in soft] == [before[0], 0.25, before[2]]
    assert boxes[2].friction == 0.5


def test_drag_that_is_set_slows_from_the_next_step_on():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(SOLID, 1.0, 10.0, 0.0, velocity=(1.0, 0.0, 0.0))
    world.step(0.01, 100)
    assert body.velocity[0] == pytest.approx(1.0)
    body.drag = 1.0
    world.step(0.01, 100)
    assert body.velocity[0] == pytest.approx(np.exp(-1.0), rel=0.01)


def test_particles_are_pinned_and_let_go():
    world = World()
    body = world.add_soft_body(SOLID, 6.0, 100.0, 0.0, velocity=(0.0, 0.0, 1.0))
    body.fixed = [4, 5]
    assert body.fixed.tolist() == [4, 5]
    assert (body.velocities[[4, 5]] == 0.0).all()
    kept = body.positions[[4, 5]].copy()
    world.step(1e-3, 50)
    assert (body.positions[[4, 5]] == kept).all()
    body.fixed = ()
    assert body.mass == pytest.approx(6.0)
    before = 6.0 * body.velocity
    world.step(1e-3, 10)
    assert 6.0 * body.velocity - before == pytest.approx(np.array([0.0, 0.0, -6.0 * 9.81 * 0.01]), abs=1e-12)
    with pytest.raises(ParameterError, match="every vertex is fixed"):
        body.fixed = range(6)


def test_positions_and_velocities_may_be_assigned(crowd):
    _, soft, boxes = crowd
    shape = soft[0].positions.copy()
    soft[0].positions += (0.0, 0.0, 2.0)
    assert (soft[0].positions == shape + (0.0, 0.0, 2.0)).all()
    soft[0].velocities = (1.0, 2.0, 3.0)
    assert soft[0].velocity.tolist() == [1.0, 2.0, 3.0]
    boxes[0].position, boxes[0].velocity = (1.0, 1.0, 1.0), (0.0, 0.0, 1.0)
    boxes[0].orientation, boxes[0].angular_velocity = (0.0, 1.0, 0.0, 0.0), (0.0, 2.0, 0.0)
    assert boxes[0].position.tolist() == [1.0, 1.0, 1.0]
    assert boxes[0].orientation.tolist() == [0.0, 1.0, 0.0, 0.0]
    for body, name, value in (
        (soft[0], "positions", np.nan),
        (soft[0], "velocities", np.zeros((2, 3))),
        (boxes[0], "position", (0.0, 1.0)),
        (boxes[0], "orientation", (1.0, 1.0, 0.0, 0.0)),
    ):
        with pytest.raises(ParameterError, match=name):
            setattr(body, name, value)


def test_a_box_without_mass_is_static_until_it_is_given_a_velocity():
    wall = World().add_box((1.0, 1.0, 1.0), None)
    assert wall.mass is None
    wall.position = (1.0, 0.0, 0.0)
    assert repr(wall) == "<box 0: (1, 1, 1) m, static, at (1, 0, 0) m>"
    wall.world.run(1.0, 0.1)
    assert wall.position.tolist() == [1.0, 0.0, 0.0]
    assert not wall.is_kinematic
    wall.velocity = (1.0, 0.0, 0.0)
    assert wall.is_kinematic
    wall.world.run(1.0, 0.1)
    assert wall.position == pytest.approx([2.0, 0.0, 0.0])
    assert repr(wall) == "<box 0: (1, 1, 1) m, kinematic, at (2, 0, 0) m>"


HALF_TURN = (np.sqrt(0.5), 0.0, 0.0, -np.sqrt(0.5))


@pytest.mark.parametrize("world", [World(), World.paper()])
@pytest.mark.parametrize("step", [0.01, 0.03, 0.07, 0.5, 0.9])
def test_move_to_is_there_on_time_and_stays(step, world):
    gate = world.add_box((1.0, 1.0, 1.0), None, (0.0, 0.0, 1.0))
    gate.move_to((0.0, 2.0, 1.0), HALF_TURN, seconds=0.5)
    assert gate.is_kinematic
    gate.world.run(1.8, step)
    assert gate.position == pytest.approx([0.0, 2.0, 1.0], abs=1e-14)
    assert gate.orientation == pytest.approx(HALF_TURN, abs=1e-14)
    assert not gate.is_kinematic


def test_a_box_that_is_led_from_frame_to_frame_never_stops_between():
    gate = World().add_box((1.0, 1.0, 1.0), None)
    for k in range(1, 60):
        gate.move_to((np.sin(0.1 * k), 0.0, 0.0), seconds=1 / 60)
        assert gate.world.step_frame(1 / 60)
        assert gate.position == pytest.approx([np.sin(0.1 * k), 0.0, 0.0], abs=1e-14)


def test_velocities_that_are_set_end_a_way_and_last():
    gate = World().add_box((1.0, 1.0, 1.0), None)
    gate.move_to((1.0, 0.0, 0.0), seconds=1.0)
    gate.world.run(0.5, 0.01)
    gate.velocity = (0.0, 2.0, 0.0)
    gate.world.run(2.0, 0.01)
    assert gate.position == pytest.approx([0.5, 4.0, 0.0])


def test_a_lift_that_arrives_puts_its_load_down_gently():
    world = World()
    lift = world.add_box((1.0, 1.0, 0.2), None, (0.0, 0.0, -0.1))
    crate = world.add_box((0.4, 0.4, 0.4), 5.0, (0.0, 0.0, 0.2))
    lift.move_to((0.0, 0.0, 0.4), seconds=1.0)
    world.run(3.0, 1 / 240)
    assert lift.position[2] == pytest.approx(0.4, abs=1e-14)
    assert crate.position[2] == pytest.approx(0.7, abs=1e-4)
    assert np.abs(crate.velocity).max() < 1e-9


def test_a_way_is_saved_with_its_time_left():
    first = World()
    first.add_box((1.0, 1.0, 1.0), None).move_to((1.0, 0.0, 0.0), seconds=1.0)
    first.run(0.5, 0.01)
    second = World()
    second.restore(first.snapshot())
    for world in (first, second):
        world.run(1.0, 0.03)
        assert world.boxes[0].position == pytest.approx([1.0, 0.0, 0.0])
    assert first.state_hash() == second.state_hash()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"position": (0.0, np.nan, 0.0), "seconds": 1.0}, "position"),
        ({"orientation": (2.0, 0.0, 0.0, 0.0), "seconds": 1.0}, "orientation"),
        ({"position": (1.0, 0.0, 0.0), "seconds": 0.0}, "seconds"),
        ({"position": (1e300, 0.0, 0.0), "seconds": 1e-300}, "velocity"),
    ],
)
def test_move_to_refuses_nonsense_and_leaves_the_box_alone(arguments, message):
    gate = World().add_box((1.0, 1.0, 1.0), None, velocity=(0.0, 1.0, 0.0))
    with pytest.raises(ParameterError, match=message):
        gate.move_to(**arguments)
    assert gate.velocity.tolist() == [0.0, 1.0, 0.0]


def test_a_box_with_a_mass_is_not_moved_by_script():
    box = World().add_box((1.0, 1.0, 1.0), 2.0)
    with pytest.raises(ParameterError, match="box 0 has a mass of 2 kg, and is moved by forces"):
        box.move_to((1.0, 0.0, 0.0), seconds=1.0)


def test_a_kinematic_box_is_saved_with_its_velocities(tmp_path):
    world = World()
    world.add_box((1.0, 1.0, 1.0), None, velocity=(1.0, 0.0, 0.0), angular_velocity=(0.0, 2.0, 0.0))
    world.run(0.3, 0.01)
    world.save(tmp_path / "world.npz")
    again = World.load(tmp_path / "world.npz")
    for each in (world, again):
        each.run(0.3, 0.01)
    assert again.state_hash() == world.state_hash()
    assert again.boxes[0].is_kinematic


@pytest.mark.compiled
def test_what_a_kinematic_box_pushes_does_not_slow_it_and_gets_its_energy_from_it():
    world = World()
    ram = world.add_box((0.2, 1.0, 1.0), None, (0.0, 0.0, 0.5), velocity=(0.5, 0.0, 0.0))
    world.add_ground()
    box = world.add_box((0.5, 0.5, 0.5), 1000.0, (0.5, 0.0, 0.25))
    ball = world.add_soft_body(softbody.icosphere(1, 0.2), 1.0, 200.0, 5.0, (1.0, 0.0, 0.2))
    world.run(2.0, 1 / 960)
    assert ram.velocity.tolist() == [0.5, 0.0, 0.0]
    assert ram.position[0] == pytest.approx(1.0)
    assert box.position[0] == pytest.approx(1.35, abs=1e-4)
    assert ball.positions[:, 0].min() > box.position[0] + 0.24


def test_strain_and_springs_by_hand():
    body = World().add_soft_body(SOLID, 1.0, 10.0, 0.0, rest_length=1.0)
    assert body.strain == pytest.approx(np.full(12, np.sqrt(2.0) - 1.0))
    assert body.stiffness.tolist() == [10.0] * 12
    assert body.edges.max() == 5
    with pytest.raises(ValueError, match="read-only"):
        body.rest_length[0] = 2.0
