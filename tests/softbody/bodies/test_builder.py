"""Does a body become what it was asked to be, and is what is wrong refused by name?"""

import inspect
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import get_type_hints

import numpy as np
import pytest

import softbody
from softbody import ParameterError, World
from softbody.bodies.builder import Parts, appended, default_damping, soft_body_alone
from softbody.dynamics.joint_forces import no_joints
from softbody.model.arrays import Model, Property
from softbody.model.properties import properties_of

pytestmark = pytest.mark.interpreted

G = 9.81
BALL = softbody.icosphere(1)
SOLID = softbody.octahedron()
NAN, INF = float("nan"), float("inf")


def test_bodies_added_later_join_in_and_leave_the_earlier_ones_alone():
    world = World()
    first = world.add_soft_body(SOLID, 1.0, 10.0, 1.0, position=(0.0, 0.0, 5.0))
    world.step(1e-3, 100)
    moved = first.positions.copy()
    second = world.add_soft_body(BALL, 2.0, 20.0, 2.0, position=(9.0, 0.0, 5.0))
    box = world.add_box((1.0, 1.0, 1.0), 1.0, position=(-9.0, 0.0, 0.0))
    assert first.positions.tolist() == moved.tolist()
    assert second.positions == pytest.approx(BALL.vertices + [9.0, 0.0, 5.0])
    world.step(1e-3, 100)
    alone = World()
    twin = alone.add_soft_body(SOLID, 1.0, 10.0, 1.0, position=(0.0, 0.0, 5.0))
    alone.step(1e-3, 200)
    assert first.positions.tolist() == twin.positions.tolist()
    assert second.centre[2] < 5.0
    assert box.position[2] < 0.0
    assert (first.gas, second.gas) == (1.0, 2.0)


def test_a_soft_body_starts_at_rest_in_the_shape_of_its_mesh_where_it_was_put():
    world = World()
    body = world.add_soft_body(BALL, 3.0, 10.0, 6.0, position=(1.0, 2.0, 3.0), velocity=(4.0, 5.0, 6.0))
    assert body.centre == pytest.approx([1.0, 2.0, 3.0], abs=1e-14)
    assert body.velocities.tolist() == [[4.0, 5.0, 6.0]] * 42
    assert body.volume == pytest.approx(BALL.volume, rel=1e-13)
    assert body.pressure == pytest.approx(6.0 / BALL.volume, rel=1e-13)
    assert world.linear_momentum() == pytest.approx([12.0, 15.0, 18.0], rel=1e-13)
    lengths = np.linalg.norm(np.diff(BALL.vertices[BALL.edges], axis=1)[:, 0], axis=1)
    assert world.model.edge_rest_length == pytest.approx(lengths, rel=1e-13)


def test_a_stiffness_for_each_edge_is_kept_in_the_order_of_the_edges():
    world = World()
    world.add_soft_body(SOLID, 1.0, np.arange(12.0), 0.0)
    assert world.model.edge_stiffness.tolist() == list(range(12))
    assert world.model.edge_particles.tolist() == SOLID.edges.tolist()


def test_a_world_does_not_share_memory_with_the_arrays_it_was_given():
    stiffness, position, gravity = np.ones(12), np.zeros(3), np.array([0.0, 0.0, -G])
    world = World(gravity=gravity)
    world.add_soft_body(SOLID, 1.0, stiffness, 0.0, position=position)
    stiffness[:], position[:], gravity[:] = 9.0, 9.0, 9.0
    world.state.particle_position[:] += 1.0
    assert world.model.edge_stiffness.tolist() == [1.0] * 12
    assert world.controls.gravity.tolist() == [0.0, 0.0, -G]
    assert SOLID.vertices[0].tolist() == [1.0, 0.0, 0.0]


def test_a_box_shows_what_it_was_given():
    world = World()
    box = world.add_box((1.0, 2.0, 3.0), 12.0, (1.0, 2.0, 3.0), (0.6, 0.8, 0.0, 0.0), (4.0, 5.0, 6.0), (7.0, 8.0, 9.0))
    assert box.position.tolist() == [1.0, 2.0, 3.0]
    assert box.orientation == pytest.approx([0.6, 0.8, 0.0, 0.0], rel=1e-15)
    assert box.velocity.tolist() == [4.0, 5.0, 6.0]
    assert box.angular_velocity.tolist() == [7.0, 8.0, 9.0]
    assert 1.0 / world.model.box_inverse_inertia[0] == pytest.approx([13.0, 10.0, 5.0], rel=1e-15)


