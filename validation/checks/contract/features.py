"""Claims about what a user sets and asks on a World, and elsewhere in the public core."""

from __future__ import annotations

import itertools
import json
import pickle
import tempfile
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import softbody
from softbody import Box, Mesh, MeshError, ParameterError, SimulationError, SnapshotError, SoftBody, World
from softbody.bodies import builder
from softbody.collision.broad_phase import _list_in_cells, near_pairs, near_pairs_exhaustive, spheres_meet
from softbody.dynamics import one_ring_forces, soft_bodies
from softbody.dynamics.integrators import _advance_body
from softbody.dynamics.soft_bodies import _store_rows, find_fault
from softbody.dynamics.vertex_rings import with_springs
from softbody.geometry import MeshQuery, box, query
from softbody.mesh import mesh
from softbody.model import validation
from softbody.model.shapes import Shapes
from softbody.stepping import checks, runner, step
from softbody.storage import snapshot
from softbody.storage.restore import restore
from softbody.storage.snapshot import named_arrays
from softbody.trajectory import held
from validation.answers import Answers
from validation.cases import MESH_KINDS, edge_lengths, random_mesh, random_orientations, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.contract.cases import BALL, error_of, rich_world, rigid, soft
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

SHAPES = {
    "sphere": softbody.icosphere(1, 0.5),
    "torus": softbody.torus(0.6, 0.25, 9, 7),
    "icosahedron": softbody.icosahedron(0.6),
}


@check(
    section="2",
    piece="softbody.SoftBody.set_springs, softbody.World.add_soft_body",
    reference="SciPy's DOP853 on springs and gas by its own formula",
    engines=("scipy",),
    unit="of the size",
    tolerance=3e-6,
    because="what rk4 errs by in a twentieth of the stable step, grown by the motion: 3e-7 at worst of ten seeds",
    faults=(
        Fault(
            "rest lengths that are not changed",
            SoftBody.set_springs,
            "lengths[edges_] = rest_length_of(rest_length_, count_) → lengths[edges_] = lengths[edges_]",
        ),
        Fault(
            "springs set on the edges next to those asked",
            SoftBody.set_springs,
            "stiffness_of(stiffness_, count_) → np.roll(stiffness_of(stiffness_, count_), 1)",
        ),
        Fault(
            "pulls of springs off by 0.1 %", with_springs, "stiffness * rest_length → 1.001 * stiffness * rest_length"
        ),
        Fault(
            "forces of the particle before",
            one_ring_forces.add_load,
            "rings_.particle[load_.first + i_] → rings_.particle[load_.first + max(0, i_ - 1)]",
        ),
        Fault("masses of the first body, whichever moves", soft_bodies._load_body, "first + i_ → i_"),
        Fault("speeds that are not brought back from a step", _store_rows, "_store_points(w_, n_, memory.velocity) → "),
        Fault(
            "forces of the first body, whichever is asked",
            SoftBody,
            "self.store.controls.particle_force[self._rows()] = f_"
            " → self.store.controls.particle_force[: len(self.positions)] = f_",
        ),
    ),
)
def springs_that_are_set(run: Run) -> Comparison:
    """Springs pull by the stiffness and the rest length they are set.

    Half-way they are set anew, and each particle is pushed: a lumpy sphere, torus and icosahedron in one World, by rk4.
    """
    from references import scipy

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 3, 10)):
        world = World(gravity=(0.0, 0.0, 0.0), integrator="rk4")
        made = []
        for k, (kind, shape) in enumerate(SHAPES.items()):
            bumps = rng.uniform(0.9, 1.1, (len(shape.vertices), 1))
            shape = Mesh(shape.vertices * bumps + (4.0 * k, 0.0, 0.0), shape.triangles)
            count, length = len(shape.edges), edge_lengths(shape.vertices, shape.edges)
            # (Springs that are far too long or short let a skin buckle, which is chaotic.)
            springs = [(length * rng.uniform(0.97, 1.03, count), rng.uniform(50.0, 300.0, count)) for _ in range(2)]
            gas, force = rng.uniform(2.0, 5.0), rng.normal(0.0, 0.3, shape.vertices.shape) / count
            body = world.add_soft_body(shape, 1.0, springs[0][1], gas, rest_length=springs[0][0], damping=0.0)
            made.append((kind, shape, springs, gas, force, body))
        for *_, force, body in made:
            body.external_force = force
        # In two halves, between which all springs change.
        steps = 400
        step = 0.05 * world.stable_time_step()
        world.step(step, steps)
        for _, _, springs, _, _, body in made:
            body.set_springs(springs[1][1], springs[1][0])
        world.step(step, steps, allow_unstable=True)
        for kind, shape, springs, gas, force, body in made:
            x, v = shape.vertices, np.zeros_like(shape.vertices)
            for length, stiffness in springs:
                what = shape.edges, length, stiffness, shape.triangles, gas, 1.0 / len(x), step * steps, force
                x, v = scipy.motion(x, v, *what, rtol=1e-10)
            answers.extend(body.positions, x, kind=kind)
    return answers.comparison()


