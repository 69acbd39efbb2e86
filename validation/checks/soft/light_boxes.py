"""Claims that boxes far lighter than the soft bodies on them carry these, and tip where they must."""

from __future__ import annotations

import numpy as np

import softbody
from softbody import World
from softbody.collision.solver import sequential_impulses
from softbody.collision.solver.held_boxes import box_mobilities
from validation import accounts
from validation.answers import Answers
from validation.cases import rotated
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "soft bodies at rest"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

# Mass of a box, of the soft body's, and how many boxes are stacked at most.
RATIOS = ((1e-1, 3), (1e-2, 3), (1e-3, 3), (1e-6, 1))
SIZE = 1.0  # [m] of the soft bodies
GRAVITY = 9.81  # [m/s²]
GAS = 20.0  # [J] in a ball of 1 kg
STEP = 0.5  # of the stable time step


@check(
    section="4.2",
    piece="softbody.collision.solver.held_boxes",
    reference="statics: heights of boxes, and of the lowest particle; energy: an invariant, by SciPy's judge",
    engines=("scipy",),
    unit="of the size; of the weight × size",
    kind="closed form",
    tolerance=1.4e-3,
    because="what is pressed sinks by what the solver leaves: 4.7e-5 at worst of ten seeds, 3.6e-4 at standard",
    faults=(
        Fault(
            "a box that stands gives way as if it were free",
            box_mobilities,
            "_hold(contacts_, bodies_, box_, supports_, push_, mobility_) → False",
        ),
    ),
)
def light_boxes_carry(run: Run) -> Comparison:
    """Boxes far lighter than a soft body carry it.

    1 kg falls by up to 0.3 m on one to three stacked boxes of 100 g to 1 g each. It also falls on one of 1 mg. After
    3 s it is at rest there and nothing has sunk. At no time was there more energy.
    """
    rng, answers = run.fresh_rng(), Answers()
    for ratio, highest in RATIOS * run.count(1, 3, 12):
        count, drop = int(rng.integers(1, highest + 1)), rng.uniform(0.0, 0.3)
        world = World()
        world.add_ground()
        sizes = rng.uniform((0.8, 0.8, 0.1), (1.2, 1.2, 0.4), (count, 3))
        tops = np.cumsum(sizes[:, 2])
        for size, top in zip(sizes, tops, strict=True):
            world.add_box(size, ratio, (0.0, 0.0, top - 0.5 * size[2]))
        mesh = rotated(softbody.icosphere(2, 0.5), rng)
        ball = world.add_soft_body(mesh, 1.0, 300.0, GAS, (0.0, 0.0, tops[-1] + 0.55 + drop), drag=1.0)
        world.equilibrium()
        start, most = accounts.energy(world), 0.0
        while world.time < 3.0:
            world.run(0.05, STEP * world.stable_time_step())
            most = np.maximum(most, accounts.energy(world) - start)
        sunk = np.abs(world.state.box_position[:, 2] - (tops - 0.5 * sizes[:, 2])).max()
        off = sunk, ball.positions[:, 2].min() - tops[-1], most / (GRAVITY * SIZE)
        kinds = [f"{what}, 1 : {1.0 / ratio:.0f}" for what in ("boxes", "soft body", "energy")]
        answers.extend(off, np.zeros(3), SIZE, kinds)
    return answers.comparison()


PLANK, PEDESTAL = (1.2, 0.4, 0.1), (0.3, 0.4, 0.5)  # [m]


@check(
    section="4.2",
    piece="softbody.collision.solver.held_boxes",
    reference="statics: M g e against m g (x − e), with e the half width of the pedestal",
    kind="closed form",
    because="the cube is 5 cm and more from balance, and rocks by 1 cm; by 0.6 s what tips leans by 0.1 rad and more,"
    " else by 0.01 at most",
    faults=(
        Fault(
            "pushes that what a box stands on never feels",
            sequential_impulses.hold_pushed_boxes,
            "pass_down(contacts_, bodies_, push_, motion_) → ",
        ),
    ),
)
def planks_tip_as_they_must(run: Run) -> Comparison:
    """Planks on a pedestal tip where a cube's moment is larger.

    One or two planks. The soft cube is beside the pedestal, moments are about its edge, and the planks have a
    twentieth to 1.5 times the cube's mass. They do not tip if their own moment is the larger one.
    """
    rng, answers = run.fresh_rng(), Answers()
    cube = softbody.box((0.2, 0.2, 0.2), 3)
    for trial in range(run.count(6, 24, 100)):
        mass, tips, count = np.exp(rng.uniform(np.log(0.05), np.log(1.5))), bool(trial % 2), 1 + trial // 2 % 2
        balance = 0.5 * PEDESTAL[0] * (1.0 + mass)  # where the cube's moment is the planks'
        place = balance + (rng.uniform(0.05, 0.15) if tips else -rng.uniform(0.05, 0.15))
        world = World()
        world.add_box(PEDESTAL, None, (0.0, 0.0, 0.25))
        planks = [
            world.add_box(PLANK, mass / count, (0.0, 0.0, 0.55 + 0.1 * layer), friction=1.0) for layer in range(count)
        ]
        centre = (place * float(rng.choice([-1.0, 1.0])), 0.0, 0.62 + 0.1 * count)
        world.add_soft_body(cube, 1.0, 2000.0, 6.0, centre, friction=1.0)
        world.equilibrium()
        world.run(0.6, STEP * world.stable_time_step())
        lean = 2.0 * np.arcsin(min(1.0, float(np.linalg.norm(planks[0].orientation[1:]))))
        answers.add(lean > 0.03, tips, kind="must tip" if tips else "must not")
    return answers.comparison()