def test_a_quaternion_rounded_to_single_precision_is_taken_and_made_unit():
    world = World()
    box = world.add_box((1.0, 1.0, 1.0), 1.0, orientation=np.full(4, 0.5, np.float32) * np.float32(1 + 3e-7))
    assert np.linalg.norm(box.orientation) == pytest.approx(1.0, abs=1e-15)


def test_a_soft_body_alone_is_as_if_it_had_been_added_alone():
    def added(world):
        return world.add_soft_body(
            BALL, 2.0, np.arange(1.0, 121.0), 3.0, (9.0, 0.0, 5.0), fixed=[3], damping=0.1, drag=0.2
        )

    world, alone = World(), World()
    world.add_soft_body(SOLID, 1.0, 10.0, 1.0)
    world.add_box((1.0, 1.0, 1.0), 1.0)
    for each in (world, alone):
        added(each).external_force = (1.0, 2.0, 3.0)
        each.add_ground()
    found = soft_body_alone(Parts(world.model, world.controls, world.state, world.store.rings, world.store.joints), 1)
    without_ground = alone.model._replace(ground_height=-np.inf)
    expected = Parts(without_ground, alone.controls, alone.state, alone.store.rings, no_joints())
    for mine, yours in zip(found, expected, strict=True):
        for name in mine._fields:
            assert np.array_equal(getattr(mine, name), getattr(yours, name), equal_nan=True), name


def test_appending_keeps_what_was_there_and_copies_seldom():
    rows = np.empty((0, 3))
    kept, memories = [], set()
    for k in range(100):
        rows = appended(rows, np.full((2, 3), k))
        kept.append(rows)
        memories.add(rows.ctypes.data)
    assert rows.tolist() == np.repeat(np.arange(100.0), 2)[:, None].repeat(3, axis=1).tolist()
    assert kept[30].tolist() == rows[:62].tolist()
    assert rows.flags.c_contiguous
    assert len(memories) < 12
    assert appended(np.arange(3), 7).tolist() == [0, 1, 2, 7]


SOFT = {"mesh": SOLID, "mass": 1.0, "stiffness": 10.0, "gas": 1.0}
BAD_SOFT = [
    ("mass", INF),
    ("mass", None),
    ("mass", "heavy"),
    ("mass", 1j),
    ("mass", 10**400),
    ("stiffness", INF),
    ("stiffness", np.ones(11)),
    ("stiffness", np.ones((12, 1))),
    ("stiffness", "stiff"),
    ("stiffness", [[1.0], [1.0, 2.0]]),
    ("gas", INF),
    ("gas", None),
    ("position", (0.0, 0.0)),
    ("position", (0.0, 0.0, NAN)),
    ("position", "here"),
    ("position", (1e20, 0.0, 0.0)),
    ("velocity", (0.0, INF, 0.0)),
    ("velocity", 3.0),
    ("restitution", -0.1),
    ("restitution", 1.1),
    ("restitution", NAN),
    ("friction", NAN),
    ("friction", INF),
    ("mesh", (SOLID.vertices, SOLID.triangles)),
    ("mesh", None),
]
BOX = {"size": (1.0, 2.0, 3.0), "mass": 1.0}
BAD_BOX = [
    ("size", (1.0, -1.0, 1.0)),
    ("size", (1.0, NAN, 1.0)),
    ("size", (1.0, INF, 1.0)),
    ("size", (1.0, 1.0)),
    ("size", 1.0),
    ("mass", 0.0),
    ("mass", NAN),
    ("mass", "heavy"),
    ("orientation", (1.0, 1.0, 0.0, 0.0)),
    ("orientation", (0.0, 0.0, 0.0, 0.0)),
    ("orientation", (NAN, 0.0, 0.0, 0.0)),
    ("orientation", (1.0, 0.0, 0.0)),
    ("orientation", "up"),
    ("orientation", (1.00001, 0.0, 0.0, 0.0)),
    ("velocity", (NAN, 0.0, 0.0)),
    ("angular_velocity", (0.0, 0.0, INF)),
    ("restitution", 2.0),
]


@pytest.mark.parametrize(("name", "value"), BAD_SOFT)
def test_a_soft_body_is_refused_by_the_name_of_its_bad_parameter(filled, name, value):
    with pytest.raises(ParameterError, match=name):
        filled.add_soft_body(**{**SOFT, name: value})


