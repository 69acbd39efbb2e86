"""Is an interrupt heard in the midst of a long run, and is what it leaves a whole world?"""

import linecache
import os
import signal
import sys
import threading
import time
from contextlib import contextmanager, suppress
from functools import partial
from itertools import count

import numba
import numpy as np
import pytest
from numba.core.caching import NullCache

import softbody
from softbody import BusyError, Trajectory, TrajectoryWriter, World
from softbody.bodies.adding import remove
from softbody.bodies.store import Store
from softbody.compiler import core_cache
from softbody.compiler.interrupts import NEVER_SET, assign_together, later, listening, set_together
from softbody.compiler.jit import _knows_numba, jit
from softbody.dynamics.vertex_rings import one_rings
from softbody.linalg.vec import norm
from softbody.storage.restore import restore
from tests.same_bits import same_bits

compiled = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="Python handles signals anywhere in its own code")
posix = pytest.mark.skipif(os.name != "posix", reason="signals and timers are those of POSIX")

known = pytest.mark.skipif(not _knows_numba(), reason="Numba's public decorator compiles as Numba does")


class StopError(Exception):
    """What a handler raises in place of a KeyboardInterrupt."""


@pytest.fixture
def alarm():
    """Return how to let the alarm go off after some seconds [s] of work, which raises a StopError.

    It goes off once more after 30 s: what is raised in a finalizer, Python swallows, and a run might never end.
    """

    def ring(*_):
        raise StopError

    before = signal.signal(signal.SIGPROF, ring)
    yield lambda seconds: signal.setitimer(signal.ITIMER_PROF, seconds, 30.0)
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    signal.signal(signal.SIGPROF, before)


def ball():
    world = World()
    world.add_ground()
    world.add_soft_body(softbody.icosphere(2, 0.5), 1.0, 200.0, 30.0, (0.0, 0.0, 0.6))
    return world


def boxes():
    world = World()
    world.add_ground()
    for k in range(3):
        world.add_box((1.0, 1.0, 0.5), 1.0, (0.05 * k, 0.0, 0.25 + 0.51 * k))
    return world


@posix
@compiled
@pytest.mark.parametrize("build", [ball, boxes])
@pytest.mark.parametrize("call", ["step", "run"])
def test_a_long_run_is_interrupted_and_leaves_the_world_of_the_steps_that_it_has_made(alarm, build, call):
    world, other = build(), build()
    for each in (world, other):
        each.step(1e-4)  # compiled
    begun = time.process_time()
    alarm(0.05)
    with pytest.raises(StopError):
        world.step(1e-4, 10**9) if call == "step" else world.run(1e5, 1e-4)
    assert time.process_time() - begun < 0.5
    assert 1 < world.steps < 10**9
    other.step(1e-4, world.steps - 1)
    assert (world.time, same_bits(world, other)) == (other.time, True)
    for each in (world, other):
        each.step(1e-4, 100)
    assert same_bits(world, other)


