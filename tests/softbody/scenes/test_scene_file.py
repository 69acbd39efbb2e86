"""Is a scene file the world that it says, and is all that is wrong in one said at once, by line?"""

import sys

import numpy as np
import pytest

import softbody
from softbody import MissingPackageError, ParameterError, SceneError, World
from softbody.scenes import from_file
from softbody.scenes.scene_file import read_scene

if sys.version_info < (3, 11):
    pytest.importorskip("tomli")

GOOD = """
[world]
gravity = [0.0, 0.0, -1.62]
integrator = "symplectic_euler"
speed_ceiling = inf

[ground]
height = -1.0
restitution = 0.25

[[soft_body]]
shape = { name = "octahedron", radius = 0.5 }
mass = 2
stiffness = 10
gas = 1.5
damping = 0.125
position = [1.0, 2.0, 3.0]
orientation = { axis = [0.0, 0.0, 2.0], degrees = 90 }
velocity = [0.0, 0.0, 1.0]
fixed = [0]
fixed_above = 3.4

[[box]]
size = [1.0, 2.0, 3.0]
static = true
friction = 0.75

[[box]]
size = [1, 1, 1]
mass = 4
orientation = [0.0, 1.0, 0.0, 0.0]
angular_velocity = [0.0, 0.0, 1.0]

[run]
seconds = 2
"""


@pytest.fixture
def scene(tmp_path):
    """Write a scene file; return its path."""

    def written(text):
        path = tmp_path / "scene.toml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return written


def wrong(path):
    """Return what a scene file is told, line by line, without its name."""
    with pytest.raises(SceneError) as caught:
        from_file(path)
    return [line.removeprefix(f"{path}:") for line in str(caught.value).split("\n")]


def test_a_scene_file_is_the_world_that_it_says(scene):
    world = from_file(scene(GOOD))
    np.testing.assert_array_equal(world.gravity, [0.0, 0.0, -1.62])
    assert world.integrator == "symplectic_euler"
    assert (world.model.ground_height, world.model.ground_restitution) == (-1.0, 0.25)
    (ball,), (still, moving) = world.soft_bodies, world.boxes
    # Its first corner, at x, is turned to y; that at +z, of number 4, is above 3.4 m.
    np.testing.assert_allclose(ball.positions[0], [1.0, 2.5, 3.0], atol=1e-15)
    assert ball.fixed.tolist() == [0, 4]
    assert (ball.mass, ball.gas, ball.damping) == (2.0, 1.5, 0.125)
    np.testing.assert_array_equal(ball.velocities[1], [0.0, 0.0, 1.0])
    assert (still.mass, still.friction, moving.mass) == (None, 0.75, 4.0)
    np.testing.assert_array_equal(moving.orientation, [0.0, 1.0, 0.0, 0.0])
    np.testing.assert_array_equal(moving.angular_velocity, [0.0, 0.0, 1.0])


def test_a_kinematic_box_of_a_scene_file_moves_as_it_says(scene):
    belt = from_file(scene("[[box]]\nsize = [1, 1, 1]\nkinematic = true\nvelocity = [0, 2, 0]")).boxes[0]
    belt.world.run(0.5, 0.01)
    np.testing.assert_allclose(belt.position, [0.0, 1.0, 0.0])


JOINED = """
[[soft_body]]
shape = { name = "octahedron", radius = 0.5 }
mass = 1
stiffness = 100
gas = 1
[[box]]
size = [1, 1, 1]
mass = 1
position = [3, 0, 0]
"""


def test_joints_of_a_scene_file_are_those_that_it_says(scene):
    text = """
[[joint]]
a = { soft_body = 0, particle = 4 }
b = { box = 0, at = [2.5, 0, 0] }
stiffness = 20
damping = 0.25
rest_length = 2
[[joint]]
a = [0, 0, 1]
b = { soft_body = 0, at = [0, 0, 0.7] }
stiffness = 10
"""
    world = from_file(scene(JOINED + text))
    between, hung = world.joints
    np.testing.assert_allclose(between.ends, [[0.0, 0.0, 0.5], [2.5, 0.0, 0.0]], atol=1e-15)
    assert (between.stiffness, between.damping, between.rest_length) == (20.0, 0.25, 2.0)
    np.testing.assert_allclose(hung.ends, [[0.0, 0.0, 1.0], [0.0, 0.0, 0.5]], atol=1e-15)
    assert (hung.stiffness, hung.damping, hung.rest_length) == (10.0, 0.0, 0.0)


