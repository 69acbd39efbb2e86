"""Is a name that was mistyped, or is only to be read, an error that says which one was meant?"""

import pytest

import softbody

WORLD = softbody.World()
BALL = WORLD.add_soft_body(softbody.octahedron(), 1.0, 10.0, 1.0)
BOX = WORLD.add_box((1.0, 1.0, 1.0), 1.0, (9.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("what", "name", "said"),
    [
        (WORLD, "gravty", "a World has no 'gravty' to set; did you mean 'gravity'?"),
        (WORLD, "step", "a World has no 'step' to set"),
        (WORLD, "boxes", "'boxes' of a World is only to be read"),
        (WORLD, "precision", "'precision' of a World is only to be read"),
        (BALL, "gass", "a SoftBody has no 'gass' to set; did you mean 'gas'?"),
        (
            BALL,
            "volume",
            "'volume' of a SoftBody is only to be read; settable are angular_velocity, damping,",
        ),
        (BALL, "index", "'index' of a SoftBody is only to be read"),
        (BOX, "mass", "'mass' of a Box is only to be read; settable are angular_velocity, friction, inside, name,"),
    ],
)
def test_it_is(what, name, said):
    with pytest.raises(AttributeError) as error:
        setattr(what, name, 1.0)
    assert str(error.value).startswith(said)


@pytest.mark.parametrize(
    ("what", "name", "said"),
    [
        (WORLD, "gravty", "a World has no 'gravty'; did you mean 'gravity'?"),
        (BALL, "presure", "a SoftBody has no 'presure'; did you mean 'pressure'?"),
        (BOX, "zzz", "a Box has no 'zzz'"),
        (softbody, "Wrld", "module 'softbody' has no attribute 'Wrld'; did you mean 'World'?"),
        (softbody, "zzz", "module 'softbody' has no attribute 'zzz'"),
    ],
)
def test_a_name_that_there_is_none_of_says_which_was_meant(what, name, said):
    with pytest.raises(AttributeError) as error:
        getattr(what, name)
    assert str(error.value) == said


def test_the_package_lists_what_is_public():
    assert set(dir(softbody)) == {*softbody.__all__, "__version__"}
