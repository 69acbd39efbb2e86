"""The solver of boxes, piece by piece: sweeps, positions, trees, and boxes that are held, by plain linear algebra."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from softbody.collision.contact import Contacts, new_contacts
from softbody.collision.solver import batches, held_boxes, sequential_impulses, solver_row, support_trees, warm_start
from softbody.collision.solver.sequential_impulses import part_at_targets
from softbody.collision.solver.solver_row import NORMAL_IMPULSE, TARGET, prepare_contacts
from softbody.collision.solver.sweep_order import sweep_order
from softbody.geometry.box import box_inertia
from softbody.model.arrays import RigidBodies
from validation.answers import Answers
from validation.cases import random_orientations, rotation_matrix
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "contacts of many boxes"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

GROUND = -1  # as side b of a contact


class Crowd(NamedTuple):
    """Boxes, and places where they touch."""

    bodies: RigidBodies
    pair: np.ndarray  # (c, 2) the bodies that touch there; or a body, and GROUND
    point: np.ndarray  # (c, 3) [m]
    normal: np.ndarray  # (c, 3) unit, from b to a

    def contacts(self) -> Contacts:
        """Return these contacts as the core has them, of no depth, restitution, friction and impulse."""
        count = len(self.pair)
        contacts = new_contacts(count)
        contacts.number[:] = count
        contacts.box[:], contacts.point[:], contacts.normal[:] = self.pair, self.point, self.normal
        for rows in (contacts.depth, contacts.restitution, contacts.friction, contacts.impulse, contacts.row):
            rows[:] = 0.0
        return contacts

    def motion(self) -> np.ndarray:
        """Return (6 m,): v and ω of each box, one after the other."""
        return np.concatenate([self.bodies.velocity, self.bodies.angular_velocity], axis=1).ravel()

    def inverse_mass(self) -> np.ndarray:
        """Return M⁻¹ (6 m, 6 m)."""
        count = len(self.bodies.inverse_mass)
        inverse = np.zeros((6 * count, 6 * count))
        for i in range(count):
            turn, first = rotation_matrix(self.bodies.orientation[i]), 6 * i
            inverse[first : first + 3, first : first + 3] = self.bodies.inverse_mass[i] * np.eye(3)
            spin = turn @ np.diag(self.bodies.inverse_inertia[i]) @ turn.T
            inverse[first + 3 : first + 6, first + 3 : first + 6] = spin
        return inverse

    def jacobian(self, way: np.ndarray) -> np.ndarray:
        """Return (c, 6 m): how fast a goes from b at each contact, along a unit vector `way` (c, 3)."""
        rows = np.zeros((len(way), 6 * len(self.bodies.inverse_mass)))
        for k, pair in enumerate(self.pair):
            for body, sign in zip(pair, (1.0, -1.0)):
                if body != GROUND:
                    arm, first = self.point[k] - self.bodies.position[body], 6 * body
                    rows[k, first : first + 3] = sign * way[k]
                    rows[k, first + 3 : first + 6] = sign * np.cross(arm, way[k])
        return rows

    def ways(self) -> np.ndarray:
        """Return (3, c, 3): the normals and two unit vectors across; the first across the axis least along it, too."""
        axis = np.eye(3)[np.argmin(np.abs(self.normal), axis=1)]
        first = np.cross(self.normal, axis)
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        return np.stack([self.normal, first, np.cross(self.normal, first)])

    def rows(self) -> np.ndarray:
        """Return (c, 3, 6 m): how fast a goes from b at each contact, along the normal and both tangents."""
        return np.stack([self.jacobian(way) for way in self.ways()], axis=1)

    def along(self, impulse: np.ndarray) -> np.ndarray:
        """Return impulses (c, 3) as they are along the normals and both tangents."""
        return np.einsum("dkc,kc->kd", self.ways(), impulse)

    def neighbours(self, box: int) -> Iterator[tuple[int, int, float]]:
        """Yield the contacts of a box, with the other one there, and the side that the box is: 1 of a, −1 of b."""
        for k, (a, b) in enumerate(self.pair):
            if box in (a, b):
                yield k, int(b if a == box else a), 1.0 if a == box else -1.0


def boxes_at(rng: np.random.Generator, place: np.ndarray) -> RigidBodies:
    """Return boxes of 0.5 to 2 m and 0.2 to 5 kg at `place` (m, 3) [m], that turn and spin anyhow."""
    count = len(place)
    mass, size = np.exp(rng.uniform(np.log(0.2), np.log(5.0), count)), rng.uniform(0.5, 2.0, (count, 3))
    inertia = np.array([box_inertia(tuple(each), m) for each, m in zip(size, mass)])
    v, w = rng.normal(size=(2, count, 3))
    return RigidBodies(1.0 / mass, 1.0 / inertia, place, random_orientations(rng, count), v, w)


def crowd_of(rng: np.random.Generator, boxes: int) -> Crowd:
    """Return boxes in the air of which most touch each other, in one to four points each and along any normals."""
    bodies = boxes_at(rng, rng.uniform(-1.0, 1.0, (boxes, 3)))
    pairs = [(a, b) for a in range(boxes) for b in range(a) if b == a - 1 or rng.random() < 0.6]
    return _touching(rng, bodies, pairs, 4)


def couples_with_neighbours(rng: np.random.Generator) -> Crowd:
    """Return five to seven couples of boxes in the air, and one more box at each of theirs: first the couples touch.

    The others cannot be solved with these, and are too many to be solved all at once.
    """
    couples = int(rng.integers(5, 8))
    bodies = boxes_at(rng, rng.uniform(-1.0, 1.0, (4 * couples, 3)))
    pairs = [(2 * k + 1, 2 * k) for k in range(couples)] + [(2 * couples + k, k) for k in range(2 * couples)]
    return _touching(rng, bodies, pairs, 2)


def _touching(rng: np.random.Generator, bodies: RigidBodies, pairs: list[tuple[int, int]], most: int) -> Crowd:
    """Return boxes that touch in one to `most` points a pair, along any normal."""
    rows = []
    for a, b in pairs:
        middle, across = 0.5 * (bodies.position[a] + bodies.position[b]), rng.normal(size=3)
        for _ in range(rng.integers(1, most + 1)):
            rows.append(((a, b), middle + rng.uniform(-0.5, 0.5, 3), across / np.linalg.norm(across)))
    return Crowd(bodies, *(np.array(column) for column in zip(*rows)))


def swept(
    crowd: Crowd, target: np.ndarray, friction: np.ndarray, bounce: np.ndarray, warm: np.ndarray, iterations: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return v and ω (6 m,) after the sweeps, and the impulses (c, 3) along the normals and both tangents.

    One contact after the other, up and down by turns. After `iterations` sweeps the next that goes down is the last, if
    it corrects more than three quarters of what the one before did; in any case the one of four times as many.
    """
    inverse, motion, rows, count = crowd.inverse_mass(), crowd.motion(), crowd.rows(), len(crowd.pair)
    yielding = np.einsum("kdi,ij,kej->kde", rows, inverse, rows)
    mass, across = 1.0 / yielding[:, 0, 0], 1.0 / np.linalg.eigvalsh(yielding[:, 1:, 1:])[:, 1]
    impulse = crowd.along(warm)
    impulse[:, 0] = np.maximum(bounce, impulse[:, 0])
    impulse[(friction == 0.0) | (impulse[:, 0] <= 0.0), 1:] = 0.0
    impulse[:, 0] -= bounce
    motion = motion + inverse @ np.einsum("ki,k->i", rows[:, 0], bounce)
    impulse *= _part_to_start_from(crowd, rows, target, motion, impulse)[:, None]
    motion = motion + inverse @ np.einsum("kdi,kd->i", rows, impulse)
    impulse[:, 0] += bounce
    # Contacts of one pair follow each other, and pairs come as they are listed: none of them stands on anything.
    before = np.inf
    for sweep in range(1, 4 * iterations + 1):
        down, most = sweep % 2 == 0, 0.0
        for k in range(count)[:: -1 if down else 1]:
            old = impulse[k].copy()
            impulse[k, 0] = np.maximum(0.0, old[0] + mass[k] * (target[k] - rows[k, 0] @ motion))
            motion = motion + inverse @ rows[k, 0] * (impulse[k, 0] - old[0])
            slide = old[1:] - across[k] * (rows[k, 1:] @ motion)
            size = np.linalg.norm(slide)
            impulse[k, 1:] = slide * (np.minimum(1.0, friction[k] * impulse[k, 0] / size) if size > 0.0 else 1.0)
            motion = motion + inverse @ rows[k, 1:].T @ (impulse[k, 1:] - old[1:])
            change = np.abs(impulse[k] - old)
            most = np.maximum(most, np.maximum(change[0] / mass[k], (change[1] + change[2]) / across[k]))
        if down:
            if sweep >= iterations and most > 0.75 * before:
                break
            before = most
    return motion, impulse