@pytest.mark.parametrize("value", [-5.0, NAN, INF])
def test_a_bad_stiffness_of_one_edge_is_named_by_that_edge(filled, value):
    stiffness = np.ones(12)
    stiffness[7] = value
    with pytest.raises(ParameterError, match="stiffness of edge 7"):
        filled.add_soft_body(**{**SOFT, "stiffness": stiffness})


@pytest.mark.parametrize(("name", "value"), BAD_BOX)
def test_a_box_is_refused_by_the_name_of_its_bad_parameter(filled, name, value):
    with pytest.raises(ParameterError, match=name):
        filled.add_box(**{**BOX, name: value})


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fixed": range(6)}, "every vertex is fixed"),
        ({"fixed": [6]}, "fixed vertex 6 does not exist"),
        ({"fixed": [-1]}, "fixed vertex -1 does not exist"),
        ({"fixed": [0.5]}, "fixed is"),
        ({"rest_length": 0.0}, "rest_length of edge 0 is 0.0; give a finite length > 0"),
        ({"rest_length": [1.0, 2.0]}, "rest_length does not fit"),
        ({"tear_at": 1.0}, "tear_at of edge 0 is 1.0; give length / rest length > 1, or 0 for never"),
        ({"tear_at": [2.0, 2.0]}, "tear_at does not fit; give one number or one for each of the 12 edges"),
        ({"leak": -1.0}, "leak is -1.0"),
        ({"deflated_below": 1.5}, "deflated_below is 1.5"),
    ],
)
def test_wrong_options_of_a_soft_body_are_refused_by_name(options, message):
    world = World()
    with pytest.raises(ParameterError, match=message):
        world.add_soft_body(SOLID, 1.0, 10.0, 1.0, **options)
    assert len(world.state.particle_position) == 0


ONE_MORE = """
from softbody import World, octahedron
world = World()
world.add_soft_body(octahedron(), 1.0, 10.0, 1.0)
world.add_soft_body(octahedron(), 1.0, 10.0, 1.0, (5.0, 0.0, 0.0), stickiness=1.5)
twin = World()
twin.restore(world.snapshot())
print(*twin.model.soft_stickiness)
try:
    world.add_soft_body(octahedron(), 1.0, 10.0, 1.0, (9.0, 0.0, 0.0), stickiness=2.5)
except ValueError as error:
    print(error)
"""