@posix
@compiled
def test_a_handler_that_raises_nothing_lets_the_run_go_on_to_the_same_bits():
    world, other, came = ball(), ball(), []
    before = signal.signal(signal.SIGPROF, lambda *_: came.append(1))
    signal.setitimer(signal.ITIMER_PROF, 0.01, 0.01)
    try:
        while len(came) < 5:
            world.step(1e-4, 500)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
    for _ in range(world.steps // 500):
        other.step(1e-4, 500)
    assert world.time == other.time
    assert same_bits(world, other)


def balls_and_a_box():
    world = ball()
    world.add_soft_body(softbody.icosphere(2, 0.5), 1.0, 200.0, 30.0, (0.0, 0.0, 1.65))
    world.add_box((1.0, 1.0, 0.5), 1.0, (0.0, 0.0, 2.5))
    return world


@posix
@compiled
@pytest.mark.parametrize("build", [ball, balls_and_a_box])
@pytest.mark.parametrize("threads", [1, 2])
def test_a_step_that_takes_long_is_left_in_its_midst_and_has_not_happened(alarm, build, threads):
    world, other = build(), build()
    world.threads = threads
    h = 0.3 * world.stable_time_step()
    for each in (world, other):
        each.step(h, 2)
    contacts, depth = world.store.contacts.number.tolist(), world.store.contacts.depth.copy()
    alarm(0.2)
    with pytest.raises(StopError):
        world.step(400_000 * h, substeps=400_000, allow_unstable=True)
    assert (world.steps, same_bits(world, other)) == (2, True)
    assert world.store.contacts.number.tolist() == contacts
    assert world.store.contacts.depth.tobytes() == depth.tobytes()  # rows beyond their number hold anything
    for each in (world, other):
        each.step(h, 3)
    assert same_bits(world, other)


@posix
@compiled
@pytest.mark.parametrize("build", [ball, balls_and_a_box])
def test_signals_that_come_more_often_than_steps_end_do_not_keep_a_world_from_going_on(build):
    world, other = build(), build()
    h = 0.0003 * world.stable_time_step()  # a step takes many signals long on any machine
    for each in (world, other):
        each.step(h, substeps=2)  # compiled
    heard = []
    before = signal.signal(signal.SIGPROF, lambda *_: heard.append(world.steps))
    try:
        signal.setitimer(signal.ITIMER_PROF, 0.004, 0.004)
        world.step(10_000 * h, 3, substeps=10_000)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
    other.step(10_000 * h, 3, substeps=10_000)
    assert heard[0] == 1
    assert (world.steps, same_bits(world, other)) == (4, True)


@posix
@compiled
def test_an_equilibrium_that_is_interrupted_moves_nobody(alarm):
    world = World()
    for k in range(2):
        world.add_soft_body(softbody.icosphere(3), 1.0, 50.0, 20.0, (3.0 * k, 0.0, 0.0), (1.0, 0.0, 0.0), fixed=[0])
    before = world.state_hash()
    alarm(0.02)
    with pytest.raises(StopError):
        world.equilibrium(1e-300, 10**9)
    assert world.state_hash() == before


def stopped_at(line, call):
    """Call, and raise before the line of that number, counted as they run, of the core's host side; tell if it was.

    Not where a with-statement begins and ends: there Python handles no signal.
    """
    left = [line]
    host = restore, remove, Store.exclusive, Trajectory.put_into, set_together
    files = {function.__code__.co_filename for function in host}

    def each(frame, event, _):
        source = linecache.getline(frame.f_code.co_filename, frame.f_lineno)
        if event == "line" and not source.strip().startswith("with "):
            left[0] -= 1
            if left[0] == 0:
                raise StopError
        return each

    before = sys.gettrace()
    sys.settrace(lambda frame, *_: each if frame.f_code.co_filename in files else None)
    try:
        call()
    except StopError:
        return True
    finally:
        sys.settrace(before)
    return False


def test_a_restore_that_is_interrupted_anywhere_has_happened_or_has_not():
    first, then = ball(), boxes()
    then.store.settings = then.store.settings._replace(iterations=7)
    first.step(1e-4, 3)
    then.step(1e-4, 2)
    snapshot, line, seen = then.snapshot(), 1, set()
    while True:
        world = World()
        world.restore(first.snapshot())
        if not stopped_at(line, lambda world=world: world.restore(snapshot)):
            break
        is_before, is_after = same_bits(world, first), same_bits(world, then)
        assert is_before != is_after, line
        seen.add(is_after)
        line += 1
    assert seen == {False}  # what assigns is one line, and the last
    assert line > 15
    assert same_bits(world, then)


def test_a_removal_that_is_interrupted_anywhere_has_happened_or_has_not():
    line, seen = 1, set()
    while True:
        world = boxes()
        handles = world.boxes
        count = len(handles)
        if not stopped_at(line, lambda world=world, box=handles[0]: world.remove(box)):
            break
        is_there = [box.is_there for box in handles]
        assert world.model.box_count == sum(is_there)
        assert [box.index for box in handles if box.is_there] == list(range(sum(is_there)))
        seen.add(sum(is_there) == count)
        line += 1
    assert seen == {True}
    assert line > 5


def test_a_world_that_is_put_where_it_was_has_the_time_of_then(tmp_path):
    world = ball()
    with TrajectoryWriter(world, tmp_path / "t") as kept:
        kept.frame()
        world.step(1e-4, 5)
        kept.frame()
    trajectory = Trajectory.open(tmp_path / "t")
    first, last = trajectory[0], trajectory[1]
    line = 1
    while stopped_at(line, lambda: trajectory.put_into(world, 0)):
        is_last = np.array_equal(world.state.particle_position, last.positions)
        assert (is_last, world.time) == (True, last.time), line
        line += 1
    assert np.array_equal(world.state.particle_position, first.positions)
    assert world.time == first.time
    assert line > 3


def test_attributes_are_set_together():
    class Pair:
        one, other = 1, 2

    pair = Pair()
    set_together((pair, "one", 3), (pair, "other", 4))
    assert (pair.one, pair.other) == (3, 4)


@posix
def test_signals_set_the_flag_and_whoever_else_listens_is_told():
    ours, theirs = os.pipe()
    os.set_blocking(theirs, False)
    handled = []
    before = signal.signal(signal.SIGUSR1, lambda *_: handled.append(1))
    others = signal.set_wakeup_fd(theirs)
    try:
        with listening() as flag:
            assert flag.is_set[0] == 0
            signal.raise_signal(signal.SIGUSR1)
            assert flag.is_set[0] != 0
            flag.clear()
            assert flag.is_set[0] == 0
            signal.raise_signal(signal.SIGUSR1)
        assert os.read(ours, 10) == bytes([signal.SIGUSR1] * 2)
        signal.raise_signal(signal.SIGUSR1)
        assert os.read(ours, 10) == bytes([signal.SIGUSR1])
    finally:
        signal.set_wakeup_fd(others)
        signal.signal(signal.SIGUSR1, before)
        os.close(ours)
        os.close(theirs)
    assert len(handled) == 3


@posix
def test_others_who_do_not_read_what_they_are_told_stop_nobody():
    ours, theirs = os.pipe()
    os.set_blocking(theirs, False)
    before, others = signal.signal(signal.SIGUSR1, lambda *_: None), signal.set_wakeup_fd(theirs)
    try:
        for size in (1000, 1):
            with suppress(BlockingIOError):
                while True:
                    os.write(theirs, bytes(size))
        with listening() as flag:
            signal.raise_signal(signal.SIGUSR1)
            flag.clear()
            assert flag.is_set[0] == 0
    finally:
        signal.set_wakeup_fd(others)
        signal.signal(signal.SIGUSR1, before)
        os.close(ours)
        os.close(theirs)


@posix
def test_a_signal_that_comes_while_the_flag_is_cleared_does_not_make_it_deaf(monkeypatch):
    ours, theirs = os.pipe()
    os.set_blocking(theirs, False)
    before, others = signal.signal(signal.SIGUSR1, lambda *_: None), signal.set_wakeup_fd(theirs)
    usual = {name: getattr(os, name) for name in ("lseek", "pread", "write", "ftruncate")}
    try:
        for at in count():
            calls = []
            with listening() as flag:
                signal.raise_signal(signal.SIGUSR1)

                def strike(name, *given, calls=calls, at=at):
                    calls.append(name)
                    if len(calls) == at + 1:
                        signal.raise_signal(signal.SIGUSR1)
                    return usual[name](*given)

                for name in usual:
                    monkeypatch.setattr(os, name, partial(strike, name))
                flag.clear()
                monkeypatch.undo()
                flag.clear()
                assert flag.is_set[0] == 0
                signal.raise_signal(signal.SIGUSR1)
                assert flag.is_set[0] == signal.SIGUSR1, f"deaf after one before {calls[at]}"
            assert os.read(ours, 10) == bytes([signal.SIGUSR1] * (2 + (len(calls) > at)))  # others are told of all
            if len(calls) <= at:
                break
        assert at == 5
    finally:
        signal.set_wakeup_fd(others)
        signal.signal(signal.SIGUSR1, before)
        os.close(ours)
        os.close(theirs)


def test_nobody_listens_in_other_threads():
    heard = []

    def elsewhere():
        with listening() as flag:
            heard.append(flag)

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert heard == [NEVER_SET]


def test_arrays_are_assigned_together():
    a, b = np.zeros((2, 3)), np.ones(2)
    assign_together((a, 5.0), (b, [3.0, 4.0]))
    assert a.tolist() == [[5.0] * 3] * 2
    assert b.tolist() == [3.0, 4.0]


def test_a_world_that_is_being_stepped_says_so_and_is_not_torn():
    world, errors = ball(), []
    world.step(1e-4)
    (body,) = world.soft_bodies
    hold = world.add_joint((body, 0), (0.0, 0.0, 2.0), 0.0)
    calls = [
        lambda: world.step(1e-4),
        lambda: world.run(1.0, 1e-4),
        lambda: world.add_box((1.0, 1.0, 1.0), 1.0),
        lambda: world.add_soft_body(softbody.octahedron(), 1.0, 1.0, 1.0),
        world.add_ground,
        world.equilibrium,
        world.snapshot,
        lambda: world.restore({}),
        lambda: setattr(body, "friction", 0.1),
        lambda: setattr(body, "fixed", [0]),
        lambda: setattr(body, "external_force", (0.0, 0.0, 1.0)),
        lambda: body.set_springs(10.0),
        lambda: setattr(hold, "stiffness", 1.0),
    ]
    with world.store.exclusive():  # as `step` does, on whatever thread
        for call in calls:
            with pytest.raises(BusyError, match="being stepped") as caught:
                call()
            errors.append(caught)
    assert len(errors) == len(calls)
    world.step(1e-4)
    assert (world.steps, world.model.soft_count, world.model.box_count) == (2, 1, 0)


@compiled
def test_four_threads_that_step_one_world_take_turns_or_are_told():
    world, other, told, done = ball(), ball(), [], []

    def go():
        for _ in range(40):
            try:
                world.step(1e-4, 10)
                done.append(1)
            except BusyError as error:
                told.append(error)

    threads = [threading.Thread(target=go) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert world.steps == 10 * len(done)
    for _ in done:
        other.step(1e-4, 10)
    assert same_bits(world, other)
    assert len(told) + len(done) == 160


@posix
@compiled
def test_what_a_handler_raises_while_a_kernel_makes_arrays_leaves_as_itself():
    mesh = softbody.icosphere(4)
    triangles = mesh.triangles.copy()
    one_rings(len(mesh.vertices), triangles)  # compiled

    def ring(*_):
        raise StopError

    before, heard = signal.signal(signal.SIGALRM, ring), 0
    try:
        for k in range(300):
            try:
                signal.setitimer(signal.ITIMER_REAL, 1e-5 * (1 + k % 100))
                for _ in range(100):
                    one_rings(len(mesh.vertices), triangles)
            except StopError:
                heard += 1
            finally:
                signal.setitimer(signal.ITIMER_REAL, 0.0)
    finally:
        signal.signal(signal.SIGALRM, before)
    assert heard > 200


def new_kernel():
    """Return a kernel that nobody has compiled, of two that are as new: the sum of the squares below n, and n."""

    @jit
    def square(x):
        return x * x

    @jit
    def squares(n):
        found = 0.0
        for k in range(n):
            found += square(k)
        return found

    @jit
    def kernel(n):
        return squares(n), n

    return kernel


@contextmanager
def at_calls(seen):
    """Have `seen` called with each Python function that is called in the block: with its code."""
    before = sys.gettrace()
    sys.settrace(lambda frame, *_: seen(frame.f_code))
    try:
        yield
    finally:
        sys.settrace(before)


@posix
@compiled
@known
def test_what_comes_while_a_kernel_compiles_or_is_loaded_is_handled_between_two_steps_of_that(tmp_path, monkeypatch):
    """What is raised in Numba's own functions spoils Numba for the process, and in LLVM's calls nobody hears it."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(core_cache, "_folders", lambda function: [])  # another test may have kept it beside the sources
    delicate, came, handled_by = {"stream_list", "load_overload", "_raw_object_cache_notify"}, set(), set()

    def interrupt(code):
        if code.co_name in delicate:
            came.add(code.co_name)
            signal.raise_signal(signal.SIGPROF)

    before = signal.signal(signal.SIGPROF, lambda *_: handled_by.add(sys._getframe(1).f_code.co_name))
    try:
        for hits in range(2):
            kernel = jit(norm.py_func)
            with at_calls(interrupt):
                assert kernel((3.0, 4.0, 0.0)) == 5.0
            assert sum(kernel.stats.cache_hits.values()) == hits
    finally:
        signal.signal(signal.SIGPROF, before)
    assert (came, handled_by) == (delicate, {"hear"})


@posix
@compiled
@known
def test_a_kernel_whose_compiling_was_interrupted_compiles_when_it_is_called_again(alarm):
    for turn in count(1):
        kernel, left = new_kernel(), [turn]
        kernel._cache = NullCache()

        def interrupt(code, left=left):
            if code.co_name == "hear":
                left[0] -= 1
                if left[0] == 0:
                    signal.raise_signal(signal.SIGPROF)

        try:
            with at_calls(interrupt):
                kernel(4)
            break
        except StopError:
            assert kernel(4) == (14.0, 4)
    assert turn > 7


@posix
def test_what_comes_while_others_work_is_handled_later(alarm):
    told = []

    def work():
        with later():
            signal.raise_signal(signal.SIGPROF)
            told.append("worked on")
        told.append("never")

    with pytest.raises(StopError):
        work()
    assert told == ["worked on"]
    with pytest.raises(StopError):  # the handler is back
        signal.raise_signal(signal.SIGPROF)


@posix
def test_what_has_come_is_handled_in_the_midst_of_work_where_that_asks_for_it(alarm):
    told = []

    def work():
        with later() as hear:
            hear()
            signal.raise_signal(signal.SIGPROF)
            told.append("worked on")
            hear()
            told.append("never")

    with pytest.raises(StopError):
        work()
    assert told == ["worked on"]


@posix
def test_a_handler_that_raises_while_others_are_put_back_leaves_them_heard(alarm, monkeypatch):
    def ring(*_):
        raise KeyError

    put = signal.signal
    before = put(signal.SIGUSR1, ring)

    def interrupted(number, handler):
        put(number, handler)
        if handler is ring:  # its number is less than the alarm's
            signal.raise_signal(signal.SIGUSR1)

    try:
        with pytest.raises(KeyError), later():
            monkeypatch.setattr(signal, "signal", interrupted)
        with pytest.raises(StopError):
            signal.raise_signal(signal.SIGPROF)
    finally:
        put(signal.SIGUSR1, before)


@posix
def test_what_is_raised_by_others_gives_way_to_an_interrupt(alarm):
    @later()
    def work():
        signal.raise_signal(signal.SIGPROF)
        raise ValueError

    with pytest.raises(StopError) as caught:
        work()
    assert isinstance(caught.value.__context__, ValueError)


def test_in_another_thread_nothing_is_put_off():
    done = []

    def work():
        with later():
            done.append(True)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert done == [True]


@posix
def test_an_interrupt_that_trimesh_would_swallow_is_heard(alarm, tmp_path, monkeypatch):
    trimesh = pytest.importorskip("trimesh")
    made = trimesh.visual.material.PBRMaterial

    def swallowing(**given):
        try:
            signal.raise_signal(signal.SIGPROF)
        except BaseException:
            given = {}
        return made(**given)

    monkeypatch.setattr(trimesh.visual.material, "PBRMaterial", swallowing)
    world = World()
    world.add_box((1.0, 1.0, 1.0), 1.0)
    with pytest.raises(StopError):
        world.export(tmp_path / "a.glb")
    assert not os.listdir(tmp_path)
