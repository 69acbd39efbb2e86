"""Any soft body, step by step by each scheme, beside the same schemes written in NumPy."""

from __future__ import annotations

import numpy as np

from references import stability as documented
from softbody import Mesh, World, icosphere, octahedron, tetrahedron
from softbody.dynamics import integrators, one_ring_forces, stability, vertex_rings
from softbody.dynamics.vertex_rings import build_rings
from softbody.model.settings import INTEGRATORS
from softbody.stepping.runner import Runner
from validation.answers import Answers
from validation.cases import MESH_KINDS, edge_lengths, random_mesh, rotated
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "integrators"
STEPS = 25
PINCHED, ALIKE = "solids, corner to corner", "solids, corner to corner, of like springs"


def _mesh(kind: str, rng: np.random.Generator) -> Mesh:
    """Return a mesh of one of MESH_KINDS, or a tetrahedron with another one and an octahedron on two of its corners.

    In these corners two fans of triangles meet, of six and of seven neighbours.
    """
    if kind not in (PINCHED, ALIKE):
        return random_mesh(kind, rng)
    first = tetrahedron(1.0)
    points, faces = first.vertices - first.vertices.mean(axis=0), first.triangles
    for corner, solid in enumerate((tetrahedron(rng.uniform(0.5, 1.5)), octahedron(rng.uniform(0.5, 1.5)))):
        arms = solid.vertices - solid.vertices[0]
        inwards, outwards = (way / np.linalg.norm(way) for way in (arms.mean(axis=0), points[corner]))
        across = inwards - outwards
        arms = arms - 2.0 * np.outer(arms @ across, across) / (across @ across)  # its mirror image, turned outwards
        number = np.append(corner, len(points) + np.arange(len(arms) - 1))
        points = np.concatenate([points, points[corner] + arms[1:]])
        faces = np.concatenate([faces, number[solid.triangles][:, ::-1]])
    return rotated(Mesh(points * rng.uniform(0.7, 1.4, 3), faces), rng)


@check(
    section="5.1",
    piece="softbody.stepping.step.run_alone",
    reference="the three schemes as their sources write them, in NumPy, on forces as the gradient of the energy",
    engines=("scipy",),
    unit="of the size and the way, and of the fastest velocity",
    tolerance=1e-13,
    because="25 steps of rounding of forces that cancel: 3.4e-14 at worst of ten seeds",
    faults=(
        Fault(
            "a weight in the paper's scheme off by 1e-7",
            integrators.rk4_velocity_stage,
            "load_lanes(sums_, i_) + (a_ + a_) → load_lanes(sums_, i_) + 2.0000001 * a_",
        ),
        Fault(
            "drag 0.1 % too strong",
            one_ring_forces.add_load,
            "load_.drag / inverse_mass_[i_] → 1.001 * load_.drag / inverse_mass_[i_]",
        ),
        Fault(
            "damping halved", one_ring_forces._tension, "springs.damping * parting → 0.5 * springs.damping * parting"
        ),
        Fault(
            "damping and drag by the velocities at the start of the step",
            integrators._advance_body,
            "(start, start[3:]) if stage == 0 else (end, velocity) → (start if stage == 0 else end, start[3:])",
        ),
        Fault("gravity along the next axis", integrators.acceleration, "rows_.gravity[c_] → rows_.gravity[c_ - 1]"),
        Fault(
            "springs that are all like the last one, if all but one are",
            vertex_rings.with_springs,
            "(stiffness[a:b] == stiffness[a]).all() → (stiffness[a + 1 : b] == stiffness[b - 1]).all()",
        ),
        Fault("a vertex of two fans taken for one of one", build_rings, "-1 if cycle else behind → -1"),
        Fault("neighbours of another vertex of two fans", build_rings, "behind += entry.size → "),
        Fault("gas that leaves out vertices of two fans", one_ring_forces.fan_sums, "turn = add(turn, t_) → "),
    ),
)
def schemes_of_any_body(run: Run) -> Comparison:
    """Any soft body moves by each scheme as by that in NumPy.

    After 25 steps it is where it is there, at its velocity; the paper's scheme is first. No two springs are alike, or
    all but one. Bodies are damped, dragged, pushed, pinned and full of gas.
    """
    from references import steppers

    rng, answers = run.fresh_rng(), Answers()
    for kind in (*MESH_KINDS, PINCHED, ALIKE) * run.count(1, 2, 12):
        mesh, mass = _mesh(kind, rng), 10.0 ** rng.uniform(-1.0, 1.0)
        count, lengths = len(mesh.vertices), edge_lengths(mesh.vertices, mesh.edges)
        stiffness, gravity = rng.uniform(20.0, 200.0, len(mesh.edges)), rng.normal(0.0, 5.0, 3)
        if kind in (ALIKE, "box"):
            stiffness[1:] = stiffness[-1]
        pins, force = rng.choice(count, 3, replace=False), rng.normal(size=(count, 3)) / count
        damping, drag = 0.2 * np.sqrt(50.0 * mass / count), rng.uniform(0.0, 3.0)
        gas, free = rng.uniform(1.0, 100.0), ~np.isin(np.arange(count), pins)
        what = mesh.edges, lengths, stiffness, mesh.triangles, gas, mass / count, gravity, force, damping, drag, free
        for scheme in INTEGRATORS:
            world = World(gravity=gravity, integrator=scheme)
            body = world.add_soft_body(mesh, mass, stiffness, gas, damping=damping, drag=drag, fixed=pins)
            body.external_force = force
            step = 0.3 * world.stable_time_step()
            velocity = 0.03 * lengths.min() / step * rng.normal(size=(count, 3))
            velocity[pins] = 0.0
            body.velocities[:] = velocity
            world.step(step, STEPS)
            x, v = steppers.motion(steppers.SoftBody(*what), mesh.vertices, velocity, step, STEPS, scheme)
            size, fastest = np.ptp(mesh.vertices, axis=0).max() + np.abs(x - mesh.vertices).max(), np.abs(v).max()
            answers.extend(body.positions / size, x / size, kind=f"{kind}, {scheme}")
            answers.extend(body.velocities / fastest, v / fastest, kind=f"{kind}, {scheme}")
    return answers.comparison()


