"""What has changed is tried again and what has moved is not; draws are fair, few kernels each, and reach everything."""

from __future__ import annotations

import subprocess
from collections import Counter
from math import inf
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import click
import pytest

from softbody import World
from validation import changed_faults, faults
from validation.bench import GREEN, Seen
from validation.changed_faults import all_declarations
from validation.check import all_checks
from validation.claim_groups import WORLDS, group_of
from validation.damaged_core import ROOT
from validation.fault import Fault
from validation.fault_draw import draw
from validation.fault_trials import ESCAPED, TOO_LATE, claims_by_group, planted_faults, try_in_time
from validation.mutation import revision, sample
from validation.mutation.revision import changed, definitions_in, number_of_head, sources_at
from validation.mutation.sample import changed_functions

FAULTS, CHECKS = planted_faults(), all_checks()

CORE = '''
import math
from softbody.old import far

LIMIT = 2.0

class Rest(NamedTuple):
    """Words."""
    speed: float = 1.0

def area(width):
    return width * width

def ring(radius):
    return math.pi * radius
'''
CLAIM = """
LATE = Fault("late", step.run, "h_ → 2.0 * h_")

@check(
    tolerance=1e-9,
    faults=(Fault("twice", law.area, "w_ → 2.0 * w_"), LATE),
)
def areas(run):
    'An area is one.'
    return compare(run)
"""


def commit(folder: Path, files: dict[str, str]) -> None:
    """Let a repository in a folder hold these files, and no others, and commit them."""
    git = ["git", "-C", str(folder), "-c", "user.name=n", "-c", "user.email=e"]
    if not (folder / ".git").exists():
        subprocess.run([*git, "init", "-q"], check=True)
    subprocess.run([*git, "rm", "-rfq", "--ignore-unmatch", "."], check=True)
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    subprocess.run([*git, "add", "."], check=True)
    subprocess.run([*git, "commit", "-q", "-m", "m"], check=True)


def changed_from(before: str, now: str) -> set[str]:
    return {name for _, name in changed({"a.py": before}, {"b.py": now}, definitions_in)}


def test_what_has_only_moved_has_not_changed() -> None:
    moved = CORE.replace("softbody.old", "softbody.new").replace("Words", "Other words") + '\n"""End."""\n'
    assert changed_from(CORE, moved) == set()
    assert changed({"a.py": CORE}, {"a.py": "", "b.py": CORE}, definitions_in) == set()


def test_what_reads_differently_has_changed() -> None:
    assert changed_from(CORE, CORE.replace("width * width", "width + width")) == {"area"}
    assert changed_from(CORE, CORE.replace("def area", "def square")) == {"square"}
    assert changed_from(CORE, CORE.replace("2.0", "3.0")) == {"LIMIT"}
    assert changed_from(CORE, CORE.replace("1.0", "4.0")) == {"Rest", "Rest.speed"}


def test_mutants_of_functions_that_moved_are_not_tried_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    commit(tmp_path, {"softbody/law.py": CORE})
    commit(tmp_path, {"softbody/room/laws.py": CORE.replace("math.pi * radius", "math.pi / radius")})
    monkeypatch.setattr(sample, "ROOT", tmp_path)
    assert changed_functions("HEAD~1") == {("room/laws.py", "ring")}


def test_a_revision_without_the_folder_held_nothing(tmp_path: Path) -> None:
    commit(tmp_path, {"readme": "text"})
    assert sources_at("HEAD", "softbody", tmp_path) == {}
    with pytest.raises(ValueError, match="Git knows no revision 'nowhere'"):
        sources_at("nowhere", "softbody", tmp_path)


def test_each_commit_has_its_number(tmp_path: Path) -> None:
    commit(tmp_path, {"readme": "text"})
    first = number_of_head(tmp_path)
    assert first == number_of_head(tmp_path)
    commit(tmp_path, {"readme": "other text"})
    assert first != number_of_head(tmp_path)
    with pytest.raises(ValueError, match="give --seed"):
        number_of_head(Path("/"))