@check(
    section="5.1",
    piece="softbody.World.step",
    reference="MuJoCo's flex of lines, Euler and RK4; P ∂V/∂x, which it lacks, as a force of the user, by numpy",
    engines=("mujoco",),
    unit="of the size and the way",
    tolerance=2e-14,
    because="rounding: 3e-15 at worst of ten seeds",
    faults=(
        Fault("sub-steps as long as steps", soft_bodies._batch, "h / substeps → h"),
        Fault("sub-steps a hundredth too short", soft_bodies._batch, "h / substeps → 0.99 * h / substeps"),
        Fault(
            "sub-steps that are not asked for",
            runner.Runner.step,
            'settings._replace(substeps=check_whole(substeps, "substeps", 1)) → settings',
        ),
    ),
)
def substeps_are_steps(run: Run) -> Comparison:
    """Sub-steps of a damped, gas-filled body are as many steps of MuJoCo."""
    from references import mujoco_flex

    rng, answers = run.fresh_rng(), Answers()
    for kind, integrator in itertools.product(MESH_KINDS[: run.count(2, 4, len(MESH_KINDS))], mujoco_flex.INTEGRATORS):
        shape = random_mesh(kind, rng)
        mass, stiffness, gas = 10.0 ** rng.uniform(-1.0, 1.0), rng.uniform(20.0, 200.0), rng.uniform(1.0, 100.0)
        damping = 0.2 * np.sqrt(stiffness * mass / len(shape.vertices))
        world = World(gravity=(0.0, 0.0, -9.81), integrator=integrator)
        body = world.add_soft_body(shape, mass, stiffness, gas, damping=damping)
        step, substeps, steps = 0.19 * world.stable_time_step(), int(rng.integers(2, 6)), int(rng.integers(5, 30))
        velocity = 0.03 * edge_lengths(shape.vertices, shape.edges).min() / step * rng.normal(size=shape.vertices.shape)
        body.velocities[:] = velocity
        world.step(substeps * step, steps, substeps=substeps)
        what = stiffness, damping, gas, mass, -9.81, step, steps * substeps, integrator
        truth = mujoco_flex.motion(shape.vertices, shape.edges, shape.triangles, velocity, *what)
        way = np.abs(truth - shape.vertices).max()
        answers.extend(body.positions, truth, np.ptp(shape.vertices, axis=0).max() + way)
    return answers.comparison()


@check(
    section="2.3",
    piece="softbody.dynamics.soft_bodies.find_fault",
    reference="the same bodies, watched step by step without a limit; volumes by NumPy",
    kind="specification",
    because="names and numbers of steps are whole",
    faults=(
        Fault("bodies that collapse at no volume only", find_fault, "volume <= least_volume → volume <= 0.0"),
        Fault(
            "a limit in cubic metres",
            soft_bodies.move_body,
            "bodies_.deflated_below[body] * bodies_.mesh_volume[body] → bodies_.deflated_below[body]",
        ),
        Fault("the first body's name", checks.fault_of, "title_of(model, body, Names()) → title_of(model, 0, Names())"),
        Fault(
            "a step that is counted and was not done",
            step.run,
            "contacts.number[0] = contacts.number[1] = 0 → contacts.number[0] = contacts.number[1] = 0\ndone += 1",
        ),
        Fault(
            "the volume at the last start of a step only",
            _advance_body,
            "stage == 0 and not volume >= least → stage == 0",
        ),
    ),
)
def collapse_is_named(run: Run) -> Comparison:
    """The body that collapses first ends the run, by its name.

    Of three that deflate, it falls below its `deflated_below` first. The error has the step in which it does, and the
    state is from before. One alone ends its run also where it would be above again in the next step.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(2, 5, 40)):
        limits, pulls = rng.uniform(0.3, 0.9, 3), rng.uniform(0.5, 0.8, 3)
        watched, h, steps, below = _deflating(np.zeros(3), pulls), 1e-3, 0, [False] * 3
        whole = [_volume(body) for body in watched.soft_bodies]
        while not any(below):
            watched.step(h)
            steps += 1
            below = [_volume(body) <= limit * full for body, limit, full in zip(watched.soft_bodies, limits, whole)]
        ended = _end_of(_deflating(limits, pulls), h, 10 * steps)
        answers.extend(ended, [below.index(True), steps - 1, steps - 1])

        # One alone, which is looked at every 32 steps: the least volume of a swing that is a few steps long.
        pull = rng.uniform(0.8, 0.95, 1)
        swinging, lows = _deflating(np.zeros(1), pull), []
        h = 0.4 * swinging.stable_time_step()
        for _ in range(30):
            swinging.step(h)
            lows.append(_volume(swinging.soft_bodies[0]) / whole[0])
        ended = _end_of(_deflating(np.sort(lows)[:2].mean(keepdims=True), pull), h, 30)
        answers.extend(ended, [0, *[int(np.argmin(lows))] * 2])
    return answers.comparison()


def _deflating(limits: np.ndarray, pulls: np.ndarray) -> World:
    """Return a world of balls that springs pull together, to parts of their lengths, each with its limit."""
    world = World(gravity=(0.0, 0.0, 0.0))
    for k, (limit, pull) in enumerate(zip(limits, pulls)):
        shape = softbody.icosphere(1, 0.4 + 0.1 * k)
        lengths, place = pull * edge_lengths(shape.vertices, shape.edges), (3.0 * k, 0.0, 0.0)
        world.add_soft_body(shape, 1.0, 200.0, 1.0, place, rest_length=lengths, deflated_below=limit)
    return world


def _end_of(world: World, h: float, steps: int) -> list[int]:
    """Return the number of the body that ends a run, -1 if none does, the step in which it does, and all before it."""
    error = error_of(SimulationError, world.step, h, steps)
    if error is None:
        return [-1, -1, world.steps]
    return [int(error.body.rpartition(" ")[2]), error.step, round(world.time / h)]


def _volume(body: SoftBody) -> float:
    """Return a body's volume [m³], by NumPy."""
    a, b, c = (body.positions[body.triangles[:, k]] for k in range(3))
    return float(np.sum(a * np.cross(b, c)) / 6.0)


