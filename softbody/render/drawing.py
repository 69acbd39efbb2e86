"""Things of a world that are drawn, and their colours."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from softbody.bodies.rigid_box import Box, boxes_of
from softbody.bodies.soft_body import SoftBody, soft_bodies_of
from softbody.bodies.store import HasStore
from softbody.dynamics.joint_forces import joint_ends
from softbody.errors import ParameterError
from softbody.mesh.mesh import Mesh
from softbody.mesh.mesh import box as box_mesh
from softbody.model.arrays import NOBODY
from softbody.model.colours import STATIC, Colour, colour_of
from softbody.model.settings import check_name
from softbody.model.validation import check_range, check_yes_or_no, shown
from softbody.render.camera import Camera, framing
from softbody.render.colour_map import palette_of
from softbody.render.quantities import QUANTITIES
from softbody.render.rasteriser import Thing
from softbody.render.shadow import SLANT

PALE = 0.62  # of white in the colour of stripes
STRIPES = 4  # of each of its two colours, around a soft body
RIBBON = 0.1  # half the width of the ribbon around a box, of the box's longest side
HALF = 0.5  # of the way from the first to the last of two colours: the border between them


class Drawing:
    """How a world is drawn, again and again.

    `colour`: "stripes", which show how bodies turn: made from the shape that each has when it is first drawn, and kept;
    "plain"; or a quantity of soft bodies: "pressure" [Pa], "strain" (of each vertex the mean of its springs') or
    "speed" [m/s], by the `colour_map` "viridis" or "coolwarm" from the least to the greatest of `colour_range`, or of
    what is drawn if that is None. `show_joints`: as lines between their ends. Raises ParameterError for anything else.
    """

    def __init__(
        self,
        world: HasStore,
        colour: str = "stripes",
        colour_range: tuple[float, float] | None = None,
        colour_map: str = "viridis",
        show_joints: bool = True,
    ) -> None:
        check_name(colour, "colour", ("stripes", "plain", *QUANTITIES))
        self._world = world
        self._colour = colour
        self._range = None if colour_range is None else checked_range(colour_range)
        self._palette = palette_of(colour_map)
        self._show_joints = check_yes_or_no(show_joints, "show_joints")
        self._stripes: list[np.ndarray] = []

    def things(self) -> list[Thing]:
        """Return everything as meshes: soft bodies, then boxes; one looks into bodies with boxes inside.

        Raises ParameterError for what is nowhere.
        """
        world = self._world
        bodies, boxes = soft_bodies_of(world), [self._box(each) for each in boxes_of(world)]
        things = [*(self._by_quantity(bodies) if self._colour in QUANTITIES else map(self._soft, bodies)), *boxes]
        for host in set(world.store.model.box_host.tolist()) - {NOBODY}:
            things[host].is_clear = True
        for i, thing in enumerate(things):
            if not np.isfinite(thing.vertices).all():
                what = f"soft body {i}" if i < len(bodies) else f"box {i - len(bodies)}"
                raise ParameterError(f"{what} has a position that is not finite, so that it cannot be drawn")
        return things

    def joint_ends(self) -> np.ndarray:
        """Return the ends (j, 2, 3) [m] of the joints that are drawn; raises ParameterError for one that is nowhere."""
        if not self._show_joints:
            return np.empty((0, 2, 3))
        ends = joint_ends(self._world.store.joints, self._world.store.state)
        good = np.isfinite(ends).all(axis=(1, 2))
        if not good.all():
            raise ParameterError(f"joint {good.argmin()} has an end that is not finite, so that it cannot be drawn")
        return ends

    def _by_quantity(self, bodies: Sequence[SoftBody]) -> list[Thing]:
        """Return soft bodies, coloured by a quantity."""
        values = [QUANTITIES[self._colour](body) for body in bodies]
        least, greatest = self._range or _range_of(values)
        scale = 1.0 / (greatest - least) if greatest > least else 0.0
        shades = [np.clip((each - least) * scale, 0.0, 1.0) for each in values]
        return [Thing(body.positions, body.triangles, self._palette, along=s) for body, s in zip(bodies, shades)]

    def _soft(self, body: SoftBody) -> Thing:
        colour = colour_of(body.index)
        if self._colour == "plain":
            return Thing(body.positions, body.triangles, colour)
        while len(self._stripes) <= body.index:
            self._stripes.append(np.empty(0))
        if len(self._stripes[body.index]) != len(body.positions):
            self._stripes[body.index] = stripes_of(body)
        return Thing(body.positions, body.triangles, striped(colour), along=HALF + self._stripes[body.index])

    def _box(self, box: Box) -> Thing:
        size = box.size
        mesh, longest = _box_mesh(*size.tolist()), int(size.argmax())
        place = placed(mesh.vertices, box)
        if box.mass is None or self._colour in QUANTITIES:
            return Thing(place, mesh.triangles, STATIC, smooth=False)
        colour = colour_of(self._world.store.model.soft_count + box.index)
        if self._colour == "plain":
            return Thing(place, mesh.triangles, colour, smooth=False)
        ribbon = RIBBON * size[longest] - np.abs(mesh.vertices[:, longest])
        return Thing(place, mesh.triangles, striped(colour), smooth=False, along=HALF + ribbon / size[longest])


def checked_range(given: tuple[float, float]) -> tuple[float, float]:
    """Return the least and the greatest number that colours stand for; raises ParameterError."""
    try:
        low, high = given
    except (TypeError, ValueError) as error:
        raise ParameterError(f"colour_range is {shown(given)}; give the least and the greatest number") from error
    least = check_range(low, "least of colour_range")
    return least, check_range(high, "greatest of colour_range", above=least)


def _range_of(values: list[np.ndarray]) -> tuple[float, float]:
    if not values:
        return 0.0, 1.0
    return min(float(each.min()) for each in values), max(float(each.max()) for each in values)


def striped(colour: Colour) -> np.ndarray:
    """Return the two colours (2, 3) of what has stripes: beside them, and on them."""
    plain = np.array(colour)
    return np.array([plain, (1.0 - PALE) * plain + PALE])


def stripes_of(body: SoftBody) -> np.ndarray:
    """Return what is positive (n,) on the stripes of a soft body: across its surface, around the way it is thinnest."""
    x = body.positions - body.centre
    flat = 2 - int(np.argmin(np.ptp(x, axis=0)[::-1].round(6)))  # up, where it is as thin either way
    across, along = np.delete(x, flat, axis=1).T
    return np.hypot(across, along) * np.cos(STRIPES * np.arctan2(along, across))


@lru_cache(maxsize=256)
def _box_mesh(width: float, depth: float, height: float) -> Mesh:
    return box_mesh((width, depth, height), 2)


def placed(vertices: np.ndarray, where: Box) -> np.ndarray:
    """Return `vertices` (n, 3) of a box's own frame in the world [m]."""
    w, axis = where.orientation[0], where.orientation[1:]
    turn = 2.0 * np.cross(axis, vertices)
    return vertices + w * turn + np.cross(axis, turn) + where.position


def ground_of(world: HasStore) -> float | None:
    """Return the height of the ground [m], if there is one."""
    height = world.store.model.ground_height
    return height if height > -np.inf else None


def liquid_of(world: HasStore) -> float | None:
    """Return the height of the liquid's surface [m], if there is one."""
    model = world.store.model
    return model.liquid_surface_height if model.liquid_density > 0.0 else None


def framed(world: HasStore, things: Sequence[Thing], ends: np.ndarray, shape: float) -> Camera:
    """Return a camera that has all `things` in its picture, their shadows on the ground, and `ends` (j, 2, 3) [m].

    The picture is `shape` times as wide as high.
    """
    points = np.concatenate([*(thing.vertices for thing in things), np.empty((0, 3))])
    height = ground_of(world)
    if height is not None:
        shadows = points.copy()
        shadows[:, :2] -= (points[:, 2:] - height) * SLANT
        shadows[:, 2] = height
        points = np.concatenate([points, shadows])
    return framing(np.concatenate([points, ends.reshape(-1, 3)]), shape)