def _part_to_start_from(
    crowd: Crowd, rows: np.ndarray, target: np.ndarray, before: np.ndarray, impulse: np.ndarray
) -> np.ndarray:
    """Return (c,): which part of its `impulse` (c, 3) each contact starts from, on top of the motion `before`.

    All of it, unless some that push part by that; then what is least, along the impulses of all contacts that hang
    together, of the quadratic form that is least where everything is solved.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    inverse = crowd.inverse_mass()
    wanted = np.pad(target[:, None], ((0, 0), (0, 2))) - rows @ before
    changed = rows @ inverse @ np.einsum("kdi,kd->i", rows, impulse)
    part = np.ones(len(rows))
    if np.all((changed - wanted)[impulse[:, 0] > 0.0, 0] <= 0.0):
        return part
    boxes, (a, b) = len(crowd.bodies.inverse_mass), crowd.pair.T
    _, island = connected_components(coo_array((np.ones(len(rows)), (a, b)), shape=(boxes, boxes)), directed=False)
    for one in np.unique(island[a]):
        among = island[a] == one
        square = np.sum((impulse * changed)[among])
        if square > 0.0:
            part[among] = np.clip(np.sum((impulse * wanted)[among]) / square, 0.0, 1.0)
    return part


@check(
    section="beyond the paper",
    piece="softbody.collision.solver.sequential_impulses.solve_velocities",
    reference="sequential impulses, one contact at a time, in NumPy, by matrices of masses",
    unit="of the speed, of the momentum at 1 kg",
    kind="closed form",
    tolerance=2e-13,
    because="rounding: 1.0e-14 at worst of ten seeds",
    faults=(
        Fault(
            "bodies that are in two batches at once", batches._schedule, "least[b_] = t_ + 1 → least[b] = max(t - 1, 0)"
        ),
        Fault("pairs that go before others, where there is room", batches._schedule, "t += 1 → t -= 1"),
        Fault("impulses to start from, as they were", warm_start._scale_start, "min(1.0, x_) if y_ else z_ → 1.0"),
        Fault("less than none of them", warm_start._scale_start, "max(0.0, x_) → x_"),
        Fault("bounces that are scaled, too", warm_start.start_from_cache, "row[a_, b_].copy() → np.zeros(number)"),
        Fault(
            "sweeps that all go up",
            sequential_impulses._sweep_all,
            "_sweep(b_, down_, m_) → _sweep(batches, False, motions)",
        ),
        Fault(
            "sweeps that go on once more",
            sequential_impulses._sweep_all,
            "left_ <= MORE * iterations_ + 1 → left <= MORE * iterations - 1",
        ),
        Fault(
            "sweeps that never go on, though they converge",
            sequential_impulses._sweep_all,
            "changed_ > FAST * before_ → True",
        ),
        Fault(
            "a sliding that is not that which the normal impulse leaves",
            solver_row.prepare_contacts,
            "_coupling(row_, k_, SECOND, NORMAL) → _coupling(row, k, TANGENT, NORMAL)",
        ),
    ),
)
def sweeps(run: Run) -> Comparison:
    """Sweeps correct contact after contact, up and down by turns.

    Three to six boxes strike each other, or dozens: with and without restitution, friction and impulses of the step
    before. After 1 to 12 sweeps over the contacts every box moves, and every contact pushes, as if one contact after
    the other had been corrected, from what bounces give and the impulses before or, if those throw boxes apart, the
    part of them that leaves least. Sweeps go on for as long as that converges fast.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(40, 250, 2_500)):
        crowd, iterations = crowd_of(rng, int(rng.integers(3, 7))), int(rng.integers(1, 13))
        if case % 20 == 7:
            crowd, iterations = couples_with_neighbours(rng), int(rng.integers(1, 4))
        count, contacts = len(crowd.pair), crowd.contacts()
        restitution = rng.random(count) * (case % 2)
        friction = rng.uniform(0.1, 1.0, count) * (case // 2 % 2)
        warm = rng.normal(size=(count, 3)) * (case // 4 % 2)
        contacts.restitution[:], contacts.friction[:], contacts.impulse[:] = restitution, friction, warm
        start = crowd.motion()
        closing = -crowd.jacobian(crowd.normal) @ start
        target = restitution * np.maximum(0.0, closing)
        bounce = np.maximum(0.0, rng.normal(size=count)) * (restitution > 0.0) * (case % 3 == 0)
        motion, impulse = swept(crowd, target, friction, bounce, warm, iterations)
        prepare_contacts(contacts, crowd.bodies)
        contacts.row[:count, TARGET], contacts.row[:count, NORMAL_IMPULSE] = target, bounce
        part_at_targets(contacts, crowd.bodies, iterations, 0.0)
        speed, kind = np.linalg.norm(start), "with friction" if friction.any() else "without friction"
        answers.extend(crowd.motion().reshape(-1, 6), motion.reshape(-1, 6), speed, kind)
        answers.extend(_of_six(crowd.along(contacts.impulse)), _of_six(impulse), speed, kind)
    return answers.comparison()


def _of_six(rows: ArrayLike) -> np.ndarray:
    """Return rows with zeros to their right, six in all."""
    return np.pad(rows, ((0, 0), (0, 6 - np.shape(rows)[1])))


@check(
    section="4.4",
    piece="softbody.collision.solver.sequential_impulses.solve_positions",
    reference="a quadratic programme: non-negative least squares, by SciPy",
    engines=("scipy",),
    unit="of the depth",
    tolerance=5e-11,
    because="what 20 000 sweeps leave: 2.0e-12 at worst of ten seeds, 2.8e-12 at standard",
    faults=(
        Fault(
            "impulses that are those of the step before",
            sequential_impulses.solve_positions,
            "row_[k_, POSITION_IMPULSE] = 0.0 → ",
        ),
        Fault(
            "depths that are just allowed undone",
            sequential_impulses.solve_positions,
            "contacts_.depth[k_] > slop_ → contacts_.depth[k_] >= slop_",
        ),
        Fault("a push that b does not feel", solver_row.apply_impulse, "s_ != 0.0 → s_ != 1.0"),
    ),
)
def positions(run: Run) -> Comparison:
    """Boxes inside each other part by the least displacement.

    It undoes a fifth of every depth beyond what is allowed, weighed with their masses and inertias. It does so whatever
    was asked before of the same rows.
    """
    from scipy.optimize import nnls

    rng, answers = run.fresh_rng(), Answers()
    crowds = [(_inside_by_ten_metres(rng), "two boxes of 1 kg")]
    crowds += [(crowd_of(rng, int(rng.integers(2, 5))), "random") for _ in range(run.count(15, 100, 1_000))]
    for crowd, kind in crowds:
        contacts, rows = crowd.contacts(), crowd.jacobian(crowd.normal)
        prepare_contacts(contacts, crowd.bodies)
        root = np.linalg.cholesky(crowd.inverse_mass())
        for trial in range(2):
            slop = 0.0 if kind != "random" or trial else 2.0**-30
            depth = rng.uniform(-0.2, 0.4, len(rows))
            depth[rng.random(len(rows)) < 0.2] = slop
            contacts.depth[:] = depth = np.full(1, 10.0) if kind != "random" else depth
            shift = sequential_impulses.solve_positions(contacts, crowd.bodies, slop, 20_000)
            # Of all displacements L y, with M⁻¹ = L Lᵀ, that part by what is wanted, that of the least |y| (Lawson and
            # Hanson 1974, §23.4: least distance programming).
            deep = depth > slop
            least = np.zeros(rows.shape[1])
            if deep.any():
                block, wanted = rows[deep] @ root, 0.2 * (depth[deep] - slop)
                aim = np.append(np.zeros(rows.shape[1]), 1.0)
                scale = np.linalg.norm(wanted)
                both = np.vstack([block.T, wanted / scale])
                rest = both @ nnls(both, aim, maxiter=10_000)[0] - aim
                least = root @ (-rest[:-1] / rest[-1]) * scale
            answers.extend(shift[:-1], least.reshape(-1, 6), kind=kind)
    return answers.comparison()


def _inside_by_ten_metres(rng: np.random.Generator) -> Crowd:
    """Return two boxes of 1 kg that touch on the line between their centres, so that each moves by whole metres."""
    bodies = boxes_at(rng, np.array([(0.0, 0.0, 0.0), (2.0, 0.0, 0.0)]))
    one = bodies._replace(inverse_mass=np.ones(2), orientation=np.tile((1.0, 0.0, 0.0, 0.0), (2, 1)))
    return Crowd(one, np.array([(1, 0)]), np.array([(1.0, 0.0, 0.0)]), np.array([(1.0, 0.0, 0.0)]))


def stack_of(rng: np.random.Generator, boxes: int, most: int, sides: bool) -> Crowd:
    """Return boxes that stand on one another, each on what was there before it or on the ground, or on both.

    Each pair touches in one to `most` places; `sides`: along all sorts of normals, and else from below.
    """
    bodies, rows = boxes_at(rng, rng.uniform(-0.5, 0.5, (boxes, 3))), []
    bodies.position[:, 2] += np.arange(boxes)
    for i in range(boxes):
        below = {int(rng.integers(GROUND, i)) if i else GROUND}
        if rng.random() < 0.7:
            below.add(int(rng.integers(GROUND, i)) if i else GROUND)
        for other in sorted(below):
            place = bodies.position[i] - (0.0, 0.0, 0.5)
            for _ in range(rng.integers(1, most + 1)):
                up = rng.normal(size=3) if sides else rng.normal(0.0, 0.2, 3) + (0.0, 0.0, 1.0)
                rows.append(((i, other), place + rng.uniform(-0.5, 0.5, 3), up / np.linalg.norm(up)))
    return Crowd(bodies, *(np.array(column) for column in zip(*rows)))


def _renumbered(crowd: Crowd, rng: np.random.Generator) -> Crowd:
    """Return the same boxes in any order; of two that touch, the one of the higher number is side a."""
    order = rng.permutation(len(crowd.bodies.inverse_mass))
    number = np.append(np.argsort(order), GROUND)  # the last one is the ground's
    pair = number[crowd.pair]
    turned = pair[:, 0] < pair[:, 1]
    pair[turned] = pair[turned, ::-1]
    bodies = RigidBodies(*(rows[order] for rows in crowd.bodies))
    return Crowd(bodies, pair, crowd.point, np.where(turned[:, None], -crowd.normal, crowd.normal))


def levels_of(crowd: Crowd) -> np.ndarray:
    """Return how many contacts are between each box and the ground, which it stands on in the end: (m + 1,), 0 last."""
    level = np.append(np.full(len(crowd.bodies.inverse_mass), len(crowd.pair)), 0)  # the last one is the ground's
    for _ in crowd.pair:
        for a, b in crowd.pair:
            level[a] = np.minimum(level[a], 1 + level[b])
            level[b] = np.minimum(level[b], 1 + level[a])
    return level


def _supports_of(crowd: Crowd, level: np.ndarray, box: int, closed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the contacts by which a box stands, and by how much (s, 6) a motion of the box opens each."""
    stands = [k for k, other, _ in crowd.neighbours(box) if level[other] < level[box] and closed[k]]
    return np.array(stands, int), crowd.jacobian(crowd.normal)[stands, 6 * box : 6 * box + 6]


def _held(root: np.ndarray, push: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what is left (6,) of the motion that a push makes of one box, and the impulses of its supports."""
    from scipy.optimize import nnls

    if not len(rows):
        return root @ root.T @ push, np.zeros(0)
    impulse, _ = nnls((rows @ root).T, -root.T @ push)
    return root @ root.T @ (push + rows.T @ impulse), impulse


def _rate(rows: np.ndarray, inverse: np.ndarray) -> float:
    """Return by which factor a sweep over contacts that all hold lessens what is amiss, in the end."""
    mass = rows @ inverse @ rows.T
    return float(np.abs(np.linalg.eigvals(np.linalg.solve(np.tril(mass), np.triu(mass, 1)))).max(initial=0.0))


@check(
    section="beyond the paper",
    piece="softbody.collision.solver.held_boxes",
    reference="for each box a quadratic programme: non-negative least squares, by SciPy",
    engines=("scipy",),
    unit="of the mobility, of the push, of the motion, of the impulse",
    tolerance=1e-9,
    because="what the sweeps over one box's supports leave, which end at 1e-12: 6.2e-11 at worst of ten seeds",
    faults=(
        Fault("supports that a push opens, and hold", held_boxes._hold, "supports_.impulse[p_] > 0.0 → True"),
        Fault("supports that hold each as if alone", held_boxes._fix, "x_ * y_ / left_ → motion[r] * motion[c] / free"),
        Fault(
            "moments that move a box and are held besides",
            held_boxes.keep_what_is_held,
            "push_[b_, 3 + c_] -= m_[c_] → ",
        ),
        Fault(
            "pushes passed down at every level",
            held_boxes.pass_down,
            "supports_.level[b_] != height_ or not x_ → supports.level[box] != height and not push[box].any()",
        ),
        Fault(
            "gaps that stay open and hold",
            held_boxes._list_supports,
            "not stays_open_ → (stays_open or not stays_open)",
        ),
        Fault(
            "pushes that never reach a box below of a higher number",
            held_boxes.pass_down,
            "contacts.box[k, 1] if contacts.box[k, 0] == box else contacts.box[k, 0] → contacts.box[k, 1]",
        ),
    ),
)
def held(run: Run) -> Comparison:
    """Boxes that stand move as their supports leave them.

    These hold what a push presses on them, and nothing else. What holds boxes is pushed itself, from support to
    support, down to the ground.
    """
    rng, answers, tried = run.fresh_rng(), Answers(), 0
    while tried < run.count(40, 200, 2_000):
        crowd = _renumbered(stack_of(rng, int(rng.integers(1, 5)), 3, bool(rng.random() < 0.5)), rng)
        count, contacts, level = len(crowd.bodies.inverse_mass), crowd.contacts(), levels_of(crowd)
        speed, before = np.minimum(0.0, rng.normal(size=(2, len(crowd.pair))))
        contacts.row[:, TARGET] = speed * (rng.random(len(speed)) < 0.5)
        contacts.row[:, NORMAL_IMPULSE] = before = -before
        closed = ~((contacts.row[:, TARGET] < 0.0) & (before == 0.0))
        blocks = [crowd.inverse_mass()[6 * i : 6 * i + 6, 6 * i : 6 * i + 6] for i in range(count)]
        stand = [_supports_of(crowd, level, i, closed) for i in range(count)]
        if np.max([_rate(rows, block) for (_, rows), block in zip(stand, blocks)]) > 0.8:
            continue  # two hundred sweeps would not be enough
        tried += 1
        push = rng.normal(size=(count, 6)) * (rng.random((count, 1)) < 0.7)
        roots = [np.linalg.cholesky(block) for block in blocks]
        mobilities, kept = np.array(blocks), np.zeros((count, 6))
        motion, impulse, given = np.zeros((count, 6)), before.copy(), push.copy()
        for i in np.argsort(-level[:-1], kind="stable"):
            supports, rows = stand[i]
            if push[i].any():
                speed, alone = rows @ _held(roots[i], push[i], rows)[0], rows @ blocks[i] @ push[i]
                holds = rows[speed <= 1e-9 * np.abs(alone).max(initial=0.0)]
                holding = holds.T @ np.linalg.pinv(holds @ blocks[i] @ holds.T) @ holds
                mobilities[i], kept[i] = blocks[i] - blocks[i] @ holding @ blocks[i], holding @ blocks[i] @ push[i]
            if given[i].any():
                motion[i], added = _held(roots[i], given[i], rows)
                impulse[supports] += added
                pushed = dict(zip(supports, added))
                for k, other, side in crowd.neighbours(i):
                    if k in pushed and other != GROUND:
                        way, arm = -pushed[k] * side * crowd.normal[k], crowd.point[k] - crowd.bodies.position[other]
                        given[other] += np.concatenate([way, np.cross(arm, way)])
        mobility, stands = held_boxes.box_mobilities(contacts, crowd.bodies, push)
        moved, held = np.zeros((count + 1, 6)), push.copy()
        held_boxes.keep_what_is_held(crowd.bodies, mobility, stands, held)
        held_boxes.pass_down(contacts, crowd.bodies, push, moved)
        answers.extend(mobility.ravel(), mobilities.ravel(), kind="mobility")
        answers.extend(held.ravel(), kept.ravel(), kind="held")
        answers.extend(moved[:-1].ravel(), motion.ravel(), kind="motion")
        answers.extend(contacts.row[:, NORMAL_IMPULSE], impulse, kind="impulse")
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.collision.solver.support_trees",
    reference="sums of impulses; the whole system (M + Jᵀ D J) dv = Jᵀ D r, by NumPy's dense solver",
    kind="closed form",
    unit="of the speed; 1 for a wrong tree",
    tolerance=2e-8,
    because="rounding, times a million, by which contacts are stiffer than bodies: 6.8e-10 at worst of ten seeds",
    faults=(
        Fault("a box that hangs on the first thing below it", support_trees.plant, "_push(contacts_, x_, y_) → 0.0"),
        Fault("sliding instead of pushes", support_trees._push, "NORMAL_IMPULSE → NORMAL_IMPULSE + 1"),
        Fault("inertia off by a hundredth", support_trees._put_mass, "1.0 / inverse_[2] → 1.01 / inverse[2]"),
        Fault(
            "torques on what carries left out",
            support_trees._add_moved,
            "add((pull_[3], pull_[4], pull_[5]), cross(arm_, x_)) → (pull_[3], pull_[4], pull_[5])",
        ),
    ),
)
def trees(run: Run) -> Comparison:
    """A box hangs on the support that pushed it most.

    Of several things that it stands on, that is the one that pushed most in the last step; and it hangs on what that
    hangs. The equations of such trees, of contacts that hold, slide or are open, are solved.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(40, 200, 2_000)):
        crowd = stack_of(rng, int(rng.integers(1, 6)), 3, bool(rng.random() < 0.5))
        count, contacts, level = len(crowd.bodies.inverse_mass), crowd.contacts(), levels_of(crowd)
        prepare_contacts(contacts, crowd.bodies)
        push = rng.random((len(crowd.pair), 3))
        contacts.row[:, NORMAL_IMPULSE : NORMAL_IMPULSE + 3] = push
        contacts.row[:, TARGET] = target = rng.normal(size=len(push))
        forest = support_trees.plant(contacts, crowd.bodies, sweep_order(contacts, crowd.bodies))
        # The pair by which each box stands, of those to boxes that are nearer to the ground.
        stands = []
        for i in range(count):
            total: dict[int, float] = {}
            for k, other, _ in crowd.neighbours(i):
                if level[other] < level[i]:
                    total[other] = total.get(other, 0.0) + push[k, 0]
            stands.append(max(total, key=total.__getitem__))
        found = {int(i): int(b) for i, b in zip(forest.standing, forest.carrier) if i >= 0}
        carriers = [[found.get(i, -2)] for i in range(count)]
        answers.extend(_of_six(carriers), _of_six([[each] for each in stands]), kind="what a box hangs on")
        # Contacts of these pairs hold, slide or are open; all others are left out.
        does = rng.choice([support_trees.OPEN, support_trees.SLIDES, support_trees.HOLDS], len(push))
        motion = np.concatenate([crowd.motion().reshape(-1, 6), np.zeros((1, 6))])
        whole, unsolved = np.zeros((2, count + 1), np.int64), np.ones(count + 1, bool)
        trial = support_trees.Trial(does, push.copy(), motion, unsolved, *whole)
        shape = (count, 6, 6)
        equations = support_trees.Equations(*np.full((2, *shape), np.nan), *np.full((2, *shape[:2]), np.nan))
        support_trees.assemble(contacts, crowd.bodies, forest, trial, equations)
        support_trees.eliminate(crowd.bodies, forest, trial, equations)
        rows, inverse, start = crowd.rows(), crowd.inverse_mass(), crowd.motion()
        system, right = np.linalg.inv(inverse), np.zeros(6 * count)
        for k, pair in enumerate(crowd.pair):
            upper, lower = pair if level[pair[0]] > level[pair[1]] else pair[::-1]
            yielding = rows[k] @ inverse @ rows[k].T
            mass = 1.0 / np.array([yielding[0, 0], *[np.linalg.eigvalsh(yielding[1:, 1:])[1]] * 2])
            for d in range(does[k] if stands[upper] == lower else 0):
                lack = (target[k] if d == 0 else 0.0) - rows[k, d] @ start
                system += 1e6 * mass[d] * np.outer(rows[k, d], rows[k, d])
                right += 1e6 * mass[d] * lack * rows[k, d]
        change = np.linalg.solve(system, right)
        scale = np.maximum(1.0, np.abs(change).max())
        answers.extend(equations.unknown, change.reshape(-1, 6), scale, "change of motion")
    return answers.comparison()


@check(
    section="4.4",
    piece="softbody.collision.solver.warm_start.warm_start",
    reference="the same rule, contact by contact, in NumPy",
    kind="specification",
    unit="N s",
    tolerance=1e-14,
    because="sums of some impulses of about 1 N s",
    faults=(
        Fault("squares beside a square metre", warm_start.warm_start, "distance = 0.0 → distance = 1.0"),
        Fault("the farthest", warm_start.warm_start, "distance < nearest → distance > nearest or matched < 0"),
        Fault("two axes", warm_start.warm_start, "range(3) → range(2)"),
        Fault(
            "features that are not looked at",
            warm_start.warm_start,
            "contacts.feature[k] == cache.feature[old] → False",
        ),
    ),
)
def impulses_of_a_step_ago(run: Run) -> Comparison:
    """Each contact of boxes starts from its impulse a step ago.

    It is known by its two boxes and its feature. Where a feature is gone its impulse goes to the nearest contact of
    that pair, between a nanometre and a thousand kilometres away; where the pair is gone, to none.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(40, 200, 2_000)):
        scale = 10.0 ** (-9.0, -7.0, -3.0, 0.0, 3.0, 6.0)[trial % 6]
        old_pairs, old_features, old_points = _listed(rng, scale)
        pairs_now, features, points = _listed(rng, scale)
        contacts, impulses = new_contacts(16), rng.normal(size=(len(old_pairs), 3))
        cache = contacts.cache
        contacts.number[:], cache.number[0] = len(pairs_now), len(old_pairs)
        kept = cache.box, cache.feature, cache.point, cache.impulse
        for to, what in zip(kept, (old_pairs, old_features, old_points, impulses)):
            to[: len(what)] = what
        for to, what in zip((contacts.box, contacts.feature, contacts.point), (pairs_now, features, points)):
            to[: len(what)] = what
        warm_start.warm_start(contacts)
        truth = np.zeros((len(pairs_now), 3))
        for pair, feature, point, impulse in zip(old_pairs, old_features, old_points, impulses):
            there = np.flatnonzero((pairs_now == pair).all(axis=1))
            same = there[features[there] == feature]
            if len(there):
                nearest = np.linalg.norm(points[there] - point, axis=1).argmin()
                truth[same[0] if len(same) else there[nearest]] += impulse
        found, wanted = (np.pad(rows.ravel(), (0, 48 - truth.size)) for rows in (contacts.impulse[: len(truth)], truth))
        answers.add(found, wanted, kind=f"metres apart: {scale:g}")
    return answers.comparison()


def _listed(rng: np.random.Generator, scale: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return pairs (c, 2), features (c,) and points (c, 3) [m] of up to fifteen contacts, in order of pairs."""
    pairs = sorted(rng.permutation([(1, 0), (2, 0), (2, 1), (3, 0), (4, 2)])[: rng.integers(1, 5)].tolist())
    numbers = np.sort(rng.integers(0, len(pairs), int(rng.integers(1, 16))))
    features = np.zeros(len(numbers), np.int64)
    for pair in range(len(pairs)):
        features[numbers == pair] = rng.permutation(20)[: (numbers == pair).sum()]
    return np.array(pairs)[numbers], features, scale * rng.normal(size=(len(numbers), 3))


@check(
    section="beyond the paper",
    piece="softbody.collision.solver.held_boxes",
    reference="two hundred sweeps of projected Gauss–Seidel in NumPy, of which each leaves 0.9 to 0.999 of the last",
    kind="specification",
    unit="of the part",
    tolerance=1e-11,
    because="rounding of two hundred sweeps over contacts that are all but the same: 1e-13",
    faults=(
        Fault("a sweep more", held_boxes._held_motion, "SWEEPS if number else 0 → SWEEPS + 1 if number else 0"),
        Fault("half as many", held_boxes._held_motion, "SWEEPS if number else 0 → SWEEPS // 2 if number else 0"),
        Fault("supports that pull", held_boxes._held_motion, "max(0.0, x_) → x_ + 0.0"),
    ),
)
def two_hundred_sweeps(run: Run) -> Comparison:
    """An unfinished solve of supports counts as two hundred sweeps leave it.

    So it is where the supports of a box are close together: what is compared is the part of a motion that is left.
    """
    rng, answers = run.fresh_rng(), Answers()
    while len(answers) < run.count(30, 150, 1_500):
        bodies, number = boxes_at(rng, rng.normal(size=(1, 3))), int(rng.integers(3, 8))
        place = bodies.position[0] + rng.normal(0.0, 0.5, 3)
        points = place + 10.0 ** rng.uniform(-2.0, -0.5) * rng.normal(size=(number, 3))
        normals = rng.normal(0.0, 0.2, (number, 3)) + (0.0, 0.0, 1.0)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        crowd = Crowd(bodies, np.array([(0, GROUND)] * number), points, normals)
        inverse, rows = crowd.inverse_mass(), crowd.jacobian(crowd.normal)
        if not 0.9 < _rate(rows, inverse) < 0.999:
            continue
        push = rng.normal(size=6)
        motion, impulse = inverse @ push, np.zeros(number)
        for _ in range(200):
            for k, row in enumerate(rows):
                pushed = np.maximum(0.0, impulse[k] - row @ motion / (row @ inverse @ row))
                motion, impulse[k] = motion + (pushed - impulse[k]) * (inverse @ row), pushed
        part = push @ motion / (push @ inverse @ push)
        if not 1e-3 < part < 1.0:
            continue
        contacts = crowd.contacts()
        contacts.row[:, NORMAL_IMPULSE] = 1.0
        moved, given = np.zeros((2, 6)), push[None].copy()
        held_boxes.pass_down(contacts, bodies, given, moved)
        answers.add(push @ moved[0] / (push @ inverse @ push), part)
    return answers.comparison()