@check(
    section="2.3",
    piece="softbody.dynamics.soft_bodies.find_fault",
    reference="SciPy's DOP853 on the one unknown that symmetry leaves",
    engines=("scipy",),
    unit="of the time",
    tolerance=5e-15,
    because="rounding of a quotient, 2.2e-16: the volume falls below half-way in a step, of 2 000, so the answer is"
    " that step, and the next one would be 5e-4 off",
    faults=(
        Fault("a limit of the size, cubed", find_fault, "volume <= least_volume → volume <= least_volume**3"),
        Fault(
            "a limit of the volume as it is now",
            soft_bodies.move_body,
            "bodies_.deflated_below[body] * bodies_.mesh_volume[body]"
            " → bodies_.deflated_below[body] ** 2 * bodies_.mesh_volume[body]",
        ),
    ),
)
def collapses_when_scipy_says(run: Run) -> Comparison:
    """A solid pulled together collapses in the step that SciPy says.

    A regular one without gas, whose springs leave a scalar equation of motion. The run ends with the last step before
    its volume falls below `deflated_below` by that.
    """
    from references import scipy

    rng, answers = run.fresh_rng(), Answers()
    for make in (softbody.tetrahedron, softbody.octahedron, softbody.icosahedron) * run.count(2, 6, 60):
        shape, pull, limit = make(rng.uniform(0.5, 2.0)), rng.uniform(0.3, 0.6), rng.uniform(0.3, 0.9)
        lengths, stiffness = edge_lengths(shape.vertices, shape.edges), rng.uniform(50.0, 200.0)
        world = World(gravity=(0.0, 0.0, 0.0), integrator="rk4")
        world.add_soft_body(shape, 1.0, stiffness, 0.0, rest_length=pull * lengths, damping=0.0, deflated_below=limit)
        inertia = (shape.vertices**2).sum() / len(shape.vertices)
        # In units of the length at rest it begins at 1/pull, and would swing about 1.
        swing = stiffness * (pull**2 * lengths**2).sum() / (pull**2 * inertia)
        times = np.linspace(0.0, 0.5 * np.pi / np.sqrt(swing), 2_001)
        scale, _ = scipy.scale_motion(times, 1.0 / pull, 0.0, inertia * pull**2, swing * pull**2 * inertia, 0.0)
        when = float(np.interp(-(limit ** (1.0 / 3.0)), -pull * scale, times))
        step = when / 2_000.5
        error = error_of(SimulationError, world.step, step, 4_000)
        asked: dict[str, Any] = {"edge": lengths[0], "stiffness": stiffness, "pull": pull, "deflated_below": limit}
        answers.add((error.step + 0.5) * step / when if error else np.inf, 1.0, **asked)
    return answers.comparison()