def test_joints_of_a_scene_file_are_on_its_own_bodies_in_a_world_that_has_others(scene):
    world = World()
    world.add_box((9.0, 9.0, 9.0), 1.0)
    from_file(scene(JOINED + "[[joint]]\na = { box = 0, at = [3, 0, 0] }\nb = [0, 0, 0]\nstiffness = 1"), world)
    np.testing.assert_array_equal(world.joints[0].ends[0], world.boxes[1].position)


def test_all_that_is_wrong_with_joints_is_told_at_once(scene):
    text = """[[soft_body]]
shape = { name = "octahedron" }
mass = 1
stiffness = 100
[[box]]
size = [1, 1, 1]
mass = 1
[[joint]]
a = [0, 0]
b = { box = 1, at = [0, 0, 0] }
stiffness = -1
[[joint]]
a = { soft_body = 0, particle = 99 }
b = [0, 0, 0]
stiffness = 1
[[joint]]
a = { box = 0 }
b = "ceiling"
stifness = 1
[[joint]]
a = [0, 0, 0]
b = [0, 0, 1]
stiffness = 1
[[joint]]
a = { box = 0, particle = 3 }
b = { body = 0, at = [0, 0, 0] }
stiffness = 1
[[joint]]
a = { box = -1, at = [0, 0, inf], on = true }
b = { soft_body = 7, at = [0, 0, 0] }
stiffness = 1
"""
    told = wrong(scene(text))
    expected = (
        (1, "soft_body[0]: gas, or pressure, is missing; add one"),  # and so what is said of its joint is not known
        (9, "joint[0]: a is [0, 0]; give three finite numbers"),
        (10, "joint[0].b: there is no box 1; give a number from 0 to 0"),
        (11, "joint[0]: stiffness is -1.0; give a finite number ≥ 0 [N/m]"),
        (16, "joint[2]: stiffness is missing; add it"),
        (17, "joint[2].a is {'box': 0}; give a place, [x, y, z], or one on a body"),
        (18, "joint[2].b is 'ceiling'; give a place"),
        (19, "joint[2]: there is no 'stifness'; did you mean 'stiffness'?"),
        (21, "joint[3]: a and b are two places in the world"),
        (25, "joint[4].a is {'box': 0, 'particle': 3}; give a place"),
        (26, "joint[4].b is {'body': 0, 'at': [0, 0, 0]}; give a place"),
        (29, "joint[5].a: box is -1; give a whole number ≥ 0"),
        (29, "joint[5].a: at is [0, 0, inf]; give three finite numbers"),
        (29, "joint[5].a: there is no 'on'; choose from soft_body, box, suspension, at, particle, point"),
        (30, "joint[5].b: there is no soft_body 7; give a number from 0 to 0"),
    )
    for line, message in expected:
        assert any(each.startswith(f"{line}: ") and message in each for each in told), (line, message, told)
    assert len(told) == len(expected), told


NAMED = """
[[soft_body]]
name = "ball"
shape = { name = "octahedron", radius = 0.5 }
mass = 1
stiffness = 100
gas = 1
[[box]]
name = "lid"
size = [1, 1, 1]
mass = 1
position = [3, 0, 0]
[[joint]]
name = "cord"
a = { soft_body = "ball", particle = 4 }
b = { box = "lid", at = [2.5, 0, 0] }
stiffness = 20
"""


