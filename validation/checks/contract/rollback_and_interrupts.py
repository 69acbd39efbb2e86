"""Claims about what a step leaves that fails or is interrupted, and who is told of signals meanwhile."""

from __future__ import annotations

import os
import signal
import threading
import time
import warnings
from types import FrameType

import numpy as np

import softbody
from softbody import SimulationError, World
from softbody.collision.solver import warm_start
from softbody.compiler import interrupts
from softbody.compiler.interrupts import InterruptFlag
from softbody.dynamics import integrators, soft_bodies
from softbody.dynamics.soft_bodies import move_body, move_in_place
from softbody.stepping import runner, step
from validation.answers import Answers
from validation.cases import edge_lengths
from validation.check import Comparison, Run, check
from validation.checks.contract.cases import error_of, rich_world, soft
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

SUBSTEPS = 5  # a step of one is never left in its midst


def same(one: World, other: World) -> bool:
    """Tell whether snapshots of two worlds have the same bits."""
    mine, its = one.snapshot(), other.snapshot()
    return mine.keys() == its.keys() and all(mine[name].tobytes() == its[name].tobytes() for name in mine)


@check(
    section="beyond the paper",
    piece="softbody.World.step",
    reference="the rule, of Σ l0² and nRT by NumPy; the wall's way, which is the ball's; a twin that was not stepped",
    kind="specification",
    faults=(
        Fault("nobody looks where balls are thrown", step.step, "_diverged_by_contacts(m_, s_, w_, c_, h_) → -1"),
        Fault("the first ball may go anywhere", step._diverged_by_contacts, "thrown >= 0 → thrown >= 1"),
        Fault("the first ball's limit", step._soft_body_out_of_bounds, "far <= longest[body] → far <= longest[0]"),
        Fault("steps that are not undone", step.run, "copy_state(s_, state) → pass", nth=1),
    ),
)
def thrown_by_a_wall(run: Run) -> Comparison:
    """A ball that a wall throws too far ends the run.

    By its name, in the step that throws it farther than it may be long: 1 000 times what its springs and gas make of
    it. Among other balls, smaller and larger, all is as before, to the bit, and nothing touches. Slower, it is thrown.
    """
    rng, answers = run.fresh_rng(), Answers()
    mesh, h = softbody.icosphere(1, 0.5), 1e-3
    squares = float((edge_lengths(mesh.vertices, mesh.edges) ** 2).sum())
    for trial in range(run.count(12, 60, 600)):
        bodies, stiffness, gas = int(rng.integers(1, 4)), rng.uniform(50.0, 200.0), rng.uniform(1.0, 20.0)
        hit, sizes = trial % bodies, 0.5 * 10.0 ** rng.uniform(-0.5, 0.5, bodies)
        sizes[hit] = 0.5
        longest = 1e3 * np.sqrt(squares) * (0.5 + np.sqrt(0.25 + 3.0 * gas / (stiffness * squares)))
        factor = rng.choice([rng.uniform(0.5, 0.99), rng.uniform(1.01, 3.0)])
        thrown, twin = (World(gravity=(0.0, 0.0, 0.0), split_steps=False) for _ in range(2))
        for one in (thrown, twin):
            for k, size in enumerate(sizes):
                place = (0.0, 0.0, 0.0) if k == hit else (0.0, 2e5 * (k + 1), 0.0)
                one.add_soft_body(softbody.icosphere(1, size), 1.0, stiffness, gas, place)
            one.add_box((1e5, 1e5, 1e5), None, (5e4 + 0.5, 0.0, 0.0), velocity=(-factor * longest / h, 0.0, 0.0))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", softbody.OverlapWarning)  # the wall has gone far into the ball
            error = error_of(SimulationError, thrown.step, h, allow_unstable=True)
        if error:
            is_named = (error.body, error.step) == (f"soft body {hit}", 0)
            is_so = factor > 1.0 and is_named and same(thrown, twin) and not len(thrown.contact_points())
        else:
            far = float(np.abs(thrown.soft_bodies[hit].positions - mesh.vertices).max())
            is_so = factor < 1.0 and abs(far / (factor * longest) - 1.0) < 1e-3
        answers.add(is_so, True, kind="too far" if factor > 1.0 else "hardly")
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.World.step, softbody.World.contact_points",
    reference="a twin that was not stepped any more",
    kind="specification",
    because="the same bits",
    faults=(
        Fault("impulses of the step before", runner.Runner.step, "store.contents.ground_impulse[:] = 0.0 → "),
        Fault("a clock that goes on", step.run_alone_by_clock, "done += made → done += left"),
    ),
)
def nothing_touches_after_a_fault(run: Run) -> Comparison:
    """After a step that fails, all is as before and nothing touches.

    A ball that lies on the ground is thrown apart: its state, time and number of steps are those of before, to the bit.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(6, 20, 200)):
        failing, twin = World(), World()
        scatter = rng.normal(size=(42, 3))
        for one in (failing, twin):
            one.add_ground()
            ball = one.add_soft_body(softbody.icosphere(1, 0.5), 1.0, 100.0, 10.0, (0.0, 0.0, 0.45))
            one.step(1e-3, 5)
            answers.add(len(one.contact_points()) > 0, True)
            ball.velocities = 1e8 * scatter
        error = error_of(SimulationError, failing.step, 1e-3, 1 + trial % 3, allow_unstable=True)
        answers.add(error is not None and same(failing, twin), True)
        answers.add(len(failing.contact_points()) == 0, True)
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.World.step, softbody.collision.solver.warm_start.copy_cache",
    reference="a twin that was not stepped any more",
    kind="specification",
    because="the same bits",
    faults=(
        Fault(
            "impulses of a part that is undone",
            warm_start.copy_cache,
            "store(cache_.impulse, k_, load(source_.impulse, k_)) → ",
        ),
        Fault("a solver that remembers what is undone", step.run, "copy_cache(c_, contacts.cache) → pass", nth=1),
    ),
)
def parts_of_a_failed_step_are_undone(run: Run) -> Comparison:
    """A step that fails in a later part has not happened.

    A box lies on a plate so thin that gravity parts the step. In the second part or a later one a ball collapses that
    is far away. All is as before, to the bit, also what the solver remembers of the boxes.
    """
    rng, answers, h = run.fresh_rng(), Answers(), 0.01
    for _ in range(run.count(6, 20, 200)):
        thick, masses = rng.uniform(5e-4, 2e-3), np.exp(rng.uniform(-1.0, 1.0, 2))
        parts = int(np.ceil(h * np.sqrt(9.81 / (0.0625 * thick))))
        when = h * (rng.integers(2, parts + 1) - 0.5) / parts  # in the midst of a part
        failing, twin = World(), World()
        for one in (failing, twin):
            one.add_ground()
            one.add_box((0.3, 0.3, thick), masses[0], (0.0, 0.0, 0.5 * thick))
            one.add_box((0.2, 0.2, 0.1), masses[1], (0.0, 0.0, thick + 0.05))
            ball = one.add_soft_body(softbody.icosphere(0, 0.3), 1.0, 10.0, 0.1, (0.0, 0.0, 9.0), deflated_below=0.5)
            one.step(h, 4)
            inwards = ball.positions.mean(axis=0) - ball.positions
            ball.velocities = (1.0 - 0.5 ** (1.0 / 3.0)) / when * inwards
        error = error_of(SimulationError, failing.step, h, allow_unstable=True)
        answers.add(error is not None and error.body == "soft body 0", True, kind="fails")
        answers.add(same(failing, twin), True, kind="undone")
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.stepping.step.run",
    reference="a twin that nobody has told to stop",
    kind="specification",
    because="the same bits",
    faults=(
        Fault("half a step that counts", step.step, "fault or done == 0 → fault"),
        Fault("a step counts that some have not made", move_in_place, "memory.done.min() // settings.substeps → 1"),
        Fault("stops that are not heard", step.run, "work.stop[0] != 0 → False"),
        Fault(
            "haste where there is none",
            step.step,
            "move_in_place(b_, m_, s_, h_, abort_mid_step) → move_in_place(b_, m_, s_, h_, True)",
        ),
    ),
)
def stopped_in_its_midst(run: Run) -> Comparison:
    """A run told to stop goes on to the same bits.

    It ends after one step or, in haste, in its midst, with all as it was: state, clock, and what the solver remembers.
    It goes on to the bits of a world that nobody has told to stop.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(3, 10, 100)):
        seed = int(rng.integers(2**31))
        stopped, twin = (rich_world(np.random.default_rng(seed)) for _ in range(2))
        h = 0.5 * twin.stable_time_step()
        before = int(rng.integers(20, 60))
        for one in (stopped, twin):
            one.step(h, before)
        struck = InterruptFlag(np.ones(1, np.uint8))
        for abort_mid_step in (True, False, True):
            model, controls, state, *_ = stopped.store.parts
            work = stopped.runner.memory.work(struck)
            order = step.Order(h, 7, stopped.steps, stopped.time, True, abort_mid_step)
            how = stopped.store.settings._replace(substeps=SUBSTEPS), stopped.store.clock, order
            fault, _ = step.run(model, controls, state, work, stopped.store.contacts, *how)
            if not abort_mid_step:
                twin.step(h, substeps=SUBSTEPS)
            is_so = [fault == 0, stopped.steps == twin.steps, same(stopped, twin)]
            answers.extend(is_so, [True] * 3, kind="in haste" if abort_mid_step else "after a step")
        for one in (stopped, twin):
            one.step(h, 10)
        answers.add(same(stopped, twin), True, kind="going on")
    return answers.comparison()


