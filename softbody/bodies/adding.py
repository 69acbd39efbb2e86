"""What is in a world comes into it, and leaves it: with names, and with handles that stay right."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from softbody.bodies.body import Body
from softbody.bodies.builder import (
    joints_that_stay,
    suspensions_that_stay,
    with_box,
    with_joint,
    with_soft_body,
    with_suspension,
    without,
)
from softbody.bodies.ground import Ground
from softbody.bodies.inside import check_fits, check_host, with_box_put
from softbody.bodies.joint import End, ends_of
from softbody.bodies.liquid import Liquid, check_level
from softbody.bodies.names import GONE
from softbody.bodies.rigid_box import Box
from softbody.bodies.soft_body import SoftBody
from softbody.bodies.store import FIRST_ROOM, Contents, Store
from softbody.bodies.suspended import checked_points, weights_in, with_box_hung
from softbody.collision.contact import remembered, remembering, without_box, without_soft
from softbody.compiler.interrupts import set_together
from softbody.dynamics.liquid_forces import corners_of
from softbody.errors import ParameterError
from softbody.mesh.mesh import Mesh
from softbody.model.arrays import NOBODY
from softbody.model.properties import check_self_contact, properties_of
from softbody.model.settings import RK4_VELOCITY
from softbody.model.validation import check_range, shown, vector


def add_soft_body(
    store: Store,
    mesh: Mesh,
    amounts: tuple[float, float | None, float | None],
    springs: tuple[ArrayLike, ArrayLike | None, ArrayLike | None],
    motion: tuple[ArrayLike, ArrayLike],
    fixed: ArrayLike,
    name: str | None,
    properties: dict[str, Any],
) -> int:
    """Do what `World.add_soft_body` says; return the body's number.

    `amounts`: mass, gas and pressure; `springs`: stiffness, rest length and tear_at; `motion`: position and velocity.
    """
    damping = properties["damping"]
    if damping is None and store.settings.integrator == RK4_VELOCITY:
        properties = {**properties, "damping": 0.0}
    if properties["self_contact"] is None:
        properties = {**properties, "self_contact": store.settings.self_contact}
    checked = _properties(store, "soft", properties)
    check_self_contact(store.settings, checked["soft_self_contact"])
    with store.exclusive():
        number = store.model.soft_count
        names = store.names.renamed(("soft", number), name)
        store.contents = Contents(with_soft_body(store.parts, mesh, amounts, springs, motion, fixed, checked), names)
        return number


def add_box(
    store: Store,
    size: ArrayLike,
    mass: float | None,
    pose: tuple[ArrayLike, ArrayLike],
    motion: tuple[ArrayLike, ArrayLike],
    inside: SoftBody | None,
    name: str | None,
    properties: dict[str, Any],
) -> int:
    """Do what `World.add_box` says; return the box's number.

    `pose`: position and orientation; `motion`: velocity and angular velocity.
    """
    checked = _properties(store, "box", properties)
    with store.exclusive():
        number = store.model.box_count
        names = store.names.renamed(("box", number), name)
        parts = with_box(store.parts, size, mass, pose, motion, checked)
        store.contents = Contents(parts if inside is None else with_box_put(store, parts, number, inside), names)
        return number


def add_joint(store: Store, ends: tuple[End, End], numbers: dict[str, tuple[float, str]], name: str | None) -> int:
    """Do what `World.add_joint` says; return the joint's number. `numbers`: name → value and unit."""
    checked = {f"joint_{key}": check_range(value, key, unit, least=0.0) for key, (value, unit) in numbers.items()}
    with store.exclusive():
        number = len(store.joints.joint_box)
        names = store.names.renamed(("joint", number), name)
        store.contents = Contents(with_joint(store.parts, ends_of(store, *ends), checked), names)
        return number