@check(
    section="5.1",
    piece="softbody.dynamics.soft_bodies.find_fault",
    reference="places and velocities after one step of free flight, by NumPy",
    kind="specification",
    because="yes or no; those within 1 % of the limit are left out",
    faults=(
        Fault("a body of a metre at least", find_fault, "0.0, 0.0, count_ → 1.0, 0.0, count_"),
        Fault(
            "velocities seen from the world",
            find_fault,
            "in_double(load_lanes(rows[3 + c], i)) - mean → in_double(load_lanes(rows[3 + c], i)) - 0.0 * mean",
        ),
        Fault(
            "twins that count",
            find_fault,
            "first_lanes(load_lanes(rows[3 + c], i), counting) → load_lanes(rows[3 + c], i)",
        ),
    ),
)
def divergence_by_the_rule(run: Run) -> Comparison:
    """A soft body diverges where a particle would cross all of it.

    It does if, and only if, one more step would take it so far, along an axis, as seen from the mean velocity. Bodies
    of 1 cm to 10 m, at rest or in flight at up to a hundred times that.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(60, 300, 3_000)):
        mesh, h = softbody.icosphere(1 + trial % 2, 10.0 ** rng.uniform(-2.0, 1.0)), 10.0 ** rng.uniform(-4.0, -1.0)
        start, size = mesh.vertices, np.ptp(mesh.vertices, axis=0).max()
        velocity = np.zeros_like(start)
        if trial % 3:
            velocity += 10.0 ** rng.uniform(-1.0, 2.0) * size / h * rng.normal(size=3)
        velocity -= rng.uniform(-1.0, 0.99) * start / h  # outwards, or inwards so that it is smaller after the step
        extent = np.ptp(start + h * velocity, axis=0).max()
        ahead = h * np.abs(velocity - velocity.mean(axis=0)).max() / extent
        if abs(ahead - 1.0) < 0.01:
            continue
        body = World(gravity=(0.0, 0.0, 0.0)).add_soft_body(mesh, 1.0, 0.0, 0.0, damping=0.0, deflated_below=0.0)
        body.velocities[:] = velocity
        kind = f"{'in flight' if trial % 3 else 'at rest'}, {'diverges' if ahead > 1.0 else 'goes on'}"
        answers.add(_diverges(body.world, h), ahead > 1.0, kind=kind)
    return answers.comparison()


def _diverges(world: World, h: float) -> bool:
    """Tell whether a body has diverged after a step."""
    error = error_of(SimulationError, world.step, h)
    return error is not None and "diverged" in str(error)


@check(
    section="5.1",
    piece="softbody.dynamics.soft_bodies.find_fault",
    reference="that rule, on a tetrahedron of rest lengths whose squares add up to one",
    kind="specification",
    because="yes or no; springs too soft to move a particle by a rounding in the step",
    faults=(
        Fault("bodies that are just as long", find_fault, "extent <= most_extent → extent < most_extent"),
        Fault("a hundredth longer", find_fault, "extent <= most_extent → extent <= 1.01 * most_extent"),
        Fault("any length", find_fault, "extent <= most_extent → extent <= np.inf"),
        Fault("the last axis alone", find_fault, "max(extent, highest - lowest) → highest - lowest"),
    ),
)
def longest_by_the_rule(run: Run) -> Comparison:
    """A soft body diverges exactly where it is a thousandfold too long.

    Without gas or weight, its limit along an axis is 1 000 times the root of the sum of its squared rest lengths. It is
    tried at 0.997 and 1.003 times that, at that in powers of two, and a rounding beyond.
    """
    rng, answers = run.fresh_rng(), Answers()
    kinds = "0.997 of the limit", "at the limit", "a rounding beyond", "1.003 of the limit"
    for _, kind in zip(range(run.count(24, 96, 960)), itertools.cycle(kinds)):
        scale, axes = 2.0 ** rng.integers(-6, 7), rng.permutation(3)
        lengths = scale * rng.permutation([2.0, 1.0, 1.0, 1.0, 1.0, 1.0])
        limit = 1_000.0 * 3.0 * scale
        corners = np.array([(-2.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.5, 1.0)])[:, axes]
        faces = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
        outward = 1 if np.linalg.det(np.eye(3)[axes]) > 0 else -1
        mesh = Mesh(scale * corners, faces[:, ::outward])
        world = World(gravity=(0.0, 0.0, 0.0))
        body = world.add_soft_body(mesh, 1.0, 1e-9, 0.0, rest_length=lengths, damping=0.0, deflated_below=0.0)
        ends = 0.5 * limit * np.array([-1.0, 1.0])
        if kind == "a rounding beyond":
            ends[1] *= 1.0 + 2.0**-51
        elif kind != "at the limit":
            ends *= float(kind.split()[0])
        positions = mesh.vertices * 100.0
        positions[:2, np.flatnonzero(axes == 0)[0]] = ends
        body.positions = positions
        answers.add(_diverges(world, 1e-7 * scale), np.diff(ends)[0] > limit, kind=kind)
    return answers.comparison()


@check(
    section="9",
    piece="softbody.dynamics.soft_bodies.move_soft_bodies",
    reference="closed form: v = g t of whole steps",
    kind="closed form",
    unit="steps",
    tolerance=5e-12,
    because="rounding of springs that are as long as at rest, which is more than that of weight: 2e-13 at worst of ten"
    " seeds",
    faults=(
        Fault("told to stop, it does not set out", _advance_body, "turn > 0 → turn >= 0"),
        Fault("a step left in its midst", _advance_body, "(batch.begin + step) % batch.landing == 0 → step > 0"),
    ),
)
def a_step_before_the_end(run: Run) -> Comparison:
    """Soft bodies told to stop before they set out make one step.

    They make one, of however many parts, all alike; in haste, if it has several, none; and they fall as long as that.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(6, 20, 100)):
        world, in_haste = World(gravity=rng.normal(0.0, 5.0, 3)), trial % 2 == 1
        for k in range(3):
            world.add_soft_body(BALL, 1.0, 50.0, 0.0, (2.0 * k, 0.0, 0.0), damping=0.0)
        motion = soft_bodies.motion_of(world.model.soft_particle_start, world.store.rings)
        motion.memory.stop[0] = 1
        h = 0.3 * world.stable_time_step()
        settings = world.store.settings._replace(substeps=int(rng.integers(1 + in_haste, 4)))
        done, _, _ = step.run_alone(world.model, world.controls, world.state, motion, settings, h, 7, in_haste)
        fallen = world.state.particle_velocity @ world.gravity / (h * world.gravity @ world.gravity)
        truth = [0.0 if in_haste else 1.0] * 3
        answers.add([done, fallen.min(), fallen.max()], truth, kind="in haste" if in_haste else "not in haste")
    return answers.comparison()