def _read(file: int) -> bytes:
    """Return what was written to a file, perhaps nothing."""
    try:
        return os.read(file, 100)
    except BlockingIOError:
        return b""


class _StopError(Exception):
    """What a handler of signals raises."""


@check(
    section="beyond the paper",
    piece="softbody.stepping.step.run_alone, softbody.dynamics.soft_bodies.move_body",
    reference="the look itself, which is after 32 steps; a twin that takes as many steps by itself",
    kind="specification",
    because="the same bits",
    faults=(
        Fault("a run that is left after a look, and forgotten", move_body, "made < 0 → made <= 0"),
        Fault("runs that are forgotten", integrators._advance_body, "steps = step → steps = -1"),
    ),
)
def stopped_after_a_look(run: Run) -> Comparison:
    """A run that is stopped in haste forgets no step.

    Stopped by another thread, in the midst of some step after the first look at its body, it has done all before it.
    """
    rng, answers = run.fresh_rng(), Answers()
    worlds, motions = (World(integrator="rk4"), World(integrator="rk4")), []  # steps of four stages
    for one in worlds:
        one.add_soft_body(softbody.icosphere(4, 0.5), 1.0, 100.0, 10.0, velocity=(0.0, 0.0, 3.0))
        motions.append(soft_bodies.motion_of(one.model.soft_particle_start, one.store.rings))
    (stopped, twin), (memory, _) = worlds, (each.memory for each in motions)

    def wait_and_stop(turns: int) -> None:
        while np.isnan(memory.position[-1, 2]):
            time.sleep(0.0)
        for _ in range(turns):  # up to some tenths of a millisecond, as a step takes: it may be in any part of one
            pass
        memory.stop[0] = 1

    def moved(k: int, steps: int) -> int:
        what = worlds[k].model, worlds[k].controls, worlds[k].state, motions[k], worlds[k].store.settings
        return step.run_alone(*what, 1e-6, steps, True)[0]

    moved(0, 1)  # the kernel is ready
    moved(1, 1)
    for _ in range(run.count(16, 60, 600)):
        memory.position[:], memory.stop[0] = np.nan, 0
        somebody = threading.Thread(target=wait_and_stop, args=(int(rng.integers(5_000)),))
        somebody.start()
        done = moved(0, 500)
        memory.position[-1, 2] = 0.0  # nobody waits any longer
        somebody.join()
        moved(1, done)
        answers.add(done >= 32 and stopped.state_hash() == twin.state_hash(), True)
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.World.step",
    reference="the documentation; Python's `signal.set_wakeup_fd`; a twin that does as many steps by itself",
    kind="specification",
    faults=(
        Fault("nobody listens", runner.Runner._listening, "self._threads == 1 and work < WORTH_LISTENING → True"),
        Fault("a file that is not put back", interrupts.listening, "before != flag.file → False"),
        Fault("others who are not told", InterruptFlag.clear, "os.write(f_, n_) → "),
        Fault("a file of number 0 that counts as none", InterruptFlag.clear, "self.others >= 0 → self.others > 0"),
    ),
)
def signals_are_heard(run: Run) -> Comparison:
    """A signal in a long run is heard before it ends.

    Of 50 000 particle steps and more; a handler that raises leaves a world of whole steps. Who was told of signals by a
    file of his own, of number 0 or any other, is told of those meanwhile, and afterwards.
    """

    def ring(number: int, frame: FrameType | None) -> None:
        raise _StopError

    heard, twin = (soft(mesh=softbody.icosphere(3, 0.5)) for _ in range(2))
    for one in (heard, twin):
        one.step(1e-5, 2)
    answers, many = Answers(), 40_000
    read, write = os.pipe()
    for end in (read, write):
        os.set_blocking(end, False)
    handler, told, stdin = signal.signal(signal.SIGALRM, ring), signal.set_wakeup_fd(write), os.dup(0)
    os.dup2(write, 0)
    try:
        for trial in range(run.count(2, 4, 20)):
            file = (write, 0)[trial % 2]
            signal.set_wakeup_fd(file)
            signal.setitimer(signal.ITIMER_REAL, 0.02)
            before = heard.steps
            stop = error_of(_StopError, heard.step, 1e-5, many)
            answers.add(stop is not None and heard.steps - before < many, True)
            twin.step(1e-5, heard.steps - before)
            answers.extend([same(heard, twin), _read(read) == bytes([signal.SIGALRM])], [True] * 2)
            for one in (heard, twin):
                one.step(1e-5, 100)
            answers.add(signal.set_wakeup_fd(write) == file, True)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, handler)
        signal.set_wakeup_fd(told)
        os.dup2(stdin, 0)
        for end in (stdin, read, write):
            os.close(end)
    return answers.comparison()