LIMIT = {"symplectic_euler": 2.0, "rk4_velocity": 2.0, "rk4": 2.0 * np.sqrt(2.0)}  # ω h without damping


@check(
    section="5.1",
    piece="softbody.World.stable_time_step, softbody.dynamics.stability",
    reference="the bounds by their formulas, in NumPy",
    kind="specification",
    unit="of the step",
    least=4,
    tolerance=5e-15,
    because="rounding of sums of some hundred terms, most of which are positive: 3.7e-16 at worst of four seeds",
    faults=(
        Fault(
            "the gas softer by a thousandth",
            stability.highest_frequency,
            "rank_one_ / abs(volume_) → 0.999 * rank_one / abs(volume)",
        ),
        Fault(
            "damping of one end",
            stability.highest_damping,
            "springs = max(springs, both) → springs = max(springs, 0.5 * both)",
        ),
        Fault("the step of a part", Runner.stable_time_step, "store.settings.substeps * x_ → x_"),
        Fault("the first body alone", stability.shortest_stable_step, "range(model.soft_count) → range(1)"),
    ),
)
def stable_step_as_documented(run: Run) -> Comparison:
    """The stable step told is the shortest that documented bounds allow.

    Bounds of frequency and damping, for the body of several whose step is shortest: any meshes, stretched, no two
    springs alike, or none that pulls, pinned, damped or not.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(4, 12, 60)):
        for scheme, limit in LIMIT.items():
            parts = 1 + trial % 3
            world, steps = World(integrator=scheme, substeps=parts), []
            for kind in rng.choice(MESH_KINDS, 1 + trial % 3):
                mesh, mass = random_mesh(kind, rng), 10.0 ** rng.uniform(-1.0, 1.0)
                count, edges = len(mesh.vertices), mesh.edges
                stiffness, gas = 10.0 ** rng.uniform(0.0, 3.0, len(edges)), 10.0 ** rng.uniform(-1.0, 3.0)
                if trial % 4 == 2:  # what is damped only
                    stiffness, gas = 0.0 * stiffness, 0.0
                pins = rng.choice(count, trial % 4, replace=False)
                damping, drag = (0.0, 0.0) if trial % 2 else rng.uniform(0.0, [0.3, 5.0])
                body = world.add_soft_body(mesh, mass, stiffness, gas, damping=damping, drag=drag, fixed=pins)
                body.positions[:] *= rng.uniform(0.9, 1.2, 3)
                inverse = np.full(count, count / mass)
                inverse[pins] = 0.0
                what = body.positions, edges, stiffness, mesh.triangles, gas, inverse
                rate = documented.highest_damping(edges, damping, drag, inverse)
                steps.append(documented.longest_step(documented.highest_frequency(*what), rate, limit))
            truth = parts * min(steps)
            answers.add(world.stable_time_step(), truth, truth, scheme)
    return answers.comparison()


@check(
    section="6",
    piece="softbody.dynamics.vertex_rings.build_rings",
    reference="neighbours counted along the mesh's edges; where particles of a kind end, and every 256th, in NumPy",
    kind="specification",
    unit="particles, blocks",
    tolerance=0.0,
    because="whole numbers",
    faults=(
        Fault("blocks of one", build_rings, "np.arange(1, count) % BLOCK → np.arange(1, count) // BLOCK"),
        Fault("blocks of any length", build_rings, "x_ | (np.arange(1, count) % BLOCK == 0) → x_"),
        Fault("windows of half", build_rings, "np.arange(count) // WINDOW → np.arange(count) // (WINDOW // 2)"),
    ),
)
def blocks_of_particles(run: Run) -> Comparison:
    """Particles lie in blocks of as many neighbours each, every one once.

    Those of a block are one ring or not, 256 at most. Within each 2048 particles there are as few blocks as that
    allows, each but for twins of its last one.
    """
    rng, answers = run.fresh_rng(), Answers()
    cases = [(kind, _mesh(kind, rng)) for kind in (*MESH_KINDS, PINCHED) for _ in range(run.count(1, 3, 20))]
    cases += [("a large sphere", rotated(icosphere(sides), rng)) for sides in range(4, run.count(5, 6, 7))]
    for kind, mesh in cases:
        world, count = World(), len(mesh.vertices)
        world.add_soft_body(mesh, 1.0, 100.0, 1.0)
        blocks, particle = world.store.rings.block, world.store.rings.particle
        neighbours = np.bincount(mesh.edges.ravel(), minlength=count)
        order = np.concatenate([particle[first : first + number] for first, _, number, *_ in blocks])
        # A particle whose triangles are several fans is no ring: it has as many neighbours, and is told apart.
        fans = np.array([_fans(mesh.triangles, each) for each in range(count)]) if kind == PINCHED else np.ones(count)
        alike = np.stack([neighbours, fans > 1.0], axis=1)[order]
        starts = (np.diff(alike, axis=0) != 0).any(axis=1) | (np.arange(1, count) % 256 == 0)
        # Within a window those of a kind follow each other: no kind comes twice.
        windows = [alike[first : first + 2_048] for first in range(0, count, 2_048)]
        runs = [1 + int((np.diff(each, axis=0) != 0).any(axis=1).sum()) for each in windows]
        most = np.diff(np.concatenate([[0], np.flatnonzero(starts) + 1, [count]])).max()
        ours = [len(blocks), blocks[:, 2].max(), *np.bincount(order, minlength=count)[[0, -1]], sum(runs)]
        truth = [1 + int(starts.sum()), most, 1, 1, sum(len(np.unique(each, axis=0)) for each in windows)]
        answers.add(ours, truth, kind=kind)
    return answers.comparison()


def _fans(triangles: np.ndarray, particle: int) -> int:
    """Return how many fans of triangles meet in a particle."""
    here = triangles[(triangles == particle).any(axis=1)]
    left = [set(each.tolist()) - {particle} for each in here]
    fans = 0
    while left:
        fans, fan, size = fans + 1, set(left.pop()), 0
        while len(fan) != size:
            size = len(fan)
            fan |= {corner for each in left if each & fan for corner in each}
        left = [each for each in left if not each & fan]
    return fans
