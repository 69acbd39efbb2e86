"""Claims that soft bodies that are joined have together what they had, and are one."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

import softbody
from softbody import Mesh, ParameterError, SimulationError, SoftBody, World
from softbody.bodies import cutting, joining, sharing, soft_rows
from softbody.mesh import union
from validation.answers import Answers
from validation.cases import MESH_KINDS, edge_lengths, random_mesh
from validation.check import Comparison, Run, check
from validation.checks.worlds.cases import WEIGHTLESS
from validation.checks.worlds.cutting import anywhere, is_sound, is_whole, pulls_at, refusal, running, whole
from validation.fault import Fault

FAMILY = "bodies that are cut and joined"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

check_join = partial(check, section="beyond the paper", piece="softbody.World.join")


def metre(kind: str, rng: np.random.Generator) -> Mesh:
    """Return a mesh of a kind, a metre long, about the origin."""
    mesh = random_mesh(kind, rng)
    mesh = mesh.scaled(1.0 / float(np.ptp(mesh.vertices, axis=0).max()))
    return mesh.moved(-mesh.vertices.mean(axis=0))


def pair(rng: np.random.Generator, case: int) -> tuple[World, SoftBody, SoftBody, np.ndarray]:
    """Return two bodies that shake, near each other, in a world with others, and a place between them."""
    world = World(WEIGHTLESS)
    one, other = (metre(MESH_KINDS[(case * by) % len(MESH_KINDS)], rng) for by in (1, 5))
    way = rng.normal(size=3)
    way /= np.linalg.norm(way)
    near, far = one.vertices[np.argmax(one.vertices @ way)], other.vertices[np.argmin(other.vertices @ way)]
    place = near + 0.05 * way
    world.add_soft_body(softbody.icosphere(1, 0.1), 1.0, 100.0, 1.0, (-9.0, 0.0, 0.0), name="first")
    springs = [rng.uniform(50.0, 300.0, len(mesh.edges)) for mesh in (one, other)]
    a = world.add_soft_body(
        one, rng.uniform(0.5, 2.0), springs[0], rng.uniform(1.0, 5.0), name="a" if case % 2 else None
    )
    last = world.add_soft_body(softbody.icosphere(1, 0.1), 1.0, 100.0, 1.0, (9.0, 0.0, 0.0), name="last")
    b = world.add_soft_body(
        other, rng.uniform(0.5, 2.0), springs[1], rng.uniform(1.0, 5.0), near + 0.1 * way - far, name="b"
    )
    if case % 3 == 1:
        a, b = b, a
    for each in (a, b):
        shape = each.positions.shape
        each.velocities = rng.normal(size=3) + 0.3 * rng.normal(size=shape)
        each.external_force = rng.normal(size=shape)
        world.add_joint((each, each.positions[int(rng.integers(shape[0]))].copy()), (last, last.centre), 1.0)
    world.step(1e-4, 20, allow_unstable=True)
    return world, a, b, place


def tube(before: tuple[SoftBody, ...]) -> set[tuple[bytes, ...]]:
    """Return all triangles of bodies, by the bits of their corners."""
    return {
        tuple(sorted(corner.tobytes() for corner in corners))
        for each in before
        for corners in each.positions[each.triangles]
    }


@check_join(
    reference="the same before, by NumPy's sums; triangles nearest to the place by libigl, volumes and χ by trimesh",
    engines=("igl", "trimesh"),
    kind="invariant",
    unit="of the largest of the three, or 1",
    tolerance=1e-13,
    because="rounding of sums over some thousand particles: 4.8e-15 at worst of three seeds",
    faults=(
        Fault("a tube that is turned", union.zipped, "triangles[b][::-1] → triangles[b]"),
        Fault(
            "a tube from another triangle", joining._zipped, "len(a_.triangles) + of_b → len(a_.triangles) + of_b - 1"
        ),
        Fault("the longest tube", union.zipped, "np.argmin(lengths) → np.argmax(lengths)"),
        Fault(
            "gas of one",
            joining._together,
            "both.controls['soft_gas'] + b_.controls['soft_gas'] → both.controls['soft_gas']",
        ),
        Fault(
            "springs softer",
            joining._springs,
            "np.where(is_new, a_, stiffness) → np.where(is_new, a_, 0.99 * stiffness)",
        ),
        Fault("joints to the body before", soft_rows.moved_joints, "np.append(shift, 0)[body_of(particles)] → 0"),
        Fault("a name that is lost", joining._names, "names_.name(('soft', first)) or n_ → None"),
        Fault(
            "forces of the other in another order",
            joining._rows_of,
            "np.add.at(summed, now[stays], force[stays]) → np.add.at(summed, now[stays], force[stays][::-1])",
        ),
    ),
)
def tube_adds_up(run: Run) -> Comparison:
    """Two bodies and a tube between them are one.

    Bodies of every kind of mesh that shake, with unequal springs, forces and joints, among others: mass and its centre,
    momenta, springs' energy, gas, forces and torques are those of both, the volume is that of both and of the tube,
    which is between the triangles nearest to the place, and the shortest; χ is that of both, less 2. Handles, names and
    joints go on.
    """
    from references import igl, trimesh

    rng, answers, refused, cases = run.fresh_rng(), Answers(), 0, run.count(12, 48, 400)
    for case in range(cases):
        world, a, b, place = pair(rng, case)
        bodies, ends = (a, b), [joint.ends.copy() for joint in world.joints]
        before, old = whole(bodies), tube(bodies)
        volume = sum(trimesh.volume(each.positions, each.triangles) for each in bodies)
        euler = sum(trimesh.topology(each.positions, each.triangles)[2] for each in bodies) - 2
        nearest = [float(igl.closest_points(place[None], each.positions, each.triangles)[0][0]) for each in bodies]
        corners = {
            tuple(sorted(x.tobytes() for x in rows)): rows for each in bodies for rows in each.positions[each.triangles]
        }
        name = a.name or b.name
        count = len(world.soft_bodies)
        try:
            joined = world.join(a, b, place)
        except ParameterError as error:
            if "goes through their skins" in str(error) or "a tube between them" in str(error):
                refused += 1  # some are of such shapes
                continue
            answers.add([0.0] * 3, [1.0] * 3, kind=str(error))
            continue
        for what, row in before.rows().items():
            answers.add(whole((joined,)).rows()[what], row, float(np.abs(row).max(initial=1.0)), what)
        now = tube((joined,))
        points = joined.positions
        new = [rows for rows in points[joined.triangles] if tuple(sorted(x.tobytes() for x in rows)) not in old]
        gone = [corners[key] for key in old - now]
        if len(gone) == 2:
            flat = np.concatenate([*new, *(rows[::-1] for rows in gone)])
            more = -trimesh.volume(flat, np.arange(len(flat)).reshape(-1, 3)[:, ::-1])
            away = [float(igl.closest_points(place[None], rows, np.array([[0, 1, 2]]))[0][0]) for rows in gone]
            answers.add([joined.volume, *np.sort(away)], [volume + more, *np.sort(nearest)], 1.0, "volume, and where")
            lengths = [np.square(gone[0] - np.roll(gone[1][::-1], k, axis=0)).sum() for k in range(3)]
            straight = 0.5 * (
                np.square(np.diff(np.concatenate([new, np.array(new)[:, :1]], axis=1), axis=1)).sum()
                - sum(np.square(rows - np.roll(rows, 1, axis=0)).sum() for rows in gone)
            )
            diagonals = [
                np.square(gone[0] - np.roll(gone[1][::-1], k + s, axis=0)).sum() for k in range(3) for s in (1, -1)
            ]
            best = int(np.argmin(lengths))
            off = min(abs(straight - lengths[best] - each) for each in diagonals[2 * best : 2 * best + 2])
            answers.add([off, 0.0, 0.0], [0.0] * 3, 1.0, "the shortest")
        else:
            answers.add([float(len(gone)), 0.0, 0.0], [2.0, 0.0, 0.0], kind="triangles that are gone")
        sound = is_sound(joined)
        answers.add([sound[-1], sum(sound[:5]), count - 1], [euler, 5.0, len(world.soft_bodies)], kind="χ")
        there = [a == b == joined, joined.name == name, [each.name for each in world.soft_bodies].count("last") == 1]
        answers.add(np.array(there, float), [1.0] * 3, kind="handles")
        for joint, at in zip(world.joints, ends):
            answers.extend(joint.ends, at, 10.0, "joints")
    answers.add([float(2 * refused < cases), 0.0, 0.0], [1.0, 0.0, 0.0], kind="most can be joined")
    return answers.comparison()


@check_join(
    reference="the body before it was cut: sums and Hooke's law by NumPy, volume and χ by trimesh",
    engines=("trimesh", "igl"),
    kind="invariant",
    unit="of the largest of the three, or 1",
    tolerance=1e-13,
    because="rounding of two changes, of sums over some thousand particles: 3.8e-15 at worst of three seeds",
    faults=(
        Fault(
            "stiffness of one",
            joining._springs,
            "np.bincount(at[there], weight, len(edges)) → np.bincount(at[there], weight, len(edges)) - 0.5 * weight[0]",
        ),
        Fault(
            "caps that stay",
            union.glued,
            "np.delete(triangles, gone.ravel(), axis=0) → np.delete(triangles, gone.ravel()[:-2], axis=0)",
        ),
        Fault("masses that are gone", joining._particles, "before.mass.sum() / mass.sum() → 1.0"),
        Fault("momenta of what is left", joining._particles, "with_momenta(before, after) → after.velocity"),
        Fault("mass by area alone", sharing.with_centre, "np.abs(left).max() <= m_ → True"),
        Fault(
            "volumes of one at rest",
            joining._together,
            "both.model['soft_mesh_volume'] + b_.model['soft_mesh_volume'] → both.model['soft_mesh_volume']",
        ),
    ),
)
def halves_are_whole_again(run: Run) -> Comparison:
    """The halves of a cut body are joined to what it was.

    Running bodies of every kind of mesh, with unequal springs and forces, cut anywhere: mass and its centre, momenta,
    energies, gas, pressure, volume and χ, and how springs pull at each place where a particle was.
    """
    from references import trimesh

    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(12, 48, 400)):
        body = running(rng, random_mesh(MESH_KINDS[case % len(MESH_KINDS)], rng), 0.02)
        body.set_springs(body.stiffness * rng.uniform(0.5, 2.0, len(body.edges)))
        body.external_force = rng.normal(size=body.positions.shape)
        if not is_whole(body):
            continue
        world, points, before = body.world, body.positions.copy(), whole((body,))
        pull, _ = pulls_at((body,), points)
        scale = float(body.stiffness.mean() * body.rest_length.mean())
        shape = trimesh.volume(points, body.triangles), body.pressure, trimesh.topology(points, body.triangles)[2]
        energy = world.energies()
        try:
            first, *others = body.cut(*anywhere(rng, points))
            for other in others:
                world.join(first, other, within=1e-9)
        except ParameterError as error:
            answers.add([0.0] * 3, [1.0] * 3, kind=str(error))
            continue
        for what, row in before.rows().items():
            answers.add(whole((body,)).rows()[what], row, float(np.abs(row).max(initial=1.0)), what)
        euler = trimesh.topology(body.positions, body.triangles)[2]
        answers.add([body.volume, body.pressure / shape[1], euler], [shape[0], 1.0, shape[2]], kind="shape")
        now = world.energies()
        told = [now.spring + now.gas, now.external, len(world.soft_bodies)]
        answers.add(told, [energy.spring + energy.gas, energy.external, 1.0], energy.spring + 10.0, "energies")
        here, new = pulls_at((body,), points)
        answers.extend(here, pull, scale, "springs")
        answers.extend(new, np.zeros(new.shape), scale, "springs, new")
    return answers.comparison()


@check_join(
    piece="softbody.SoftBody.cut, softbody.World.join, softbody.World.equilibrium",
    reference="the least energy of its springs and gas, found by SciPy, of what is expected of springs",
    engines=("scipy",),
    unit="m, and m³, of bodies of 1 m",
    tolerance=1e-10,
    because="what is left of a force, on both sides: 3.3e-12 at worst of three seeds",
    faults=(
        Fault(
            "gas of one",
            joining._together,
            "both.controls['soft_gas'] + b_.controls['soft_gas'] → both.controls['soft_gas']",
        ),
        Fault("gas by half", cutting._rows_of_pieces, "piece.room / room → 1.0 / len(pieces)"),
        Fault(
            "a tube that is drawn",
            joining._springs,
            "np.where(is_new, length, a_) → np.where(is_new, 0.9 * length, a_)",
        ),
    ),
)
def finds_its_rest(run: Run) -> Comparison:
    """Bodies that are cut or joined rest where energy is least.

    By World.equilibrium: the lengths of their springs, and the volume. Gas, and lengths and stiffness of springs along
    the tube, are by the claim.
    """
    from references import scipy, trimesh

    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(6, 16, 100)):
        world, gas = World(WEIGHTLESS), rng.uniform(2.0, 6.0, 2)
        a = world.add_soft_body(softbody.icosphere(1, 0.5), 1.0, 100.0, gas[0])
        try:
            if case % 2:
                b = world.add_soft_body(softbody.box((0.8, 0.8, 0.8), 2), 2.0, 100.0, gas[1], (1.0, 0.0, 0.0))
                body, nrt = world.join(a, b, (0.55, 0.02, 0.01)), float(gas.sum())
            else:
                normal, points, triangles = rng.normal(size=3), a.positions.copy(), a.triangles.copy()
                (body, *_), full = a.cut((0.05, 0.02, 0.1), normal), trimesh.volume(points, triangles)
                nrt = float(gas[0]) * trimesh.volume(body.positions, body.triangles) / full
            for each in world.soft_bodies:
                if each != body:
                    each.positions = each.positions + (0.0, 0.0, 9.0)
            edges, faces, start = body.edges.copy(), body.triangles.copy(), body.positions.copy()
            rest, stiffness = edge_lengths(start, edges), body.stiffness.copy()
            if case % 2:
                stiffness = np.full(len(edges), 100.0)
            judged = scipy.equilibrium(start, edges, rest, stiffness, faces, nrt)
            world.equilibrium(1e-13)
        except (ParameterError, SimulationError) as error:  # of a damaged core
            answers.add(0.0, 1.0, kind=str(error))
            continue
        kind = "joined" if case % 2 else "cut"
        expected = edge_lengths(judged.positions, edges)
        answers.extend(edge_lengths(body.positions, edges), expected, 1.0, kind)
        answers.add(body.volume, trimesh.volume(judged.positions, faces), 1.0, f"{kind}, volume")
    return answers.comparison()


@check_join(
    reference="the documentation; what the claim has asked for",
    kind="specification",
    faults=(
        Fault("one body twice", joining._check_two, "a_.row() == b_.row() → False"),
        Fault("bodies of other worlds", joining._check_two, "body.store is not store → False"),
        Fault("liquids that mix", joining._check_two, "one != other → False"),
        Fault("a tube of any length", joining._zipped, "longest > LONGEST * edge → False"),
        Fault("a tube through skins", joining._zipped, "through.any() → False"),
        Fault("neither place nor distance", joining.join_bodies, "(where is None) == (within is None) → False"),
        Fault("what hangs is forgotten", soft_rows.check_may_change, "hangs.any() → False"),
    ),
)
def refused_by_name(run: Run) -> Comparison:
    """Bodies that cannot be joined are refused, and stay.

    Too far apart, or through each other, of different liquids, the same, gone, of another world or something else, no
    place or two kinds of it, numbers that are none, what hangs: the error names the argument or body.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 4, 40)):
        place = np.array([1.05, 0.0, 0.0]) + rng.uniform(-0.01, 0.01, 3)
        wrong: list[tuple[str, str, dict[str, Any]]] = [
            ("too far", "bring them nearer", {"b": "far", "where": (2.5, 0.0, 0.0)}),
            ("through skins", "goes through their skins", {"where": (-1.0, 0.0, 0.0), "b": "inner"}),
            ("liquids", "liquid_density", {"b": "wet"}),
            ("the same", "a and b are both", {"b": "a"}),
            ("another world's", "b is <soft body", {"b": "stranger"}),
            ("gone", "was removed from its world", {"b": "gone"}),
            ("a box", "b is <box 0 'box'", {"b": "box"}),
            ("none", "b is None", {"b": "nobody"}),
            ("words", "a is 'a'", {"a": "words"}),
            ("no place", "give a place", {"where": None}),
            ("two kinds of place", "give a place", {"within": 0.1}),
            ("not finite", "where", {"where": (np.nan, 0.0, 0.0)}),
            ("of two", "where", {"where": (0.0, 1.0)}),
            ("within nothing", "within", {"where": None, "within": 0.0}),
            ("within no number", "within", {"where": None, "within": np.nan}),
            ("within too little", "no two triangles", {"where": None, "within": 1e-6}),
            ("hangs", "suspension 0 'eye'", {"hangs": True}),
        ]
        for kind, words, given in wrong:
            world, foreign = World(), World()

            def ball(name: str, place: tuple[float, ...], where: World = world, **options: Any) -> SoftBody:
                return where.add_soft_body(softbody.icosphere(2), 1.0, 100.0, 1.0, place, name=name, **options)

            things: dict[str, Any] = {
                "a": ball("a", (0.0, 0.0, 0.0)),
                "b": ball("b", (2.1, 0.0, 0.0)),
                "far": ball("far", (5.0, 0.0, 0.0)),
                "wet": ball("wet", (0.0, 2.1, 0.0), liquid_density=10.0),
                "inner": ball("inner", (0.3, 0.3, 0.0)),
                "gone": ball("gone", (0.0, 0.0, 9.0)),
                "stranger": ball("stranger", (2.1, 0.0, 0.0), foreign),
                "box": world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 5.0), name="box"),
                "nobody": None,
                "words": "a",
            }
            world.remove(things["gone"])
            if given.pop("hangs", False):
                world.suspend([(0.1, 0.0, 0.0)], things["a"], name="eye")
            one, other = things[given.pop("a", "a")], things[given.pop("b", "b")]
            before, arguments = world.snapshot(), {"where": place, **given}
            error = refusal(world.join, one, other, **arguments)
            after = world.snapshot()
            kept = set(before) == set(after) and all(
                np.asarray(before[name]).tobytes() == np.asarray(after[name]).tobytes() for name in before
            )
            answers.add(
                [words in error, kept, len(world.soft_bodies) == 5],
                [True] * 3,
                kind=kind,
            )
    return answers.comparison()