@check(
    section="3, 10.13",
    piece="softbody.Box.apply_force, softbody.Box.apply_torque, softbody.Box.clear_forces",
    reference="closed form: sums of F/m and τ/I over steps, rotations by SciPy",
    kind="closed form",
    engines=("scipy",),
    unit="of the way, of a unit vector",
    tolerance=1e-12,
    because="rounding of sums over 80 steps: 1e-13 at worst of ten seeds",
    faults=(
        Fault(
            "an arm from the origin", Box.apply_force, 'vector(point, "point") - self.position → vector(point, "point")'
        ),
        Fault("a force that replaces the one before", Box.apply_force, "controls.box_force[row] + newtons → newtons"),
        Fault(
            "torques that are not cleared",
            Box.clear_forces,
            "(controls.box_torque[row], 0.0) → (controls.box_torque[row], controls.box_torque[row])",
        ),
        Fault(
            "the torque of the box before",
            Box.apply_torque,
            "self.store.controls.box_torque[self.row()] += t_ → self.store.controls.box_torque[self.row() - 1] += t_",
        ),
    ),
)
def forces_on_boxes(run: Run) -> Comparison:
    """Forces and torques act on their box until they are cleared.

    At points of any box among several, in every step; each box turns about one of its axes.
    """
    rng, answers = run.fresh_rng(), Answers()
    step, steps, more = 1e-3, 50, 30  # steps with forces, and without
    for _ in range(run.count(3, 20, 200)):
        world, truths = World(gravity=(0.0, 0.0, 0.0)), []
        for k in range(3):
            size, mass, axis = rng.uniform(0.5, 2.0, 3), 10.0 ** rng.uniform(-1.0, 1.0), int(rng.integers(3))
            q, start = random_orientations(rng, 1)[0], np.array([9.0 * k, 0.0, 0.0])
            world.add_box(size, mass, start, q)
            # In the plane across the axis: the force turns the box about it, and moves it besides.
            turn = rotation_matrix(q)
            arm, newtons = (turn @ np.where(np.arange(3) == axis, 0.0, rng.normal(size=3)) for _ in range(2))
            push, torque = rng.normal(size=3), rng.normal() * turn[:, axis]
            inertia = mass / 12.0 * (np.sum(size**2) - size[axis] ** 2)
            a, alpha = (newtons + push) / mass, (torque + np.cross(arm, newtons)) / inertia
            way = step**2 * (0.5 * steps * (steps + 1) + steps * more)
            rotation = Rotation.from_rotvec(way * alpha).as_matrix() @ turn
            speeds = steps * step * a, steps * step * alpha
            truths.append((arm, newtons, push, torque, np.concatenate([start + way * a, *speeds, rotation.ravel()])))
        for one, (arm, newtons, push, torque, _) in zip(world.boxes, truths):
            one.apply_force(newtons, one.position + arm)
            one.apply_force(push)
            one.apply_torque(torque)
        world.step(step, steps)
        for one in world.boxes:
            one.clear_forces()
        world.step(step, more)
        for one, (*_, truth) in zip(world.boxes, truths):
            turned = rotation_matrix(one.orientation).ravel()
            answers.add(np.concatenate([one.position, one.velocity, one.angular_velocity, turned]), truth)
    return answers.comparison()


@check(
    section="4.6",
    piece="softbody.geometry.MeshQuery",
    reference="libigl, on the moved vertices",
    engines=("igl",),
    unit="of the size",
    tolerance=3e-15,
    because="rounding: 2.6e-16 at worst of ten seeds",
    faults=(
        Fault(
            "a tree that stays where it was",
            MeshQuery.move,
            "self._grid_is_old = self._tree_is_old = True → self._grid_is_old = True",
        ),
        Fault(
            "a grid that stays where it was",
            MeshQuery.move,
            "self._grid_is_old = self._tree_is_old = True → self._tree_is_old = True",
        ),
        Fault(
            "vertices that stay where they were",
            MeshQuery.move,
            "self._vertices[:] = moved → self._vertices[:1] = moved[:1]",
        ),
        Fault("the last point left out", query._share, "count * k // threads → count * k // threads - (k == threads)"),
    ),
)
def queries_follow_the_mesh(run: Run) -> Comparison:
    """A MeshQuery that moves answers for the mesh as it is now.

    It says of every point if it is inside the mesh and how far from it, asked now for this and now for that.
    """
    from references import igl

    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(2, 6, 40)):
        kind = MESH_KINDS[trial % len(MESH_KINDS)]
        shape = random_mesh(kind, rng)
        asked = MeshQuery(shape.vertices, shape.triangles)
        for turn in range(4):
            stretch = np.eye(3) + 0.2 * rng.normal(size=(3, 3))
            stretch *= np.sign(np.linalg.det(stretch))
            moved = shape.vertices @ stretch.T + rng.normal(size=3)
            asked.move(moved)
            low, high = moved.min(axis=0), moved.max(axis=0)
            points = rng.uniform(low - 0.1, high + 0.1, (run.count(100, 400, 400), 3))
            size, threads = float(np.ptp(moved, axis=0).max()), 1 + turn % 2
            if turn != 1:  # one move without being asked for it
                inside = igl.points_in_mesh_by_distance(points, moved, shape.triangles)
                answers.extend(asked.contains(points, threads), inside, kind=f"{kind}, inside")
            if turn != 2:
                distance = igl.closest_points(points, moved, shape.triangles)[0] / size
                answers.extend(asked.closest(points, threads).distance / size, distance, kind=f"{kind}, distance")
    return answers.comparison()


@check(
    section="4",
    piece="softbody.collision.broad_phase.near_pairs",
    reference="all distances, by SciPy's k-d tree",
    engines=("scipy",),
    because="pairs that meet by less than rounding are left out of the cases",
    faults=(
        Fault("spheres that both must move", near_pairs, "movable[i] or movable[j] → movable[i] and movable[j]"),
        Fault("cells that are only half as wide", _list_in_cells, "2.0 * WIDER * largest → 1.0 * WIDER * largest"),
        Fault("the neighbours on one side only", near_pairs, "range(x if own else x - 1, x + 2) → range(x, x + 2)"),
        Fault("coarser grids that are left out", near_pairs, "coarse > level[i] → coarse != level[i]"),
    ),
)
def near_pairs_are_all(run: Run) -> Comparison:
    """The list of near pairs has all spheres that meet, once.

    It has every two of which one can move, and no others: sizes from 1 to 1 000, crowded and far from the origin.
    """
    from scipy.spatial import cKDTree

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(20, 100, 1_000)):
        count = int(rng.integers(2, 120))
        radius = 10.0 ** rng.uniform(0.0, rng.choice([0.1, 1.0, 3.0]), count)
        wide = rng.choice([2.0, 8.0, 30.0]) * np.median(radius)
        centre = rng.uniform(-wide, wide, (count, 3)) + rng.choice([0.0, 1e6]) * rng.normal(size=3)
        movable = rng.random(count) < 0.7
        listed = [(int(a), int(b)) for a, b in near_pairs(centre, radius, movable)]
        near = cKDTree(centre).query_pairs(2.0 * radius.max(), output_type="ndarray")
        reach = radius[near].sum(axis=1)
        gap = np.linalg.norm(centre[near[:, 0]] - centre[near[:, 1]], axis=1) - reach
        unsure = np.abs(gap) <= 1e-9 * reach + 1e-12 * np.abs(centre).max()
        meets = (gap < 0.0) & movable[near].any(axis=1)
        truth, close = ({(int(max(pair)), int(min(pair))) for pair in near[those]} for those in (meets, unsure))
        answers.add(len((set(listed) ^ truth) - close) + len(listed) - len(set(listed)), 0)
    return answers.comparison()


