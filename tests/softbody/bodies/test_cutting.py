"""Soft bodies are cut and joined: what each piece has, who they are, and what is refused."""

import numpy as np
import pytest

from softbody import ParameterError, SoftBody, World, box, icosphere, torus


def ball(world, **options):
    options = {"velocity": (1.0, 2.0, 3.0), "name": "ball", **options}
    return world.add_soft_body(icosphere(2), 2.0, 100.0, 3.0, **options)


def totals(bodies):
    mass = sum(body.mass for body in bodies)
    centre = sum(body.masses @ body.positions for body in bodies) / mass
    push = sum(body.masses @ body.velocities for body in bodies)
    turn = sum(body.masses @ np.cross(body.positions, body.velocities) for body in bodies)
    return np.concatenate([[mass], centre, push, turn])


@pytest.fixture
def moving():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = ball(world)
    world.run(0.05)
    body.velocities[:] += 0.3 * np.random.default_rng(0).normal(size=body.velocities.shape)
    return world, body


def test_pieces_share_what_there_was(moving):
    world, body = moving
    before, energies, pressure, volume, gas = totals([body]), world.energies(), body.pressure, body.volume, body.gas
    pieces = body.cut(body.centre + (0.1, 0.0, 0.0), (1.0, 0.3, 0.0))
    assert pieces == world.soft_bodies
    assert [piece.name for piece in pieces] == ["ball", "ball.1"]
    assert pieces[0] == body
    assert pieces[0].volume > pieces[1].volume
    assert totals(pieces) == pytest.approx(before, rel=1e-13, abs=1e-13)
    assert sum(piece.volume for piece in pieces) == pytest.approx(volume, rel=1e-13)
    assert sum(piece.gas for piece in pieces) == pytest.approx(gas, rel=1e-14)
    assert [piece.pressure for piece in pieces] == pytest.approx([pressure] * 2, rel=1e-12)
    assert np.sum(world.energies().spring) == pytest.approx(np.sum(energies.spring), rel=1e-12)
    assert np.sum(world.energies().gas) == pytest.approx(np.sum(energies.gas), abs=1e-12)
    world.run(0.1)


def test_halves_are_whole_again_when_they_are_joined(moving):
    world, body = moving
    volume, spring = body.volume, np.sum(world.energies().spring)
    before = totals([body])
    one, other = body.cut(body.centre + (0.1, 0.0, 0.0), (1.0, 0.3, 0.0))
    whole = world.join(one, other, within=1e-9)
    assert world.soft_bodies == (whole,)
    assert one == other == body == whole
    assert whole.name == "ball"
    assert whole.volume == pytest.approx(volume, rel=1e-13)
    assert whole.gas == pytest.approx(3.0, rel=1e-14)
    assert totals([whole]) == pytest.approx(before, rel=1e-13, abs=1e-13)
    assert np.sum(world.energies().spring) == pytest.approx(spring, rel=1e-12)
    world.run(0.1)


def test_a_tube_joins_two_bodies():
    world = World(gravity=(0.0, 0.0, 0.0))
    a, third = ball(world), world.add_soft_body(box(), 1.0, 10.0, 0.0, position=(9.0, 0.0, 0.0), name="third")
    b = world.add_soft_body(icosphere(1), 3.0, 200.0, 1.0, position=(2.1, 0.0, 0.0), name="b")
    lid = world.add_box((0.1, 0.1, 0.1), 0.1, position=(2.1, 0.0, 0.0), inside=b)
    joint = world.add_joint((b, (3.1, 0.0, 0.0)), (4.0, 0.0, 0.0), 1.0)
    before, place = totals([a, b]), joint.ends[0].copy()
    joined = world.join(b, a, (1.05, 0.0, 0.0))
    assert (joined.name, a, lid.inside) == ("b", b, joined)
    assert world["third"] == third
    assert totals([joined]) == pytest.approx(before, rel=1e-13)
    assert joined.gas == 4.0
    assert joint.ends[0] == pytest.approx(place, abs=1e-12)
    assert len(joined.triangles) == len(icosphere(2).triangles) + len(icosphere(1).triangles) + 4
    world.run(0.1)


