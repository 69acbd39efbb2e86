"""Films show how bodies turn: stripes and ribbons belong to the material."""

from __future__ import annotations

import numpy as np
import pytest

import softbody
from validation.pictures import SCENES, STRIPES, stripes_of, things


@pytest.mark.parametrize("mesh", [softbody.icosphere(3), softbody.torus()])
def test_stripes_run_around_the_axis_across_which_a_body_is_thinnest(mesh):
    body = softbody.World().add_soft_body(mesh, 1.0, 100.0, 1.0, (3.0, 2.0, 1.0))
    stripes = stripes_of(body)
    ahead = mesh.vertices[:, 0] > 0.9 * mesh.vertices[:, 0].max()
    assert (stripes[ahead & (np.abs(mesh.vertices[:, 1]) < 0.1)] > 0.0).all()
    turn = np.pi / STRIPES  # from the middle of a stripe to that of the next of the other colour
    angle = np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0])
    away = np.hypot(*mesh.vertices[:, :2].T) > 0.1
    assert (stripes[(np.abs(angle - turn) < 0.3 * turn) & away] < 0.0).all()


def test_every_film_begins_with_what_can_move_striped():
    for scene in SCENES:
        world = scene.build()
        stripes = [stripes_of(softbody.SoftBody(world, i)) for i in range(world.model.soft_count)]
        drawn = list(things(world, stripes))
        static = int((world.model.box_inverse_mass == 0.0).sum())
        assert sum(thing.stripes is None for thing in drawn) == static
        for thing in drawn:
            assert thing.stripes is None or (thing.stripes.min() < 0.0 < thing.stripes.max())