@check(
    section="4",
    piece="softbody.collision.broad_phase.near_pairs_exhaustive",
    reference="all distances, by NumPy, in that order",
    kind="exhaustive search",
    because="radii and places are whole numbers, so that nothing is rounded: some just touch",
    faults=(
        Fault("pairs that there is no room for", near_pairs_exhaustive, "pairs = _longer(pairs) → count -= 1"),
        Fault(
            "pairs of which one cannot move",
            near_pairs_exhaustive,
            "movable[a] or movable[b] → movable[a] and movable[b]",
        ),
        Fault("spheres that touch and do not meet", spheres_meet, "d_ <= reach * reach → d_ < reach * reach"),
    ),
)
def all_pairs_are_tried(run: Run) -> Comparison:
    """Trying all pairs lists all spheres that meet, in order.

    By the higher number, then the lower one, if one can move: of two to ten, also if all meet; more at higher levels.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(40, 150, 1_500)):
        dense = case % 4 == 0
        count = 10 if dense else int(rng.integers(2, run.count(11, 40, 100)))
        radius = rng.integers(1, 6, count).astype(float)
        centre = rng.integers(0, 2 if dense else 12, (count, 3)).astype(float)
        movable = np.ones(count, bool) if dense else rng.random(count) < 0.7
        a, b = np.tril_indices(count, -1)
        meets = ((centre[a] - centre[b]) ** 2).sum(axis=1) <= (radius[a] + radius[b]) ** 2
        near = np.flatnonzero(meets & (movable[a] | movable[b]))
        told = near_pairs_exhaustive(centre, radius, movable).tolist()
        is_so = told == np.stack([a[near], b[near]], axis=1).tolist()
        answers.add(is_so, True, kind="all meet" if dense else "some meet")
    return answers.comparison()


@check(
    section="4.7",
    piece="softbody.geometry.box.point_in_box",
    reference="SciPy's rotations; the six faces one by one",
    kind="closed form",
    engines=("scipy",),
    unit="of the size, of a unit vector",
    tolerance=1e-14,
    because="rounding: 1.1e-15 at worst of ten seeds",
    faults=(
        Fault("boxes a thousandth too large", box.point_in_box, "0.5 * size_[axis] → 0.5005 * size_[axis]"),
        Fault("the farthest face", box.point_in_box, "behind < depth → behind > depth or depth == np.inf"),
        Fault("normals that are not turned", box.point_in_box, "rotate(orientation_, normal) → normal"),
        Fault("normals that point inwards", box.point_in_box, "local[axis] >= 0.0 → local[axis] < 0.0"),
    ),
)
def depth_in_a_box(run: Run) -> Comparison:
    """A point in a box is measured from its nearest face.

    Told is how deep the point is, or how far outside that face's plane, and the face's normal.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(200, 2_000, 20_000)):
        size, place, q = rng.uniform(0.2, 3.0, 3), rng.normal(0.0, 3.0, 3), random_orientations(rng, 1)[0]
        turn = Rotation.from_quat(q, scalar_first=True)
        local = rng.uniform(-0.7, 0.7, 3) * size
        depths = np.array([0.5 * size[c] - side * local[c] for c in range(3) for side in (1.0, -1.0)])
        if np.partition(depths, 1)[1] - depths.min() < 1e-9:
            continue  # two faces are as near: either is right
        nearest = int(depths.argmin())
        normal = turn.apply(np.eye(3)[nearest // 2] * (1.0, -1.0)[nearest % 2])
        depth, out = box.point_in_box(tuple(turn.apply(local) + place), tuple(size), tuple(place), tuple(q))
        unit = size.max() + np.abs(place).max()
        answers.add([depth / unit, *out], [depths.min() / unit, *normal])
    return answers.comparison()


def state_of(world: World) -> np.ndarray:
    """Return the bits of where bodies are, how they move, and the clock."""
    parts = [*(array.ravel() for array in world.state), [world.time, float(world.steps), world.energy()]]
    return np.concatenate([np.asarray(part, float) for part in parts]).view(np.int64)


@check(
    section="9",
    piece="softbody.World.snapshot, softbody.World.restore, softbody.World.save, softbody.World.load",
    reference="the same world, not interrupted",
    kind="the core in another form",
    because="bit for bit",
    faults=(
        Fault("a clock that starts anew", restore, "new_clock(steps, time) → new_clock()"),
        Fault("what the solver remembers, forgotten", restore, "remembering(cache, FIRST_ROOM) → store.contacts"),
        Fault(
            "settings that are not restored",
            restore,
            '(store, "settings", settings) → (store, "settings", store.settings)',
        ),
        Fault("a snapshot that shares memory with the world", named_arrays, "np.array(value) → np.asarray(value)"),
    ),
)
def worlds_go_on_from_snapshots(run: Run) -> Comparison:
    """A world goes on from a snapshot to the same bits.

    One of all that can be set, with its clock, in both precisions: into itself or a new world, from a file or a pickle.
    """
    answers = Answers()
    for precision in ("double", "single"):
        world = rich_world(run.fresh_rng(), precision)
        step, steps = 0.5 * world.stable_time_step(), run.count(60, 200, 1_000)
        world.step(step, steps)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "world.npz"
            world.save(path)
            kept, pickled = world.snapshot(), pickle.dumps(world)
            world.step(step, steps)
            truth = state_of(world)
            other = World()
            for one in (world, other):
                with suppress(SnapshotError):  # then it is as it was, and goes on otherwise
                    one.restore(kept)
            ways = {"itself": world, "another": other, "file": World.load(path), "pickle": pickle.loads(pickled)}
            for name, one in ways.items():
                one.step(step, steps)
                end = state_of(one)
                same = end == (truth if end.shape == truth.shape else ~end)  # of other bodies no bit is the same
                answers.extend(same, np.ones(len(same), bool), kind=f"{name}, {precision}")
    return answers.comparison()


@check(
    section="9",
    piece="softbody.World.state_hash",
    reference="the bits themselves, by NumPy",
    kind="specification",
    faults=(
        Fault(
            "a hash without velocities",
            snapshot.digest,
            "result.update(array.tobytes()) → result.update(b'' if 'velocity' in name else array.tobytes())",
        ),
        Fault("a hash of single precision", snapshot.digest, "array.tobytes() → array.astype(np.float32).tobytes()"),
        Fault("a hash of each array's beginning", snapshot.digest, "array.tobytes() → array.tobytes()[:64]"),
    ),
)
def hashes_are_of_every_bit(run: Run) -> Comparison:
    """Worlds share a `state_hash` exactly if places and motions agree bitwise."""
    rng, answers = run.fresh_rng(), Answers()
    world = rich_world(rng)
    start, first = world.snapshot(), world.state_hash()
    for _ in range(run.count(100, 500, 5_000)):
        array = world.state[int(rng.integers(len(world.state)))]
        place = tuple(int(rng.integers(n)) for n in array.shape)
        before = array[place]
        array[place] = np.nextafter(before, np.inf)
        answers.add(world.state_hash() == first, False)
        array[place] = before
        answers.add(world.state_hash() == first, True)
    world.restore(start)
    answers.add(world.state_hash() == first, True)
    return answers.comparison()


NAN = float("nan")
SOFT_NEVER: dict[str, tuple[float, ...]] = {"mass": (0.0, -1.0, NAN), "gas": (-1.0, NAN), "stiffness": (-1.0, NAN)}
SOFT_NEVER |= {"friction": (-0.1,), "restitution": (1.5,), "damping": (-1.0,), "drag": (NAN,), "deflated_below": (2.0,)}
BOX_NEVER = {"size": (1.0, 0.0, 1.0), "mass": -1.0, "position": (NAN, 0.0, 0.0), "friction": -1.0}

Refusal = tuple[str, Callable[[], object], type[Exception], str]  # in words, the call, its error, and what that names


def refusals() -> Iterator[Refusal]:
    """Yield what must be refused, one after the other."""
    for name, values in SOFT_NEVER.items():
        for value in values:
            yield f"{name} {value}", partial(soft, **{name: value}), ParameterError, name
    yield "no such property", partial(soft, colour=1.0), ParameterError, "colour"
    yield "fixed vertex", partial(soft, fixed=(99,)), ParameterError, "fixed"
    yield "rest length", partial(soft, rest_length=-1.0), ParameterError, "rest_length"
    yield "as many springs", partial(soft, stiffness=np.ones(7)), ParameterError, "stiffness"
    for name, given in BOX_NEVER.items():
        yield f"box {name}", partial(rigid, **{name: given}), ParameterError, name
    yield "orientation", partial(rigid, orientation=(2.0, 0.0, 0.0, 0.0)), ParameterError, "orientation"
    wrong: Mapping[str, Any] = {"threads": 0, "integrator": "euler", "colour": 1}
    for words, name in zip(("threads", "integrator", "a choice"), wrong):
        yield words, partial(World, **{name: wrong[name]}), ParameterError, name
    corners, faces = BALL.vertices, BALL.triangles
    turned, spoilt = np.vstack([faces[:1, ::-1], faces[1:]]), np.where(corners == corners.max(), NAN, corners)
    yield "open mesh", partial(Mesh, corners, faces[1:]), MeshError, "edge"
    yield "a triangle turned", partial(Mesh, corners, turned), MeshError, "edge"
    yield "inside out", partial(Mesh, corners, faces[:, ::-1]), MeshError, "volume"
    yield "index", partial(Mesh, corners[:-1], faces), MeshError, "vert"
    yield "NaN", partial(Mesh, spoilt, faces), MeshError, "vert"
    yield "too long a step", partial(_step_after, 0, 2.0 * 1.01), ParameterError, "time_step"
    yield "too long a step, after some", partial(_step_after, 2, 1.35), ParameterError, "time_step"
    squeezed, filled = partial(_step_after, 2, 0.9, positions=0.1), partial(_step_after, 2, 0.9, gas=1e3)
    yield "a step too long for what was moved", squeezed, ParameterError, "time_step"
    yield "a step too long for more gas", filled, ParameterError, "time_step"
    flat, too_light, torn = soft(), soft(mass=1e-300, stiffness=1e100), soft()
    flat.add_soft_body(BALL, 1.0, 100.0, 10.0, (5.0, 0.0, 0.0))
    flat.soft_bodies[0].positions[:, 2] = 0.0
    torn.soft_bodies[0].positions *= 1e120
    yield "no stable step, flat", flat.stable_time_step, ParameterError, "soft body 0 is flat"
    yield "no stable step, light", too_light.stable_time_step, ParameterError, "soft body 0 is too light"
    yield "no stable step, torn", torn.stable_time_step, ParameterError, "soft body 0 are not finite, or too far apart"
    diverging = partial(soft(stiffness=1e4).step, 0.1, 1_000, allow_unstable=True)
    yield "divergence", diverging, SimulationError, "soft body 0"
    yield "no snapshot", partial(World().restore, {}), SnapshotError, "missing"
    yield "too many vertices", partial(softbody.box, segments=10_000_000), ParameterError, "vertices"
    yield "edges lost in rounding", partial(soft, position=(0.0, 1e17, 0.0)), ParameterError, "position"
    yield "a trajectory of other bodies", _go_on_with_others, softbody.TrajectoryError, "other bodies"
    yield "a film of nothing", _film_of_nothing, ParameterError, "no bodies"
    overlapping = soft()
    overlapping.add_soft_body(BALL, 1.0, 100.0, 10.0, (0.4, 0.0, 0.0))
    yield "overlap", partial(overlapping.step, 1e-4), softbody.OverlapWarning, "soft body 1"
    loaded = World()
    loaded.add_ground()
    loaded.add_box((1.0, 1.0, 0.5), 1e-6, (0.0, 0.0, 0.25))
    loaded.add_soft_body(BALL, 1.0, 400.0, 60.0, (0.0, 0.0, 0.99))
    yield "mass ratio", partial(loaded.run, 0.05, 1e-3), softbody.MassRatioWarning, "box 0"


def _step_after(steps: int, times: float, **factors: float) -> None:
    """Step a world of a ball, after some steps and with what is larger than before, by so many stable steps at once."""
    world = soft()
    longest = world.stable_time_step()
    for _ in range(steps):
        world.step(0.9 * longest)
    for name, factor in factors.items():
        setattr(world.soft_bodies[0], name, factor * getattr(world.soft_bodies[0], name))
    world.step(times * longest)


def _film_of_nothing() -> None:
    with tempfile.TemporaryDirectory() as folder:
        nobody = Shapes(np.zeros(1, np.int64), np.zeros(1, np.int64), np.zeros((0, 3), np.int64), np.zeros((0, 3)))
        none = {"time": np.zeros(1), "box_orientation": np.zeros((1, 0, 4))}
        none |= {f"{kind}_position": np.zeros((1, 0, 3)) for kind in ("particle", "box")}
        for file, arrays in {"bodies.npz": nobody._asdict(), "000000.npz": none}.items():
            np.savez(Path(folder) / file, **arrays)
        sha256 = snapshot.digest(named_arrays("bodies", nobody))
        manifest: dict[str, Any] = {"format": 1, "bodies": {"sha256": sha256}, "velocities": False}
        manifest["chunks"] = [{"file": "000000.npz", "frames": 1, "times": [0.0]}]
        (Path(folder) / "trajectory.json").write_text(json.dumps(manifest))
        softbody.Trajectory.open(folder).export(Path(folder) / "film.glb")


def _go_on_with_others() -> None:
    world = rigid()
    with tempfile.TemporaryDirectory() as folder:
        softbody.TrajectoryWriter(world, folder).close()
        place = Path(folder) / "trajectory.json"
        manifest = json.loads(place.read_text())
        manifest["bodies"]["sha256"] = "0" * 64
        place.write_text(json.dumps(manifest))
        softbody.TrajectoryWriter(world, folder, resume=True)


@check(
    section="2, 3",
    piece="softbody.errors",
    reference="the documentation: which error, and what it names",
    kind="specification",
    faults=(
        Fault("negative masses are taken", validation.check_range, "least <= value <= most → value <= most"),
        Fault("triangles may be turned round", mesh._check_closed, "forward == 1 → forward >= 0"),
        Fault("nobody warns of overlaps", checks.warn_of_overlap, "depth > d_ → False"),
        Fault("what is light taken for torn apart", checks._unstable, "not isfinite(volume) → volume != 0.0"),
        Fault("nobody warns of light boxes", checks.warn_of_mass_ratios, "(carried > most).any() → False"),
        Fault("shapes of any number of vertices", mesh._check_number, "vertices > MOST_VERTICES → False"),
        Fault("soft bodies however far away", builder.with_soft_body, "not lengths[edge] > s_ → False"),
        Fault("whatever has as many bodies", held._staying, "segment.sha256 == bodies → True"),
    ),
)
def refusals_name_the_culprit(run: Run) -> Comparison:
    """An error or warning of its kind names what cannot be."""
    answers = Answers()
    for words, call, kind, named in refusals():
        with warnings.catch_warnings():
            warnings.simplefilter("error", softbody.OverlapWarning)
            warnings.simplefilter("error", softbody.MassRatioWarning)
            error = error_of(Exception, call)
        answers.add(type(error) is kind and named in str(error), True, kind=words)
    return answers.comparison()
