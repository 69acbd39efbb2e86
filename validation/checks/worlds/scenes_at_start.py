"""Claims that scenes 3 and 4 are built as they are told to be."""

from __future__ import annotations

import numpy as np

from softbody import World
from softbody.scenes import boxes_on_torus, torus_stack
from validation.answers import Answers
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "scenes over time"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process


@check(
    section="9",
    piece="softbody.scenes.boxes_on_torus",
    reference="distances by FCL; the torus's volume by trimesh against its closed form; powers of three quarters",
    engines=("fcl", "trimesh"),
    kind="closed form",
    unit="of each number, or metres",
    tolerance=5e-15,
    because="rounding of heights of a few metres: 8.9e-16 at worst",
    faults=(
        Fault(
            "cubes that are alike from the third on",
            boxes_on_torus.build,
            "LARGEST * SMALLER ** k → LARGEST * SMALLER ** min(k, 2)",
        ),
        Fault("cubes that are turned by a quarter", boxes_on_torus.build, "0.125 * np.pi * k → 0.25 * np.pi * k"),
        Fault("cubes as heavy as their sides", boxes_on_torus.build, "DENSITY * side ** 3 → DENSITY * side"),
        Fault("cubes without air between them", boxes_on_torus.build, "base += GAP → base += GAP * (k == 0)"),
    ),
)
def tower_of_cubes(run: Run) -> Comparison:
    """Scene 3 begins with a torus and a tower of cubes.

    The torus is 5 cm above the ground; as many cubes as asked for are above its hole. Each has three quarters of the
    side of the one below, is turned by an eighth, 0.2 m above it, of 0.4 kg/m³.
    """
    from references import analytic, fcl, trimesh

    answers = Answers()
    for count in range(run.count(6, 8, 12)):
        world = boxes_on_torus.build(count)
        model, state = world.model, world.state
        torus = state.particle_position, model.triangle_particles
        answers.add(len(world.soft_bodies), 1, kind="soft")
        answers.add(len(world.boxes), count, kind="cubes")
        answers.add(trimesh.volume(*torus), analytic.faceted_torus_volume(1.0, 0.4, 36, 18), kind="volume")
        answers.add((1.0 / model.particle_inverse_mass).sum(), 2.0, kind="mass")
        answers.add(trimesh.centroid(*torus)[2], 0.45, kind="height")
        answers.add(model.ground_height, 0.0, kind="height")
        side = 0.75 ** np.arange(count)
        bottom = 0.85 + np.cumsum(0.2 + np.append(0.0, side))[:count]
        for k in range(count):
            place, turn = np.array([0.0, 0.0, bottom[k] + 0.5 * side[k]]), _turn(np.pi / 8.0 * k)
            turned = state.box_orientation[k] * np.sign(state.box_orientation[k] @ turn)
            answers.add(np.abs(model.box_size[k] - side[k]).max(), 0.0, kind="size")
            answers.add(1.0 / model.box_inverse_mass[k], 0.4 * side[k] ** 3, kind="mass")
            answers.add(np.abs(state.box_position[k] - place).max(), 0.0, kind="place")
            answers.add(np.abs(turned - turn).max(), 0.0, kind="turn")
        rows = model.box_size, state.box_position, state.box_orientation
        if count > 1:
            gaps = fcl.box_distance(*(row[:-1] for row in rows), *(row[1:] for row in rows))
            answers.extend(gaps, np.full(count - 1, 0.2), kind="gap")
    return answers.comparison()


def _turn(half: float) -> np.ndarray:
    """Return the quaternion of a turn about z by twice an angle."""
    return np.array([np.cos(half), 0.0, 0.0, np.sin(half)])


@check(
    section="9",
    piece="softbody.scenes.torus_stack",
    reference="distances of surfaces by libigl; volumes by trimesh against the closed form",
    engines=("igl", "trimesh"),
    kind="closed form",
    unit="of each number, or metres",
    tolerance=2e-14,
    because="rounding of heights: 8.9e-16 of four tori, 4.5e-15 of nine, 8 m high",
    faults=(
        Fault("tori that touch", torus_stack.build, "0.45 + 0.85 * k → 0.45 + 0.8 * k"),
        Fault("tori that lean", torus_stack.build, "(0.0, 0.0, 0.45 + 0.85 * k) → (0.01 * k, 0.0, 0.45 + 0.85 * k)"),
        Fault("a torus too few", torus_stack.build, "range(bodies) → range(max(1, bodies - 1))"),
    ),
)
def stack_of_tori(run: Run) -> Comparison:
    """Scene 4 begins with a stack of equal tori.

    There are as many as asked for, the lowest 5 cm above the ground and 5 cm of air between each two. It is built in a
    world that is given, which keeps what it had.
    """
    from references import analytic, igl, trimesh

    answers = Answers()
    for count in range(1, run.count(5, 7, 10)):
        given = World(gravity=(0.0, 0.0, -1.62))
        world = torus_stack.build(count, given)
        surfaces = [(body.positions.copy(), body.triangles) for body in world.soft_bodies]
        answers.add(len(surfaces), count, kind="tori")
        answers.add(world is given, True, kind="same")
        answers.add(world.gravity[2], -1.62, kind="gravity")
        answers.add(surfaces[0][0][:, 2].min() - world.model.ground_height, 0.05, kind="air")
        lowest = surfaces[0][0]
        for k, (vertices, triangles) in enumerate(surfaces):
            volume = analytic.faceted_torus_volume(1.0, 0.4, 24, 12)
            answers.add(trimesh.volume(vertices, triangles), volume, kind="volume")
            answers.add(world.soft_bodies[k].mass, 1.0, kind="mass")
            answers.add(np.abs(trimesh.centroid(vertices, triangles)[:2]).max(), 0.0, kind="aside")
            answers.add(np.abs(vertices - vertices.mean(0) - lowest + lowest.mean(0)).max(), 0.0, kind="copy")
            if k:
                answers.add(igl.closest_points(vertices, *surfaces[k - 1])[0].min(), 0.05, kind="air")
    return answers.comparison()