def test_one_more_property_of_each_body_is_one_edit_and_a_keyword(tmp_path):
    core = Path(softbody.__file__).parent
    shutil.copytree(core, tmp_path / "softbody", ignore=shutil.ignore_patterns("__pycache__"))
    arrays = tmp_path / "softbody" / "model" / "arrays.py"
    line = '    soft_stickiness: Annotated[np.ndarray, Property(0.25, "Sticks.", "N", most=2.0, since=99)]\n'
    arrays.write_text(arrays.read_text().replace("    soft_damping:", line + "    soft_damping:", 1))
    world = tmp_path / "softbody" / "world.py"
    keyword = world.read_text().replace(
        "        drag: float = 0.0,", "        drag: float = 0.0, stickiness: float = 0.25,", 1
    )
    world.write_text(keyword.replace('"drag": drag,', '"drag": drag, "stickiness": stickiness,', 1))
    environment = os.environ | {"PYTHONPATH": str(tmp_path), "NUMBA_DISABLE_JIT": "1", "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, "-c", ONE_MORE], cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout == "0.25 1.5\nstickiness is 2.5; give a finite number ≥ 0 and ≤ 2 [N]\n"


def test_every_property_in_the_model_is_taken_by_name_and_has_its_default():
    notes = {
        name: getattr(hint, "__metadata__", (None,))[0]
        for name, hint in get_type_hints(Model, include_extras=True).items()
    }
    noted = {name: note for name, note in notes.items() if isinstance(note, Property)}
    assert {"soft_restitution", "soft_friction", "soft_damping", "box_friction"} < noted.keys()
    for kind in ("soft", "box"):
        of_kind = {name: note for name, note in noted.items() if name.startswith(f"{kind}_")}
        assert properties_of(kind, {}) == {name: note.default for name, note in of_kind.items()}
        given = {name.removeprefix(f"{kind}_"): 0.25 for name in of_kind}
        assert properties_of(kind, given) == dict.fromkeys(of_kind, 0.25)


def test_every_property_is_a_keyword_with_the_default_of_the_model():
    for kind, add in ("soft", World.add_soft_body), ("box", World.add_box):
        keywords = inspect.signature(add).parameters
        for name, value in properties_of(kind, {}).items():
            keyword = keywords[name.removeprefix(f"{kind}_")]
            assert keyword.kind is keyword.KEYWORD_ONLY
            assert keyword.default == (None if name == "soft_self_contact" else value), name
        assert not any(each.kind is each.VAR_KEYWORD for each in keywords.values())


@pytest.mark.parametrize(("name", "hint"), [("fricton", r"did you mean 'friction'\? "), ("zzz", "")])
def test_an_argument_that_is_mistyped_is_refused_with_the_one_that_was_meant(filled, name, hint):
    with pytest.raises(ParameterError, match=f"add_soft_body has no '{name}'; {hint}choose from mesh, mass, stiffness"):
        filled.add_soft_body(**SOFT, **{name: 0.5})
    with pytest.raises(ParameterError, match=f"add_box has no '{name}'; {hint}choose from size, mass, position"):
        filled.add_box(**BOX, **{name: 0.5})


def test_a_pressure_is_a_gas_in_the_volume_of_the_mesh():
    world = World()
    body = world.add_soft_body(BALL, 1.0, 10.0, pressure=200.0)
    assert (body.gas, body.pressure) == pytest.approx((200.0 * BALL.volume, 200.0), rel=1e-13)
    body.positions *= 1.1
    assert body.pressure == pytest.approx(200.0 / 1.1**3, rel=1e-12)
    body.pressure = 300.0
    assert (body.gas, body.pressure) == pytest.approx((300.0 * body.volume, 300.0), rel=1e-13)


def test_the_pressure_of_a_body_full_of_liquid_is_at_least_that_of_the_liquid():
    body = World().add_soft_body(BALL, 1.0, 10.0, 0.0, liquid_density=1000.0, sound_speed=10.0)
    body.positions *= 0.99
    least = body.pressure
    body.pressure = least + 5.0
    assert body.gas == pytest.approx(5.0 * body.volume)
    with pytest.raises(ParameterError, match=r"pressure is 0\.0; give a finite number ≥ "):
        body.pressure = 0.0


@pytest.mark.parametrize("given", [{}, {"gas": 1.0, "pressure": 1.0}, {"gas": None, "pressure": None}])
def test_one_of_gas_and_pressure_is_given(given):
    world = World()
    with pytest.raises(ParameterError, match=r"give either gas \[J\] or pressure \[Pa\], one of the two"):
        world.add_soft_body(BALL, 1.0, 10.0, **given)
    assert world.model.soft_count == 0


@pytest.mark.parametrize("stiffness", [0.0, 1e-300, 1e6, 1.7e308, np.finfo(float).max])
@pytest.mark.parametrize("mass", [1e-300, 1.0, 1e300])
def test_the_default_damping_is_finite_whatever_the_springs_and_masses(stiffness, mass):
    with np.errstate(all="raise", under="ignore"):
        damping = default_damping(np.full(7, stiffness), mass)
    assert 0.0 <= damping < np.inf
    assert damping == pytest.approx(0.1 * np.sqrt(2.0) * np.sqrt(stiffness) * np.sqrt(mass), rel=1e-14)


def test_springs_are_damped_by_a_tenth_of_critical_unless_told_otherwise():
    world = World()
    each = np.arange(1.0, 121.0)
    assert world.add_soft_body(BALL, 2.0, each, 1.0).damping == pytest.approx(0.1 * np.sqrt(2.0 * 60.5 * 2.0 / 42))
    assert world.add_soft_body(BALL, 2.0, each, 1.0, damping=None).damping == world.soft_bodies[0].damping
    assert world.add_soft_body(BALL, 2.0, each, 1.0, damping=0.0).damping == 0.0
    assert world.add_soft_body(BALL, 2.0, 0.0, 1.0).damping == 0.0


@pytest.mark.parametrize("world", [World.paper(), World(integrator="rk4_velocity")])
def test_springs_are_not_damped_where_the_integrator_damps(world):
    assert world.add_soft_body(BALL, 2.0, 10.0, 1.0).damping == 0.0
    assert world.add_soft_body(BALL, 2.0, 10.0, 1.0, damping=0.5).damping == 0.5
    world.integrator = "rk4"
    assert world.soft_bodies[0].damping == 0.0
    assert world.add_soft_body(BALL, 2.0, 10.0, 1.0).damping > 0.0