def test_joints_boxes_and_pins_go_with_their_piece():
    world = World()
    top = int(icosphere(2).vertices[:, 2].argmax())
    body, other = ball(world, fixed=[top]), ball(world, name="other")
    other.positions += (5.0, 0.0, 0.0)
    down = body.positions[:, 2].argmin()
    inside = world.add_box((0.1, 0.1, 0.1), 0.1, position=(0.0, 0.0, -0.5), inside=body)
    joints = [
        world.add_joint((body, top), (0.0, 0.0, 3.0), 1.0),
        world.add_joint((body, int(down)), (0.0, 0.0, -3.0), 1.0),
        world.add_joint((other, (6.0, 0.0, 0.0)), (7.0, 0.0, 0.0), 1.0),
    ]
    places, pinned = [joint.ends.copy() for joint in joints], body.positions[top].copy()
    body.external_force = (0.0, 0.0, 1.0)
    upper, lower = body.cut((0.0, 0.0, 0.05), (0.0, 0.0, -1.0))
    assert [joint.ends for joint in joints] == [pytest.approx(place, abs=1e-12) for place in places]
    assert inside.inside == upper  # the larger one, below
    assert sum(piece.external_force.sum(axis=0)[2] for piece in (upper, lower)) == pytest.approx(162.0)
    held = [piece.positions[piece.fixed] for piece in (upper, lower)]
    assert np.concatenate(held) == pytest.approx(pinned[None])
    body.fixed = ()
    assert upper.mass + lower.mass == pytest.approx(2.0, rel=1e-14)


def test_a_cut_world_is_saved_and_restored(moving, tmp_path):
    world, body = moving
    body.cut(body.centre, (0.0, 1.0, 0.2))
    world.save(tmp_path / "cut.npz")
    again = World.load(tmp_path / "cut.npz")
    assert again["ball.1"].masses.tolist() == world["ball.1"].masses.tolist()
    world.run(0.05, 1e-3)
    again.run(0.05, 1e-3)
    assert again.state_hash() == world.state_hash()


@pytest.mark.parametrize("liquid", [0.0, 50.0])
def test_shares_of_a_liquid_are_of_one_pressure(liquid):
    world = World()
    body = ball(world, liquid_density=liquid, sound_speed=5.0)
    body.positions *= 0.95
    pressure, mass = body.pressure, body.mass
    pieces = body.cut((0.1, 0.0, 0.0), (1.0, 0.0, 0.0))
    assert sum(piece.mass for piece in pieces) == pytest.approx(mass, rel=1e-14)
    assert [piece.pressure for piece in pieces] == pytest.approx([pressure] * 2, rel=1e-12)
    world.snapshot()
    world.restore(world.snapshot())


def test_what_cannot_be_cut_is_told_and_stays():
    world = World()
    body = ball(world)
    box_inside = world.add_box((0.2, 0.2, 0.2), 0.1, inside=body, name="lid")
    before = world.state_hash()
    for error, arguments in {
        "the plane misses": ((0.0, 0.0, 2.0), (0.0, 0.0, 1.0)),
        "goes through box 0 'lid'": ((0.0, 0.0, 0.05), (0.0, 0.0, 1.0)),
        "normal is": ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        "point": ((np.nan, 0.0, 0.0), (0.0, 0.0, 1.0)),
    }.items():
        with pytest.raises(ParameterError, match=error):
            body.cut(*arguments)
    with pytest.raises(ParameterError, match="radius is -1"):
        body.cut((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), radius=-1.0)
    with pytest.raises(ParameterError, match=r"radius is 0\.7 m, and the section at hand reaches to"):
        body.cut((0.3, 0.0, 0.5), (0.0, 0.0, 1.0), radius=0.7)
    box_inside.inside = None
    world.suspend([[0.1, 0.0, 0.0]], body, name="eye")
    with pytest.raises(ParameterError, match="suspension 0 'eye' hangs in"):
        body.cut((0.0, 0.0, 0.5), (0.0, 0.0, 1.0))
    assert (world.state_hash(), len(world.soft_bodies)) == (before, 1)


def test_what_cannot_be_joined_is_told_and_stays():
    world = World()
    a, b = ball(world), ball(world, name="b", position=(4.0, 0.0, 0.0))
    wet = ball(world, name="wet", position=(0.0, 2.05, 0.0), liquid_density=10.0)
    for error, given in {
        "a tube between them": (a, b, (1.25, 0.0, 0.0)),
        "liquids do not mix": (a, wet, (0.0, 1.0, 0.0)),
        "give two bodies": (a, a, (0.0, 0.0, 0.0)),
        "no soft body of this world": (a, ball(World()), (0.0, 0.0, 0.0)),
        "give a place where": (a, b),
    }.items():
        with pytest.raises(ParameterError, match=error):
            world.join(*given)
    with pytest.raises(ParameterError, match="0 pairs of particles of both, and no two triangles"):
        world.join(a, b, within=0.1)
    assert len(world.soft_bodies) == 3


def test_a_ring_is_cut_open():
    world = World(gravity=(0.0, 0.0, 0.0))
    ring = world.add_soft_body(torus(1.0, 0.3, 24, 10), 1.0, 50.0, 1.0, name="ring")
    (string,) = ring.cut((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), radius=0.5)
    assert isinstance(string, SoftBody)
    assert string == ring
    assert len(world.soft_bodies) == 1
    world.run(0.2)
