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
        (BALL, "volume", "'volume' of a SoftBody is only to be read; settable are damping, deflated_below, drag,"),
        (BALL, "index", "'index' of a SoftBody is only to be read"),
        (BOX, "mass", "'mass' of a Box is only to be read; settable are angular_velocity, friction, inside, name,"),
    ],
)
def test_it_is(what, name, said):
    with pytest.raises(AttributeError) as error:
        setattr(what, name, 1.0)
    assert str(error.value).startswith(said)
