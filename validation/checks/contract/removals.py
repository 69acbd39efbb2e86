"""Claims that a world from which something was taken is as if that had never been there."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from softbody import Box, Joint, ParameterError, SoftBody, World, icosahedron, octahedron, tetrahedron
from softbody.bodies import adding, builder
from softbody.bodies.names import Names
from validation.answers import Answers
from validation.cases import random_orientations, rotated, settable
from validation.check import Comparison, Run, check
from validation.checks.contract.cases import error_of
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

STEP, TURNS, GRAVITY = 1e-3, 40, (0.0, 0.0, -1.0)
Thing = SoftBody | Box | Joint
MORE: dict[type, tuple[str, ...]] = {  # that is told besides what may be set
    SoftBody: ("mass", "stiffness", "rest_length", "tear_at", "is_torn", "triangles", "edges", "volume"),
    Box: ("mass", "size"),
    Joint: ("ends", "length"),
}
KINDS = {"soft body": "add_soft_body", "box": "add_box", "joint": "add_joint"}


@dataclass(eq=False)
class Plan:
    """A body or a joint: what it is given, which others it joins, and what pushes it."""

    kind: str
    given: dict[str, Any]
    ends: list[Any] = field(default_factory=list)
    force: np.ndarray | float = 0.0

    def joins(self, other: Plan) -> bool:
        """Tell whether it is a joint of another one."""
        return any(isinstance(end, tuple) and end[0] is other for end in self.ends)


def planned_body(rng: np.random.Generator, number: int) -> Plan:
    """Return what a soft body or box is given, far from all others."""
    place = np.array([9.0 * number, 0.0, 0.0]) + rng.normal(size=3)
    given: dict[str, Any] = {"position": place, "velocity": rng.normal(size=3), "friction": rng.random()}
    given |= {"restitution": rng.random(), "mass": rng.uniform(0.5, 2.0)}
    if rng.random() < 0.5:
        turn, spin = random_orientations(rng, 1)[0], rng.normal(size=3)
        more = {"size": rng.uniform(0.2, 0.6, 3), "orientation": turn, "angular_velocity": spin}
        return Plan("box", given | more)
    mesh = rotated((tetrahedron, octahedron, icosahedron)[rng.integers(3)](0.5), rng)
    given |= {"mesh": mesh, "stiffness": rng.uniform(50.0, 100.0, len(mesh.edges)), "gas": rng.uniform(1.0, 5.0)}
    given |= {"damping": rng.random(), "drag": rng.random(), "fixed": rng.permutation(4)[: rng.integers(3)]}
    given |= {
        "liquid_density": rng.choice([0.0, rng.random()]),
        "sound_speed": rng.random(),
        "liquid_drag": rng.random(),
    }
    if not given["liquid_density"]:  # what tears holds none
        given["tear_at"] = rng.uniform(1.2, 3.0, len(mesh.edges))
    return Plan("soft body", given, force=0.1 * rng.normal(size=mesh.vertices.shape))


def planned_joint(rng: np.random.Generator, bodies: list[Plan]) -> Plan:
    """Return what a joint is given, and the plans of the bodies that it joins."""
    ends: list[Any] = [rng.normal(size=3) + 5.0]
    for k in rng.permutation(len(bodies))[: rng.integers(1, 3)]:
        body = bodies[k]
        is_particle = body.kind == "soft body" and rng.random() < 0.5
        ends.append((body, int(rng.integers(4)) if is_particle else body.given["position"] + 0.1 * rng.normal(size=3)))
    given = {"stiffness": rng.uniform(0.01, 0.05), "damping": 0.01 * rng.random(), "rest_length": rng.random()}
    return Plan("joint", given, ends[-2:])


def add(world: World, plan: Plan, there: dict[Plan, Thing], name: str | None) -> Thing:
    """Add what was planned to a world, in which others that were planned are `there`."""
    given = {**plan.given, "name": name}
    if plan.kind == "joint":
        a, b = ((there[end[0]], end[1]) if isinstance(end, tuple) else end for end in plan.ends)
        given |= {"a": a, "b": b}
    thing: Thing = getattr(world, KINDS[plan.kind])(**given)
    if isinstance(thing, SoftBody):
        thing.external_force = plan.force
    return thing


def who(world: World, name: str) -> tuple[str, int] | None:
    """Return the kind and number of who has a name in a world."""
    try:
        return world[name].kind, world[name].index
    except ParameterError:
        return None


def told(world: World, names: list[str]) -> dict[str, Any]:
    """Return all that a world tells of what is in it, and who has which name."""
    rows: dict[str, Any] = {}
    for thing in (*world.soft_bodies, *world.boxes, *world.joints):
        for name in (settable(type(thing)) | {*MORE[type(thing)]}) - {"target"}:
            rows[f"{thing.kind} {thing.index}: {name}"] = getattr(thing, name)
    for name in names:
        rows[name] = who(world, name) if name in world else None
    return rows | {"motion": world.state_hash(), "energy": world.energy(), "stable": world.stable_time_step()}


@check(
    section="beyond the paper",
    piece="softbody.World.remove, softbody.Body.name",
    reference="a world in which only what is left has ever been, by the same version",
    kind="the core in another form",
    because="the same bits",
    faults=(
        Fault(
            "joints of later bodies that hold other particles",
            builder.without,
            "count * (joints.joint_particles > first) → count * (joints.joint_particles > count)",
        ),
        Fault("a name that outlives its body", Names.renumbered, "who[1] != GONE → True"),
        Fault("a name of before", Names.renamed, "del whose[before], called[who] → del called[who]"),
        Fault("joints that go with any body", builder.joints_that_stay, "a_ & b_ → a_ & ~b_"),
        Fault("names of other kinds", adding.remove, "of != kind or number < row → number < row"),
    ),
)
def as_if_never_there(run: Run) -> Comparison:
    """What was removed leaves a world as if it never was there.

    Bodies and joints come, are named anew, and go, in any order, with the joints that they have. All that is told of
    those that are left, all names and all that they do afterwards is that of a world in which nobody else has been.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(10, 30, 200)):
        names = [f"n° {k}" for k in range(TURNS)]
        try:
            world, plans, called = come_and_go(rng, names)
        except Exception:
            answers.add(False, True, kind="all come and go")
            continue
        other, fresh = World(GRAVITY), dict[Plan, Thing]()
        for plan in plans:
            fresh[plan] = add(other, plan, fresh, called[plan])
        for when in ("at once", "later"):
            found, judged = told(world, names), told(other, names)
            answers.add(found.keys() == judged.keys(), True, kind=f"who is there, {when}")
            for key in judged:
                same = key in found and bool(np.array_equal(found[key], judged[key]))
                answers.add(same, True, kind=f"{key.partition(': ')[2] or key.partition(' ')[0]}, {when}")
            for each in (world, other):
                answers.add(error_of(Exception, each.step, STEP, 20) is None, True, kind=f"they go on, {when}")
    return answers.comparison()


def come_and_go(rng: np.random.Generator, names: list[str]) -> tuple[World, list[Plan], dict[Plan, str | None]]:
    """Return a world in which bodies and joints have come, been named, and gone; who is left, and their names."""
    world, plans, there, called = World(GRAVITY), list[Plan](), dict[Plan, Thing](), dict[Plan, str | None]()
    for turn, new in enumerate(names):
        what, name = rng.random(), new if rng.random() < 0.7 else None
        bodies = [plan for plan in plans if plan.kind != "joint"]
        if what < 0.2 and plans:
            gone = plans[rng.integers(len(plans))]
            world.remove(there[gone])
            plans = [plan for plan in plans if plan is not gone and not plan.joins(gone)]
        elif what < 0.3 and plans:
            named = plans[rng.integers(len(plans))]
            there[named].name = called[named] = name
        else:
            plan = planned_joint(rng, bodies) if what < 0.65 and bodies else planned_body(rng, turn)
            there[plan], called[plan] = add(world, plan, there, name), name
            plans.append(plan)
    return world, plans, called
