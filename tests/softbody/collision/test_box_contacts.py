"""Are the contacts of boxes found, however many there are?"""

from softbody import World
from softbody.collision.box_contacts import find_box_contacts
from softbody.collision.contact import new_contacts
from softbody.collision.manifold import new_manifold


def test_contacts_beyond_the_capacity_are_counted_and_found_again_when_there_is_room():
    world = World()
    world.add_ground()
    for i in range(3):
        world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 0.5 + i))
    few = new_contacts(5)
    what = world.model, world.controls, world.state, new_manifold()
    more = find_box_contacts(*what, few, world.settings, 1e-3)
    assert few.number.tolist() == more.number.tolist() == [12, 12]
    assert more.depth.shape[0] >= 12
    assert (more.box[:5] == few.box).all()
    again = find_box_contacts(*what, more, world.settings, 1e-3)
    assert again.depth.shape == more.depth.shape
    assert (again.box[:12] == more.box[:12]).all()