def test_bodies_and_joints_have_the_names_that_a_scene_file_gives_them(scene):
    world = from_file(scene(NAMED))
    assert world["ball"] == world.soft_bodies[0]
    assert world["lid"] == world.boxes[0]
    np.testing.assert_allclose(world["cord"].ends, [[0.0, 0.0, 0.5], [2.5, 0.0, 0.0]], atol=1e-15)


def test_all_that_is_wrong_with_names_is_told_at_once(scene):
    text = NAMED.replace("[2.5, 0, 0] }", "[2.5, 0, 0] }\ndamping = -1").replace("mass = 1\nstiff", "stiff")
    text += """[[box]]
name = "ball"
size = [1, 1, 1]
static = true
[[box]]
name = " "
size = [1, 1, 1]
static = true
[[joint]]
name = "cord"
a = { box = "lied", at = [0, 0, 0] }
b = { soft_body = "lid", at = [0, 0, 0] }
stiffness = 1
"""
    told = wrong(scene(text))
    expected = (
        (2, "soft_body[0]: mass is missing; add it"),
        (16, "joint[0]: damping is -1.0; give a finite number"),
        (19, "box[1]: name is 'ball', which soft_body[0] has; give another"),
        (23, "box[2]: name is ' '; give a text of 1 to 100 characters"),
        (27, "joint[1]: name is 'cord', which joint[0] has; give another"),
        (28, "joint[1].a: there is no box 'lied'; did you mean 'lid'? there are 'lid'"),
        (29, "joint[1].b: there is no soft_body 'lid'; there are 'ball'"),
    )
    for line, message in expected:
        assert any(each.startswith(f"{line}: ") and message in each for each in told), (line, message, told)
    assert len(told) == len(expected), told
    world = World()
    world.add_box((1.0, 1.0, 1.0), 1.0, name="lid")
    with pytest.raises(SceneError, match=r":9: box\[0\]: name is 'lid', which box 0 has; give another"):
        from_file(scene(NAMED), world)
    unnamed = NAMED.replace('name = "lid"\n', "")
    assert "there is no box 'lid'; none has a name: give it one" in wrong(scene(unnamed))[0]


def test_a_particle_that_an_end_cannot_be_on_is_told(scene):
    text = JOINED + "[[joint]]\na = { soft_body = 0, particle = 6 }\nb = [0, 0, 0]\nstiffness = 1"
    (told,) = wrong(scene(text))
    assert told.startswith("12: joint[0]: particle of a is 6, and <soft body 0")
    assert "begin each with [[joint]]" in wrong(scene(JOINED.replace("[[soft", "joint = 1\n[[soft")))[0]


def test_a_time_step_that_is_too_long_for_a_joint_is_told(scene):
    text = JOINED + "[[joint]]\na = { box = 0, at = [3, 0, 0] }\nb = [0, 0, 0]\nstiffness = 1e8\n"
    (told,) = wrong(scene(text + "[run]\nseconds = 1\ntime_step = 1e-3"))
    assert "run: time_step is 0.001 s, and a stable one is" in told


def test_a_scene_file_fills_a_world_by_the_world_s_own_settings(scene):
    world = World.paper()
    assert from_file(scene(GOOD), world) is world
    assert (world.store.settings.frictionless, world.integrator) == (True, "rk4_velocity")
    with pytest.raises(ParameterError, match=r"give a softbody\.World"):
        from_file(scene(GOOD), "world")
    assert from_file(
        scene("world = { paper = true, axes = 'complete' }\n" + GOOD.split("\n\n")[4])
    ).store.settings.frictionless


