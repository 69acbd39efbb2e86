"""Do worlds get the threads that they ask for, leave them as they were, and the environment too?"""

import os

import numba
import pytest

import softbody
from softbody.compiler.threads import WAITING, Team, team_of
from softbody.geometry import MeshQuery
from softbody.scenes import tray

several = pytest.mark.skipif(
    numba.config.DISABLE_JIT or numba.config.NUMBA_NUM_THREADS < 2, reason="there is one thread here"
)


@several
def test_a_team_is_as_large_as_asked_and_is_put_back():
    before = numba.get_num_threads()
    with team_of(2):
        assert numba.get_num_threads() == 2
    assert numba.get_num_threads() == before
    with pytest.raises(ZeroDivisionError), team_of(2):
        _ = 1 / 0
    assert numba.get_num_threads() == before


@several
@pytest.mark.parametrize("chosen", [{}, {"OMP_WAIT_POLICY": "active"}, {"GOMP_SPINCOUNT": "7"}])
def test_the_environment_is_left_as_it_was(monkeypatch, chosen):
    for name in WAITING:
        monkeypatch.delenv(name, raising=False)
    for name, value in chosen.items():
        monkeypatch.setenv(name, value)
    with team_of(2):
        assert {name: os.environ[name] for name in WAITING if name in os.environ} == chosen
    assert {name: os.environ[name] for name in WAITING if name in os.environ} == chosen


@several
def test_a_crowd_goes_on_to_the_same_bits_when_threads_change_between_steps():
    worlds = [tray.build(24) for _ in range(2)]
    step = 0.9 * worlds[0].stable_time_step()
    for threads in (2, 1, 2):
        worlds[1].threads = threads
        for world in worlds:
            world.step(step, 60)
    assert worlds[0].store.contacts.number[0] > 0
    assert worlds[0].state_hash() == worlds[1].state_hash()


@several
def test_a_body_added_between_steps_is_found_by_all_threads():
    hashes = []
    for threads in (1, 2):
        world = softbody.World(threads=threads)
        for k in range(3):
            world.add_soft_body(softbody.icosphere(2, 0.5), 1.0, 100.0, 20.0, (0.0, 0.1 * k, 0.99 * k))
            world.step(1e-4, 5)
        hashes.append(world.state_hash())
    assert hashes[0] == hashes[1]


@several
@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
def test_a_process_forked_off_one_with_threads_says_that_it_has_none():
    with team_of(2):
        pass
    child = os.fork()
    if not child:  # whatever happens, it must not go on with the tests
        code = 1
        try:
            with team_of(1):
                code = 2
            try:
                with team_of(2):
                    code = 3
            except softbody.ParameterError as error:
                code = 0 if "forked" in str(error) and "spawn" in str(error) else 4
        finally:
            os._exit(code)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


@several
def test_more_threads_than_there_are_are_refused_with_the_number_that_there_is():
    for value in (numba.config.NUMBA_NUM_THREADS + 1, 10**6, 10**400):
        with pytest.raises(softbody.ParameterError, match=r"threads is .* give a (whole )?number"):
            softbody.World(threads=value)
    query = MeshQuery(softbody.octahedron().vertices, softbody.octahedron().triangles)
    with pytest.raises(softbody.ParameterError, match="threads is 1000000; give a whole number from 1 to"):
        query.contains([[0.0, 0.0, 0.0]], 10**6)


class Machine:
    """A machine whose clock goes by what steps are said to take, with one thread and with several."""

    def __init__(self) -> None:
        self.time = 0.0
        self.team = Team(4, lambda: self.time)

    def spend(self, seconds: float, one: float, all_of_them: float) -> float:
        """Run steps that take so long each [s], for so long; return the time it took over that of the faster ones."""
        begun, fastest = self.time, 0.0
        while self.time - begun < seconds:
            steps = self.team.turn(10**9)
            self.time += steps * (one if self.team.now == 1 else all_of_them)
            self.team.note(steps)
            fastest += steps * min(one, all_of_them)
        return (self.time - begun) / fastest


@pytest.mark.parametrize("slower", [1.0, 1.05, 1.5, 4.0, 20.0])
@pytest.mark.parametrize("step", [2e-6, 1e-4, 5e-3])
def test_a_team_costs_little_more_than_the_faster_number_of_threads(slower, step):
    for one, all_of_them in ((step, slower * step), (slower * step, step)):
        assert Machine().spend(200.0, one, all_of_them) < 1.05


def test_a_team_notices_when_the_machine_becomes_busy_and_free_again():
    machine = Machine()
    assert machine.spend(20.0, 1e-3, 6e-4) < 1.05
    assert machine.team.now == 4
    assert machine.spend(20.0, 1e-3, 2e-2) < 1.06  # a stint was lost before it was seen
    assert machine.team.now == 1
    machine.spend(20.0, 1e-3, 6e-4)
    assert machine.team.now == 4


def test_what_a_first_turn_took_to_compile_is_no_reason():
    machine = Machine()
    machine.time += machine.team.turn(16) * 10.0
    machine.team.note(16)
    assert machine.spend(20.0, 1e-3, 6e-4) < 1.05


def test_turns_of_a_step_a_call_are_taken_together():
    machine = Machine()
    for _ in range(20_000):
        assert machine.team.turn(1) == 1
        machine.time += 1e-4 if machine.team.now == 1 else 1e-3
        machine.team.note(1)
    assert machine.team.now == 1
    assert machine.time < 1.05 * 20_000 * 1e-4 + 1.0