def declared(source: str, **others: str) -> list[changed_faults.Declaration]:
    """Return what a file of claims declares, beside others."""
    return all_declarations({"claims": source, **others})["claims"]


def news(claim: str) -> set[str]:
    """Which faults a file of claims names that are not as in CLAIM."""
    before = set(declared(CLAIM))
    words = {"'twice'": "twice", "'late'": "late", "'thrice'": "thrice"}
    return {words[word] for each in declared(claim) if each not in before for word in words if word in each[2]}


def test_a_fault_is_news_when_it_or_its_claim_says_something_else() -> None:
    assert len(declared(CLAIM)) == 2
    assert news(CLAIM.replace("law.area", "laws.area").replace("is one", "is 1")) == set()
    assert news(CLAIM.replace("2.0 * w_", "3.0 * w_")) == {"twice"}
    assert news(CLAIM.replace("2.0 * h_", "3.0 * h_")) == {"late"}
    assert news(CLAIM.replace("twice", "thrice")) == {"thrice"}
    assert news(CLAIM.replace("compare(run)", "other(run)")) == {"twice", "late"}
    assert news(CLAIM.replace("1e-9", "1e-6")) == {"twice", "late"}
    assert news(CLAIM.replace("areas", "others")) == {"twice", "late"}


def test_a_fault_that_another_file_names_is_news_with_it() -> None:
    here = CLAIM.replace("LATE =", "OTHER =")
    before, now = (declared(here, cases=f'LATE = Fault("late", step.run, "h_ → {n}.0 * h_")') for n in (2, 3))
    assert [a == b for a, b in zip(before, now, strict=True)] == [True, False]


def test_declarations_are_those_of_the_claims() -> None:
    for check in CHECKS.values():
        source = ROOT.joinpath(*check.compare.__module__.split(".")).with_suffix(".py").read_text()
        here = [each for each in declared(source) if each[0] == check.compare.__name__]
        assert len(here) == len(check.faults), check.id


def test_faults_of_a_function_that_changed_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    check = CHECKS["volume.inertia_of_boxes"]
    checks = Path("validation/checks/geometry/volume.py")
    box = (ROOT / "softbody/geometry/box.py").read_text()
    commit(tmp_path, {"softbody/old/box.py": box, str(checks): (ROOT / checks).read_text()})
    commit(tmp_path, {"softbody/geometry/box.py": box, str(checks): (ROOT / checks).read_text()})
    monkeypatch.setattr(changed_faults, "ROOT", tmp_path)
    assert changed_faults.changed_faults({check.id: check}, "HEAD~1") == set()
    other = box.replace("mass / 12.0", "mass / 12")
    assert other != box
    (tmp_path / "softbody/geometry/box.py").write_text(other)
    assert changed_faults.changed_faults({check.id: check}, "HEAD~1") == set(check.faults)


def of_boxes(run: Any) -> None:
    World().add_box((1.0, 1.0, 1.0), 1.0)


def of_what_another_makes(run: Any) -> None:
    [of_boxes(run) for _ in range(3)]
    World(sleep_speed=0.1)


def test_a_kind_of_world_is_read_from_what_a_claim_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("validation.claim_groups.OURS", ("validation", __name__))
    claim: Any = SimpleNamespace(compare=of_boxes)
    assert group_of(claim) == "worlds of boxes"
    claim.compare = of_what_another_makes
    assert group_of(claim) == "worlds of boxes, sleep"
    assert group_of(CHECKS["volume.closed_forms"]) == "volume"
    assert group_of(CHECKS["landings.flat_however_turned"]) == "worlds of boxes"


def test_a_seed_draws_the_same_twice_and_another_draws_others() -> None:
    one, again, other = (draw(FAULTS, CHECKS, 40, seed) for seed in (7, 7, 8))
    assert one == again
    assert one.faults != other.faults
    assert one.pairs == 40
    assert one.of == sum(map(len, FAULTS.values()))