def test_every_error_is_told_at_once_with_its_line_and_cure(scene):
    text = """[wrold]
[world]
gravity = [0.0, -9.81]
iterations = true
integrater = "rk4"
[[soft_body]]
shape = { name = "icospher" }
mass = "1 kg"
stiffness = -200.0
gas = true
fixed = [
  1,
  2.5,
]
[[soft_body]]
shape = { name = "torus", major_radius = 0.1 }
mass = 1.0
stiffness = 1.0
gas = 1.0
[[soft_body]]
shape = { file = "nothing.ply" }
mass = 1.0
stiffness = 1.0
[[soft_body]]
shape = { name = "octahedron" }
mass = 1.0
stiffness = 1.0
gas = 1.0
fixed_above = 7.0
[[box]]
size = [1.0, 1.0, 1.0]
[run]
secnods = 3.0
[film]
file = "../film.webp"
colour = "strain"
"""
    pytest.importorskip("trimesh")
    told = wrong(scene(text))
    for line, message in (
        (1, "there is no 'wrold'; did you mean 'world'?"),
        (3, "world: gravity is [0.0, -9.81]; give three finite numbers"),
        (4, "world: iterations is true; give a number"),
        (5, "world: there is no 'integrater'; did you mean 'integrator'?"),
        (7, "soft_body[0].shape: name is 'icospher'; give"),
        (8, "soft_body[0]: mass is '1 kg'; give a number"),
        (9, "soft_body[0]: stiffness is -200.0; give a finite number ≥ 0 [N/m]"),
        (10, "soft_body[0]: gas is true; give a number"),
        (11, "soft_body[0]: each of fixed is 2.5; give a whole number ≥ 0"),
        (16, "soft_body[1].shape: major_radius 0.1 must exceed minor_radius 0.4"),
        (20, "soft_body[2]: gas, or pressure, is missing; add one"),
        (21, "nothing.ply cannot be read: No such file or directory"),
        (29, "soft_body[3]: fixed_above is 7.0 m, and no vertex is there"),
        (30, "box[0]: a box has a mass [kg], or static = true, or kinematic = true; give one of them"),
        (32, "run: seconds is missing; add it"),
        (33, "run: there is no 'secnods'; did you mean 'seconds'?"),
        (35, "film: file is '../film.webp'; give a name without folders"),
        (36, "film: colour strain needs a colour_range"),
    ):
        assert any(each.startswith(f"{line}: ") and message in each for each in told), (line, message, told)
    assert len(told) == 18
    assert [int(each.partition(":")[0]) for each in told] == sorted(int(each.partition(":")[0]) for each in told)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "there are no bodies; add [[soft_body]] or [[box]]"),
        (b"\x00\xff\xfe\x80", "is no text in UTF-8"),
        ("[run]".encode("utf-16"), "is no text in UTF-8"),
        (b"a = 1\na = 2\n", "is no TOML: Cannot overwrite a value (at line 2"),
        (b"a = " + b"[" * 9_000, "is no TOML"),
        (b"#" * 2**21, "has more than 1048576 bytes"),
        (b"[[box]]\nsize = [1, 1, 1]\nkinematic = true\nmass = 1", "give one of them"),
        (b"box = { size = 1 }", "begin each with [[box]]"),
        (b"box = [1]", "box[0] is 1; give a table"),
        (b"run = 1\n[[box]]\nsize = [1, 1, 1]\nmass = 1", "run is 1; give a table"),
        (b"[[soft_body]]\nshape = 1", "soft_body[0].shape is 1; give { name ="),
        (b"[[box]]\nsize = [1, 1, 1e999]\nmass = 1", "size is [1, 1, inf]; give three finite numbers"),
        (b"[[box]]\nsize = [1, 1, 1]\nmass = 1979-05-27", "mass is datetime.date(1979, 5, 27); give a number"),
        (b"[[box]]\nsize = [1, 1, 1]\nmass = 1\norientation = { axis = [0, 0, 0], degrees = 1 }", "with a direction"),
        (b"[[box]]\nsize = [1, 1, 1]\nmass = 1\norientation = [1, 1, 0, 0]", "has length 1.41421"),
        (
            b"[[box]]\nsize = [1, 1, 1]\nstatic = true\nvelocity = [1, 0, 0]",
            "velocity is not for a static box; say kinematic = true",
        ),
        (b"a" + b" . b" * 100_000 + b" = 1", "a key of more than 200 parts"),
        (b"[[" + b'a."b".' * 1_000 + b"a]]", "a key of more than 200 parts"),
        (b"a = " + b"[" * 100_000, "is no TOML"),
    ],
)
def test_whatever_is_no_scene_is_one_typed_error(scene, content, message):
    assert any(message in line for line in wrong(scene(content)))


