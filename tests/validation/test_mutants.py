"""Mutants are small, even and reproducible; what is seen of them is what claims measure; nothing is lost on the way."""

from __future__ import annotations

import ast
import subprocess
import textwrap
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

from softbody import World
from validation import switch
from validation.bench import ASLEEP, CRASHED, GREEN, HUNG, MEASURED, Bench, seen_of
from validation.check import Comparison, Run, all_checks
from validation.damaged_core import ROOT
from validation.mutation import sample
from validation.mutation.core import LEFT_OUT, all_mutants, is_left_out, mutants_at, mutated, write_core
from validation.mutation.explained import EXPLAINED, Reason, explained_in
from validation.mutation.results import KILLED, STILLBORN, SURVIVED, Fate, Ledger, counted, share_seen, write_summary
from validation.mutation.sample import changed_functions, in_fair_order
from validation.mutation.sites import Mutant, mutants_in
from validation.mutation.trials import culprits
from validation.record import BROKEN, FAILS, HOLDS
from validation.trace import traced

SOURCE = '''
def clamp(x: float, low: float, high: float) -> tuple[float, float]:
    """Text with a number, 1, is no site."""
    total = 0.0
    for k in range(3):
        total += x * low / 2.0
        if x <= low and not high > 5.0:
            continue
    x = max(-x, rows[k, 1])
    if mode is None:
        raise ValueError(f"{x + 1}")
    return total, x
'''


def changes(source: str, **names: Any) -> list[str]:
    """What the mutants of a module change, as "before -> after"."""
    found = [each for each, _, _ in mutants_in("toy.py", ast.parse(textwrap.dedent(source)), names)]
    return [each.key.partition(": ")[2] for each in found]


@pytest.mark.parametrize(
    "change",
    [
        "x * low / 2.0 -> x * low * 2.0",
        "x * low -> x / low",
        "x <= low -> x < low",
        "high > 5.0 -> high >= 5.0",
        "not high > 5.0 -> high > 5.0",
        "x <= low and (not high > 5.0) -> x <= low or not high > 5.0",
        "x <= low and (not high > 5.0) -> not (x <= low and (not high > 5.0))",
        "-x -> x",
        "max(-x, rows[k, 1]) -> min(-x, rows[k, 1])",
        "rows[k, 1] -> rows[k, 0]",
        "0.0 -> 1.0",
        "2.0 -> 2.02",
        "3 -> 4",
        "continue -> nothing",
        "total += x * low / 2.0 -> nothing",
        "total += x * low / 2.0 -> total -= x * low / 2.0",
        "x = max(-x, rows[k, 1]) -> nothing",
        "(total, x) -> (x, total)",
    ],
)
def test_every_operator_has_its_sites(change: str) -> None:
    assert change in changes(SOURCE)


def test_texts_errors_and_what_numba_settles_are_no_sites() -> None:
    found = changes(SOURCE)
    assert [each for each in found if "x + 1" in each] == ["raise ValueError(f'{x + 1}') -> nothing"]
    assert not [each for each in found if "None" in each or "Text" in each]


def test_arguments_of_one_type_change_places_and_names_of_numbers_are_numbers() -> None:
    def length(width: float, height: float, count: int) -> float:
        return width * height * count

    length.__annotations__ = {"width": "float", "height": "float", "count": "int"}
    found = changes("def f(a, b):\n    return length(a, b * LIMIT, 3)", length=length, LIMIT=0.5)
    assert "length(a, b * LIMIT, 3) -> length(b * LIMIT, a, 3)" in found
    assert "length(a, b * LIMIT, 3) -> length(a, 3, b * LIMIT)" not in found
    assert "LIMIT -> LIMIT * 1.01" in found


def test_a_key_outlives_a_shift_of_lines_and_tells_equal_changes_apart() -> None:
    moved = f"HERE = 1\n\n{SOURCE}\ndef other(x):\n    return x * x\n"
    assert set(changes(SOURCE)) <= set(changes(moved))
    assert {"x -> nothing #1"} & set(changes("def f(x):\n    g(x)\n    g(x)")) == set()
    assert changes("def f(x):\n    g(x)\n    g(x)") == ["g(x) -> nothing", "g(x) -> nothing #1"]


TOY = """
def area(width, height):
    half = width * height / 2.0
    if half > 0.0:
        half = half + width * height
    return half
"""


def awake(number: int) -> float:
    """What `area(3, 2)` is with all its mutants in it, one of them awake."""
    found = [each for each, _, _ in mutants_in("toy.py", ast.parse(TOY), {})]
    source = mutated("toy.py", TOY, {each.key: k for k, each in enumerate(found)}, {})
    scope: dict[str, Any] = {"noted_awake": lambda k: k == number}
    exec(source.replace("from softbody.switch import noted_awake", ""), scope)
    return float(scope["area"](3.0, 2.0))