@pytest.mark.parametrize("seed", range(20))
def test_a_draw_is_of_one_kind_of_world_at_most(seed: int) -> None:
    drawn = draw(FAULTS, CHECKS, 40, seed)
    groups = {group_of(CHECKS[claim]) for claims in drawn.faults.values() for claim in claims}
    assert groups == set(drawn.groups)
    assert sum(group.startswith(WORLDS) for group in groups) == 1
    assert all(set(claims) <= set(FAULTS[fault]) for fault, claims in drawn.faults.items())


def test_draws_reach_every_fault_and_none_much_more_often_than_others() -> None:
    times: Counter[tuple[Fault, str]] = Counter()
    for seed in range(1000):
        drawn = draw(FAULTS, CHECKS, 40, seed)
        times.update((fault, claim) for fault, claims in drawn.faults.items() for claim in claims)
    pairs = [(fault, claim) for fault, claims in FAULTS.items() for claim in claims]
    even = 1000 * 40 / len(pairs)
    assert set(times) == set(pairs)
    assert max(times.values()) < 4.0 * even


def test_all_are_drawn_if_there_are_no_more() -> None:
    assert draw(FAULTS, CHECKS, 10_000, 1).faults == FAULTS
    assert draw({}, CHECKS, 10, 1).faults == {}
    assert draw(FAULTS, CHECKS, 0, 1).faults == {}


def test_what_is_chosen_is_what_changed_and_the_draw(monkeypatch: pytest.MonkeyPatch) -> None:
    fault = next(each for each, claims in FAULTS.items() if len(claims) > 2)
    monkeypatch.setattr(changed_faults, "changed_faults", lambda checks, since: {fault} if since else set())
    some, told = faults.chosen("", "main", None, 20, 7)
    assert some[fault] == FAULTS[fault]
    others = sum(map(len, FAULTS.values())) - len(FAULTS[fault])
    assert told.startswith(
        f"1 faults that are new or changed since main, 20 drawn of {others} others by seed 7: worlds"
    )
    assert faults.chosen("", None, None, None, None)[0] == FAULTS
    monkeypatch.setattr(revision, "number_of_head", lambda: 9)
    assert "by seed 9" in faults.chosen("", None, None, 20, None)[1]
    assert faults.chosen("", "", None, None, None) == ({}, "0 faults that are new or changed since ")
    monkeypatch.setattr(changed_faults, "changed_faults", lambda checks, since: set(FAULTS))
    some, told = faults.chosen("", "main", 60, None, 7)
    assert list(some) == list(faults.chosen("", "main", 60, None, 7)[0])
    assert list(some) != sorted(some, key=list(FAULTS).index)  # whichever are left when the minutes are over are drawn
    assert sum(map(len, some.values())) == 60
    assert told.startswith(f"60 of {sum(map(len, FAULTS.values()))} that are new or changed since main: worlds")
    with pytest.raises(click.UsageError, match="no fault and no claim has 'nothing of it'"):
        faults.chosen("nothing of it", None, None, None, None)


def test_no_fault_is_begun_once_the_minutes_are_over() -> None:
    fault, claims = next(iter(FAULTS.items()))
    judges: Any = SimpleNamespace(awake=lambda fault, claim: Seen(GREEN))
    sound = dict.fromkeys(claims, Seen(GREEN))
    assert try_in_time(fault, claims, judges, {}, end=-inf).why == TOO_LATE
    assert try_in_time(fault, claims, judges, sound, end=inf).verdict == ESCAPED


def test_claims_that_compile_the_same_are_judged_in_turn() -> None:
    groups = claims_by_group(FAULTS)
    names = [{group_of(CHECKS[claim]) for claim in group} for group in groups]
    assert all(len(each) == 1 for each in names)
    assert len(set.union(*names)) == len(groups)