def test_a_byte_order_mark_and_windows_lines_are_read(scene):
    path = scene(b"\xef\xbb\xbf[[box]]\r\nsize = [1, 1, 1]\r\nmass = 1\r\n")
    assert from_file(path).model.box_count == 1


def test_what_is_no_file_is_said(tmp_path):
    assert wrong(tmp_path) == [f"{tmp_path} cannot be read: Is a directory; give the name of a scene file"]
    assert "No such file" in wrong(tmp_path / "none.toml")[0]
    with pytest.raises(ParameterError, match="give the name of a file"):
        from_file(3)


def test_a_time_step_that_is_not_stable_is_told_before_any_work(scene):
    body = "[[soft_body]]\nshape = { name = 'octahedron' }\nmass = 1.0\nstiffness = 1e6\ngas = 1.0\n"
    told = wrong(scene(f"{body}[run]\nseconds = 1.0\ntime_step = 1e-2\n"))
    assert len(told) == 1
    assert told[0].startswith("8: run: time_step is 0.01 s, and a stable one is ")
    assert "≤ 0.0166667 [s]" in wrong(scene(f"{body}[run]\nseconds = 1.0\ntime_step = 1.0\n"))[0]


def test_a_mesh_file_lies_beside_the_scene_file(scene, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    part = softbody.octahedron(1000.0)
    trimesh.Trimesh(part.vertices, part.triangles).export(tmp_path / "part.stl")
    body = "[[soft_body]]\nshape = { file = 'part.stl', merge = true, scale = 1e-3 }\nmass = 1\nstiffness = 1\ngas = 1"
    assert from_file(scene(body)).soft_bodies[0].volume == pytest.approx(softbody.octahedron().volume)
    told = wrong(scene(body.replace("merge = true, ", "")))
    assert told[0].startswith("2: soft_body[0].shape: ")
    assert "merge=True" in told[0]


def test_a_library_that_is_missing_is_named(scene, monkeypatch):
    body = "[[soft_body]]\nshape = { file = 'part.stl' }\nmass = 1\nstiffness = 1\ngas = 1"
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(MissingPackageError, match="pip install trimesh"):
        from_file(scene(body))
    (told,) = wrong(scene(f"{body}\ngass = 1"))  # what is wrong in the file comes first
    assert told.startswith("6: soft_body[0]: there is no 'gass'; did you mean 'gas'?")
    monkeypatch.setitem(sys.modules, "tomllib", None)
    monkeypatch.setitem(sys.modules, "tomli", None)
    with pytest.raises(MissingPackageError, match=r"needs tomli: pip install softbody\[scenes\]"):
        from_file(scene(GOOD))


def test_how_it_is_run_is_read(scene):
    read = read_scene(scene(GOOD + "frames_per_second = 20\n[film]\ncolour = 'speed'\ncolour_range = [0, 2]\n"))
    assert read.run == (2.0, 20.0, None, True)
    assert read.film == ("film.webp", 20.0, "speed", (0.0, 2.0), (640, 480), True)


def test_a_body_whose_file_says_no_damping_has_that_of_a_body_made_without(scene):
    text = GOOD.replace("damping = 0.125\n", "")
    alike = World().add_soft_body(softbody.octahedron(0.5), 2.0, 10.0, 1.5)
    assert from_file(scene(text)).soft_bodies[0].damping == alike.damping > 0.0
    paper = text.replace('"symplectic_euler"', '"rk4_velocity"')
    assert from_file(scene(paper)).soft_bodies[0].damping == 0.0


def test_choices_hold_in_place_of_the_file_s_own(scene):
    text = GOOD.replace("damping = 0.125\n", "")
    world = read_scene(scene(text), integrator="rk4_velocity").world
    assert (world.integrator, world.gravity[2], world.soft_bodies[0].damping) == ("rk4_velocity", -1.62, 0.0)