def suspend(
    store: Store,
    what: Box | ArrayLike,
    body: SoftBody,
    stiffness: float | None,
    damping: float | None,
    weights: str,
    name: str | None,
) -> int:
    """Do what `World.suspend` says; return the suspension's number."""
    stiffness = None if stiffness is None else check_range(stiffness, "stiffness", "N/m", least=0.0)
    damping = None if damping is None else check_range(damping, "damping", "N s/m", least=0.0)
    check_host(store, body, "body")
    with store.exclusive():
        number, row, parts = len(store.joints.suspension_box), body.row(), store.parts
        names = store.names.renamed(("suspension", number), name)
        if isinstance(what, Box):
            box = _free_box(store, what, body)
            corners = corners_of(store.model, store.state, box)
            check_fits(body, repr(what), corners)
            carried = weights_in(body, corners, weights, f"corner {{}} of box {box}")
            parts = with_box_hung(parts, store.settings, (row, box), carried, stiffness, damping)
        elif stiffness is None and damping is None:
            parts = with_suspension(
                parts, row, NOBODY, weights_in(body, checked_points(what), weights, "point {} of what")
            )
        else:
            raise ParameterError("stiffness and damping are for a box; points are carried as they are, leave them out")
        store.contents = Contents(parts, names)
        return number


def _free_box(store: Store, box: Box, body: SoftBody) -> int:
    """Return the number of a box that may be hung in a soft body; raises ParameterError."""
    if box.store is not store:
        raise ParameterError(f"what is {shown(box)}, a box of another world; give one of this world")
    row = box.row()
    if (store.joints.suspension_box == row).any():
        raise ParameterError(f"{box!r} hangs in {box.inside!r} already; remove that suspension first")
    if box.inside not in (None, body):
        raise ParameterError(f"{box!r} is inside {box.inside!r}; let its inside be None first")
    return row


def add_ground(store: Store, height: float, restitution: float, friction: float) -> None:
    """Do what `World.add_ground` says."""
    height, restitution = Ground.height.checked(height), Ground.restitution.checked(restitution)
    friction = Ground.friction.checked(friction)
    with store.exclusive():
        model = store.model._replace(
            ground_height=height,
            ground_restitution=restitution,
            ground_friction=0.0 if store.settings.frictionless else friction,
        )
        store.replace(model=model)


def add_liquid(store: Store, density: float, surface_height: float, drag: float, velocity: ArrayLike) -> None:
    """Do what `World.add_liquid` says."""
    numbers: dict[str, Any] = {
        "liquid_density": Liquid.density.checked(density),
        "liquid_surface_height": Liquid.surface_height.checked(surface_height),
        "liquid_drag": Liquid.drag.checked(drag),
        "liquid_velocity": vector(velocity, "velocity"),
    }
    check_level(store.controls.gravity)
    with store.exclusive():
        store.replace(model=store.model._replace(**numbers))


def remove(store: Store, body: Body) -> None:
    """Do what `World.remove` says."""
    if not isinstance(body, Body) or body.store is not store:
        raise ParameterError(f"{shown(body)} is no body of this world; give a handle of one, as of world.boxes")
    with store.exclusive():
        (kind, row), cache = body.who(), remembered(store.contacts)
        stay = {
            "joint": joints_that_stay(store.parts, kind, row),
            "suspension": suspensions_that_stay(store.parts, kind, row),
        }

        def then(of: str, number: int) -> int:
            """Return the number that one of a kind has afterwards."""
            if of in stay:
                return int(stay[of][:number].sum()) if stay[of][number] else GONE
            return number if of != kind or number < row else number - 1 if number > row else GONE

        names = store.names.renumbered(then)
        contents = Contents(without(store.parts, kind, row), names, is_fresh=store.contents.is_fresh)
        contacts = remembering(without_box(cache, row) if kind == "box" else without_soft(cache), FIRST_ROOM)
        moved = [(each, "_index", then(*each.who())) for each in store.held()]
        set_together((store, "contents", contents), (store, "contacts", contacts), *moved)


def _properties(store: Store, kind: str, given: dict[str, Any]) -> dict[str, Any]:
    """Return the properties of a new body of a kind, checked."""
    properties = properties_of(kind, given)
    return properties | ({f"{kind}_friction": 0.0} if store.settings.frictionless else {})