def test_many_mutants_sleep_in_one_module_and_each_is_woken_alone() -> None:
    found = [each for each, _, _ in mutants_in("toy.py", ast.parse(TOY), {})]
    assert awake(ASLEEP) == 9.0
    answers = {each.key.partition(": ")[2]: awake(k) for k, each in enumerate(found)}
    assert answers["width * height / 2.0 -> width * height * 2.0"] == 18.0
    assert answers["width * height -> width / height"] == 6.75
    assert answers["width * height -> width / height #1"] == 4.5
    assert answers["half = half + width * height -> nothing"] == 3.0
    assert answers["half > 0.0 -> not half > 0.0"] == 3.0
    assert answers["half > 0.0 -> half >= 0.0"] == 9.0  # nobody can tell


def test_a_mutant_without_a_place_is_named() -> None:
    with pytest.raises(ValueError, match=r"there is no such mutant: toy\.py:area: gone"):
        mutated("toy.py", TOY, {"toy.py:area: gone": 0}, {})


def test_a_kernel_asks_the_switch_while_it_runs() -> None:
    noted_awake = switch.noted_awake

    def twice(x: float) -> float:
        return 3.0 * x if noted_awake(7) else 2.0 * x

    for form in (twice, numba.njit(twice)):
        switch.REACHED[7] = 0
        switch.AWAKE.value = ASLEEP
        assert form(1.0) == 2.0
        assert switch.REACHED[7] == 1
        switch.AWAKE.value = 7
        assert form(1.0) == 3.0
    switch.AWAKE.value = ASLEEP


def toy(file: str, number: int) -> Mutant:
    return Mutant(file, "f", "number", str(number), str(number + 1), number)


def test_any_part_of_the_order_is_an_even_sample() -> None:
    every = [toy("a.py", k) for k in range(300)] + [toy("b.py", k) for k in range(100)]
    order = in_fair_order(every, seed=1)
    assert sorted(order, key=str) == sorted(every, key=str)
    for count in (4, 40, 200):
        shares = Counter(each.file for each in order[:count])
        assert abs(shares["b.py"] - count / 4) <= 1
    assert order == in_fair_order(every, seed=1)
    assert order != in_fair_order(every, seed=2)


def test_functions_that_changed_since_a_revision_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    git = ["git", "-C", str(tmp_path), "-c", "user.name=n", "-c", "user.email=e"]
    file = tmp_path / "softbody" / "vec.py"
    file.parent.mkdir()
    file.write_text("def same():\n    return 1\n\ndef other():\n    return 1\n")
    for command in (["init", "-q"], ["add", "."], ["commit", "-q", "-m", "m"]):
        subprocess.run([*git, *command], check=True)
    file.write_text(
        'def same():\n    """Now with words."""\n    return 1\n\ndef other():\n    return 2\n\ndef new():\n    f()'
    )
    monkeypatch.setattr(sample, "ROOT", tmp_path)
    assert changed_functions("HEAD") == {("vec.py", "other"), ("vec.py", "new")}
    with pytest.raises(ValueError, match="Git knows no revision 'nowhere'"):
        changed_functions("nowhere")


def test_only_what_is_measured_counts_as_seen() -> None:
    assert seen_of(HOLDS, 6, "") == GREEN
    assert seen_of(FAILS, 6, "1 of 6 cases exceed the tolerance") == MEASURED
    assert seen_of(FAILS, 0, "raised SimulationError: soft body 0 diverged") == MEASURED
    assert seen_of(FAILS, 0, "raised ValueError: measured has shape (3,) and expected (4,)") == MEASURED
    assert seen_of(FAILS, 0, "raised IndexError: tuple index out of range") == CRASHED
    assert seen_of(BROKEN, 0, "pybullet raised error") == CRASHED


def test_fates_outlive_a_run_that_is_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "m.jsonl"
    ledger = Ledger(path, "a", 1, resume=False)
    ledger.note(Fate(toy("a.py", 1), KILLED, by="sat.depth", tried=["quick sat.depth 1"]))
    ledger.is_done(["quick sat.axes 1"], [toy("a.py", 1), toy("a.py", 3)])
    with path.open("a") as file:
        file.write('{"mutant": {"file"')
    again = Ledger(path, "b", 1, resume=True)
    assert (again.fate_of(toy("a.py", 1)).verdict, again.fate_of(toy("a.py", 1)).core) == (KILLED, "a")
    assert again.known(again.fate_of(toy("a.py", 1))) == {"quick sat.depth 1", "quick sat.axes 1"}
    assert again.known(again.fate_of(toy("a.py", 3))) == {"quick sat.axes 1"}
    assert again.fate_of(toy("a.py", 2)).verdict == SURVIVED
    changed = replace(toy("a.py", 1), text="another function")
    assert again.fate_of(changed).verdict == SURVIVED
    assert not again.known(again.fate_of(changed))
    with pytest.raises(ValueError, match="is of another seed"):
        Ledger(path, "a", 2, resume=True)


