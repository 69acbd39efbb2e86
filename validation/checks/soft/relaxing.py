"""Claims that a soft body glides to its shape at rest as the algorithm of its authors does."""

from __future__ import annotations

import numpy as np

from softbody import SimulationError, World
from softbody.dynamics import equilibrium
from softbody.dynamics.soft_bodies import motion_of
from softbody.dynamics.stability import highest_frequency
from softbody.model.arrays import soft_bodies_of
from softbody.stepping.shape_at_rest import shape_at_rest
from validation.answers import Answers
from validation.cases import MESH_KINDS, edge_lengths, random_mesh
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "pressure and volume"


@check(
    section="2.3",
    piece="softbody.dynamics.equilibrium.relax",
    reference="the algorithm of Bitzek et al. (2006), in NumPy, on forces as the gradient of the energy",
    kind="specification",
    engines=("scipy",),
    unit="of the size, of the fastest velocity, of the longest step",
    tolerance=1e-11,
    because="rounding of forces that cancel, which the motion amplifies: 4.8e-13 at worst of ten seeds",
    faults=(
        Fault("steps that are never too long", equilibrium.relax, "min(h * FASTER, longest) → h * FASTER"),
        Fault("one step less of patience", equilibrium.relax, "h * SLOWER, MIXING, 0 → h * SLOWER, MIXING, 1"),
        Fault("mixing that does not fade", equilibrium.relax, "mixing * MIXING_FADES → mixing"),
    ),
)
def as_fire_has_it(run: Run) -> Comparison:
    """A stretched, pinned, gas-filled soft body relaxes as FIRE has it.

    With the parameters of its authors. After 20 and 60 steps it is where NumPy's is, at its velocity, and so long is
    its next step.
    """
    from references import fire

    rng, answers = run.fresh_rng(), Answers()
    for kind in MESH_KINDS * run.count(1, 3, 20):
        mesh, mass = random_mesh(kind, rng), 10.0 ** rng.uniform(-1.0, 1.0)
        count, lengths = len(mesh.vertices), edge_lengths(mesh.vertices, mesh.edges)
        stiffness, gas = rng.uniform(50.0, 150.0, len(mesh.edges)), rng.uniform(0.1, 10.0)
        pins = rng.choice(count, 3, replace=False)
        world = World(gravity=rng.normal(0.0, 5.0, 3))
        world.add_soft_body(mesh, mass, stiffness, gas, damping=0.0, fixed=pins)
        model, controls, state, rings, _ = world.store.parts
        start = mesh.vertices * rng.uniform(0.8, 1.2, 3)
        size, longest = np.ptp(start, axis=0).max(), 1.0 / highest_frequency(model, controls, start, 0)
        free = ~np.isin(np.arange(count), pins)
        what = mesh.edges, lengths, stiffness, mesh.triangles, gas, mass / count, world.gravity, free
        for steps in (20, 60):
            state.particle_position[:] = start
            state.particle_velocity[:] = 0.0
            glide = equilibrium.glide_from_rest(state.particle_position, longest)
            motion = motion_of(model.soft_particle_start, rings)
            equilibrium.relax(model, soft_bodies_of(model, controls, state), motion, longest, steps, glide)
            x, v, step_size = fire.relaxed(start, longest, steps, *what)
            fastest, label = np.abs(v).max(), f"{steps} steps"
            answers.extend(state.particle_position / size, x / size, kind=label)
            answers.extend(glide.velocity / fastest, v / fastest, kind=label)
            answers.add([glide.step_size[0] / longest] * 3, [step_size / longest] * 3, kind=label)
    return answers.comparison()


@check(
    section="2.3",
    piece="softbody.World.equilibrium",
    reference="FIRE (Bitzek et al. 2006) in NumPy, from rest every 500 steps, of one over the bound of Anderson and"
    " Morley (1985); the largest acceleration times the least mass, over stiffness and size",
    kind="specification",
    engines=("scipy",),
    unit="relative",
    tolerance=6e-3,
    because="three digits are told: 5e-3 at worst",
    faults=(
        Fault("a step more in a round", shape_at_rest, "min(steps - done, ROUND) → min(steps - done, ROUND + 1)"),
        Fault("rounds to the end", shape_at_rest, "min(steps - done, ROUND) → min(steps, ROUND)"),
        Fault("the softest spring", shape_at_rest, "model.edge_stiffness.max() → model.edge_stiffness.min()"),
        Fault("the shortest side", shape_at_rest, "np.ptp(position, axis=0).max() → np.ptp(position, axis=0).min()"),
    ),
)
def steps_that_it_may_make(run: Run) -> Comparison:
    """`World.equilibrium` makes the steps that it may, and says what is left.

    It makes no more, and says it to three digits. Bodies have springs that differ a thousandfold, and are pinned. Steps
    are 1 to 1 234, of which every 500th begins anew.
    """
    from references import fire

    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(16, 48, 400)):
        steps = (1, 37, 499, 500, 501, 777, 1_000, 1_234)[trial % 8]
        mesh, mass = random_mesh(str(rng.choice(MESH_KINDS[:5])), rng), 10.0 ** rng.uniform(-1.0, 1.0)
        count, lengths = len(mesh.vertices), edge_lengths(mesh.vertices, mesh.edges)
        stiffness = 10.0 ** rng.uniform(0.5, 3.0, len(mesh.edges))
        pins = rng.choice(count, 3, replace=False)
        free = ~np.isin(np.arange(count), pins)
        world = World(gravity=rng.normal(0.0, 0.02, 3))  # a little: a surface that caves in does so by rounding
        world.add_soft_body(mesh, mass, stiffness, 0.0, damping=rng.random(), drag=rng.random(), fixed=pins)
        sums = np.bincount(mesh.edges.ravel(), np.repeat(stiffness, 2), count) * np.where(free, count / mass, 0.0)
        x, longest = mesh.vertices, 1.0 / np.sqrt(sums[mesh.edges].sum(axis=1).max())
        what = mesh.edges, lengths, stiffness, mesh.triangles, 0.0, mass / count, world.gravity, free
        for begun in range(0, steps, 500):
            x, _, _ = fire.relaxed(x, longest, min(500, steps - begun), *what)
        # (A step that is as good as none: it begins with half of its length.)
        _, speed, _ = fire.relaxed(x, 1e-12 * longest, 1, *what)
        left = np.abs(speed).max() / (0.5e-12 * longest)
        truth = left * mass / count / (1e-14 * stiffness.max() * np.ptp(x, axis=0).max())
        if truth < 1e3:
            continue  # it is at rest, to rounding
        try:
            world.equilibrium(1e-14, steps)
            told = 0.0
        except SimulationError as error:
            told = float(str(error).split("a force of ")[1].split(" ×")[0])
        answers.add(told / truth, 1.0, kind=f"{steps} steps")
    return answers.comparison()