def test_what_is_explained_and_what_does_not_compile_are_counted_apart(tmp_path: Path) -> None:
    verdicts = [KILLED, SURVIVED, SURVIVED, SURVIVED, STILLBORN]
    fates = [Fate(toy("a.py", k), verdict) for k, verdict in enumerate(verdicts)]
    explained = {
        fates[1].mutant.key: Reason("nobody can tell", within=False),
        fates[2].mutant.key: Reason("as good", within=True),
        fates[0].mutant.key: Reason("seen after all", within=False),
    }
    totals = counted(fates, explained)
    assert totals == {
        "killed": 1,
        "crashed": 0,
        "hung": 0,
        "equivalent": 1,
        "within": 1,
        "survived": 1,
        "stillborn": 1,
    }
    write_summary(fates, explained, {"core": "a"}, tmp_path / "m.json")
    assert '"mutants": 4,' in (tmp_path / "m.json").read_text()
    assert share_seen(totals) == 0.5
    assert share_seen(counted([], {})) == 1.0  # nothing has changed


def test_what_does_not_compile_is_found_by_numbas_message(tmp_path: Path) -> None:
    file = tmp_path / "softbody" / "law.py"
    file.parent.mkdir()
    file.write_text("def f(x):\n    y = x + 1 if noted_awake(4) else x\n    return y if noted_awake(5) else x\n")
    assert mutants_at(tmp_path, "law.py", 3) == {5}
    assert mutants_at(tmp_path, "law.py", 1) == {4, 5}
    why = f'raised TypingError: Failed in nopython mode … File "{tmp_path}/softbody/law.py", line 2:'
    assert culprits(why, tmp_path) == {4}
    assert culprits("raised IndexError: no", tmp_path) == set()


IMPULSE = "collision/impulse.py:"
HARMFUL = f"{IMPULSE}resolve_contact: -j -> j"
CLAIM = "impulse.denominator", "quick", 20080101


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Bench, dict[str, int]]]:
    mutants = [each for each in all_mutants() if each.file == "collision/impulse.py"]
    folder = tmp_path_factory.mktemp("core").resolve()
    write_core(dict(enumerate(mutants)), folder)
    with Bench(folder, interpreted=True) as bench:
        yield bench, {each.key: k for k, each in enumerate(mutants)}


def test_a_harmful_mutant_is_seen_and_a_harmless_one_is_not(bench: tuple[Bench, dict[str, int]]) -> None:
    judge, number = bench
    sound = judge.run_asleep(*CLAIM, limit=60.0)
    assert sound.what == GREEN
    assert number[HARMFUL] in sound.reached
    assert judge.judge(number[HARMFUL], *CLAIM, limit=60.0).what == MEASURED
    harmless = next(key for key in number if "_at: inverse_effective_mass(sub" in key)  # r and n change places
    assert number[harmless] in sound.reached
    assert judge.judge(number[harmless], *CLAIM, limit=60.0).what == GREEN
    assert judge.judge(ASLEEP, *CLAIM, limit=60.0).what == GREEN


def test_a_claim_without_an_end_is_ended(bench: tuple[Bench, dict[str, int]]) -> None:
    assert bench[0].judge(ASLEEP, "pressure.shape_at_rest", "quick", 1, limit=0.1).what == HUNG


def test_a_mutant_has_one_reason(tmp_path: Path) -> None:
    path = tmp_path / "explained.json"
    path.write_text('[{"reason": "a", "mutants": ["f"]}, {"reason": "b", "within": true, "mutants": ["g"]}]')
    assert explained_in(path) == {"f": Reason("a", False), "g": Reason("b", True)}
    path.write_text('[{"reason": "a", "mutants": ["f"]}, {"reason": "b", "mutants": ["f"]}]')
    with pytest.raises(ValueError, match="two reasons for 'f'"):
        explained_in(path)


def test_explained_and_left_out_are_things_of_the_core_as_it_is() -> None:
    every = {each.key for each in all_mutants()}
    assert not EXPLAINED.keys() - every
    assert all((ROOT / "softbody" / each).exists() for each in LEFT_OUT)
    assert is_left_out("scenes/tray.py")
    assert not is_left_out("world.py")


def test_bits_are_those_of_worlds_and_of_answers() -> None:
    def bits_of(height: float, answer: float) -> str:
        def fall(run: Run) -> Comparison:
            world = World()
            world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, height))
            world.run(0.01, 0.01)
            return Comparison([answer], [answer])

        with traced(replace(all_checks()["impulse.denominator"], compare=fall)) as (check, bits):
            check.compare(Run("quick", 1, check.id))
        return str(bits.hexdigest())

    assert bits_of(5.0, 1.0) == bits_of(5.0, 1.0)
    assert bits_of(5.0, 1.0) != bits_of(np.nextafter(5.0, 6.0), 1.0)
    assert bits_of(5.0, 1.0) != bits_of(5.0, np.nextafter(1.0, 2.0))
