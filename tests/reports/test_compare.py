"""Does a comparison of two reports say what became worse, and nothing else?"""

import copy
import dataclasses

import numpy as np
import pytest
from click.testing import CliRunner

from reports.__main__ import main as reports
from reports.compare import main
from reports.differences import changes, slow_downs
from validation.record import FAILS, HOLDS, NOT_RUN, Timing, write_report


@pytest.fixture
def before(report, claim_of):
    """A report of one claim that holds at a twentieth of its tolerance, and two timings beside two peers."""
    report.claims = [claim_of(0, np.array([1e-15, 5e-14]), 1e-12, "m", id="volume.one")]
    report.timings = [
        row
        for size in (42, 162)
        for row in (timing("ours", size, None), timing("theirs", size, 3.0), timing("others", size, 5.0))
    ]
    return report


@pytest.fixture
def now(before):
    return copy.deepcopy(before)


def timing(name, size, ratio, spread=0.01, own=False):
    of_ratio = (ratio, ratio * (1.0 - spread), ratio * (1.0 + spread)) if ratio else (None,) * 3
    return Timing("A step", name, size, "things", "thing and step", 10.0, 9.0, 11.0, 5, *of_ratio, own=own)


@pytest.fixture
def compare(before, now, tmp_path):
    """Return a function that compares the two as files."""

    def compare():
        write_report(before, tmp_path / "before.json")
        write_report(now, tmp_path / "now.json")
        return CliRunner().invoke(main, [str(tmp_path / "before.json"), str(tmp_path / "now.json")])

    return compare


def test_diff_is_the_same_by_its_name_and_takes_folders(before, now, tmp_path):
    now.claims[0].verdict = FAILS
    for name, one in (("a", before), ("b", now)):
        write_report(one, tmp_path / name / "report.json")
    done = CliRunner().invoke(reports, ["diff", str(tmp_path / "a"), str(tmp_path / "b")])
    assert done.exit_code == 1
    assert "fails now" in done.output


def kinds(before, now):
    return [(change.kind, change.id) for change in changes(before, now)]


def test_equal_reports_have_no_difference(compare):
    done = compare()
    assert done.exit_code == 0, done.output
    assert "no claim has changed" in done.output
    assert "0 of 2 timings are slower" in done.output


def test_a_claim_that_fails_now_is_named_with_the_reason_and_ends_with_1(compare, now):
    now.claims[0].value, now.claims[0].verdict, now.claims[0].why = 2e-12, FAILS, "1 of 2 exceed the tolerance"
    done = compare()
    assert done.exit_code == 1, done.output
    assert "fails now" in done.output
    assert "volume.one" in done.output
    assert "1 of 2 exceed the tolerance" in done.output


@pytest.mark.parametrize(
    ("was", "verdict", "kind"),
    [
        (HOLDS, FAILS, "fails now"),
        (NOT_RUN, FAILS, "fails now"),
        (FAILS, FAILS, None),
        (FAILS, HOLDS, "holds now"),
        (NOT_RUN, HOLDS, "holds now"),
        (HOLDS, NOT_RUN, "not run now"),
        (FAILS, NOT_RUN, "not run now"),
    ],
)
def test_each_change_of_a_verdict_has_its_name(before, now, compare, was, verdict, kind):
    before.claims[0].verdict, now.claims[0].verdict = was, verdict
    assert kinds(before, now) == ([(kind, "volume.one")] if kind else [])
    assert compare().exit_code == (1 if kind == "fails now" else 0)


def test_new_and_lost_claims_are_named_and_a_new_one_that_fails_fails(before, now, compare):
    now.claims = [dataclasses.replace(now.claims[0], id=name) for name in ("volume.two", "volume.three")]
    now.claims[1].verdict = FAILS
    assert kinds(before, now) == [("fails now", "volume.three"), ("new", "volume.two"), ("gone", "volume.one")]
    assert compare().exit_code == 1


@pytest.mark.parametrize(
    ("old", "new", "is_closer"),
    [
        (0.05, 0.3, True),
        (0.2, 0.41, True),
        (0.2, 0.39, False),  # not twice
        (0.01, 0.09, False),  # far away still
        (0.0, 0.11, True),
        (0.9, 0.3, False),
    ],
)
def test_closer_is_twice_the_share_and_more_than_a_tenth(before, now, compare, old, new, is_closer):
    before.claims[0].value, now.claims[0].value = old * 1e-12, new * 1e-12
    assert kinds(before, now) == ([("closer to its tolerance", "volume.one")] if is_closer else [])
    done = compare()
    assert done.exit_code == 0
    assert not is_closer or f"{old:g} → {new:g} of 10⁻¹² m" in done.output


def test_a_tolerance_that_was_widened_is_said(before, now):
    now.claims[0].tolerance = 1e-10
    assert [(change.kind, change.what) for change in changes(before, now)] == [("wider tolerance", "10⁻¹² → 10⁻¹⁰ m")]


def test_what_is_no_number_in_both_is_no_change(before, now):
    for report in (before, now):
        report.claims[0].tolerance = report.claims[0].value = None
    assert kinds(before, now) == []


def test_wrong_cases_that_are_allowed_are_no_share_of_a_tolerance(before, now):
    for report, wrong in ((before, 0.0), (now, 1.0)):
        report.claims[0] = dataclasses.replace(report.claims[0], unit="disagreements", tolerance=2.0, value=wrong)
    assert kinds(before, now) == []


def test_slower_relative_to_every_peer_is_said(before, now, compare):
    now.timings[1:3] = [timing("theirs", 42, 2.0), timing("others", 42, 4.0)]
    ((slow,), count) = slow_downs(before, now)
    assert (slow.row, slow.peers, count) == (("A step", "ours", 42), ["theirs", "others"], 2)
    assert slow.ratio == pytest.approx(1.25)  # by others, of which it is less
    done = compare()
    assert done.exit_code == 0
    assert "1 of 2 timings are slower" in done.output
    assert "× 1.25" in done.output
    assert "python -m benchmarks compare" in done.output


@pytest.mark.parametrize(
    "peers",
    [
        [timing("theirs", 42, 2.0), timing("others", 42, 5.0)],  # theirs became faster
        [timing("theirs", 42, 2.95), timing("others", 42, 4.9)],  # no more than the spread
        [timing("theirs", 42, 2.0, 0.2), timing("others", 42, 4.0, 0.2)],
        [timing("theirs", 42, 4.0), timing("others", 42, 6.0)],  # faster
    ],
)
def test_what_says_nothing_of_ours_is_no_slow_down(before, now, peers):
    now.timings[1:3] = peers
    assert slow_downs(before, now) == ([], 2)


def test_what_is_the_core_itself_is_no_yardstick(before, now):
    before.timings[2], now.timings[1:3] = (
        timing("others", 42, 5.0, own=True),
        [timing("theirs", 42, 2.0), timing("others", 42, 5.0, own=True)],
    )
    assert slow_downs(before, now)[0][0].peers == ["theirs"]


def test_timings_without_a_common_peer_are_not_compared(before, now, compare):
    now.timings = [row for row in now.timings if row.ratio is None]
    assert "none with a peer in common" in compare().output


def test_timings_of_two_machines_are_not_compared_but_claims_are(now, compare):
    now.environment["processor"] = "Another CPU"
    now.claims[0].verdict = FAILS
    done = compare()
    assert done.exit_code == 1
    assert "AMD EPYC 9654, 2, Linux x86_64; Another CPU, 2, Linux x86_64" in done.output


def test_judges_of_another_version_are_said(now, compare):
    now.engines["fcl"] = "0.8.0"
    del now.engines["trimesh"]
    said = compare().output
    assert "fcl: 0.7.0.8 → 0.8.0" in said
    assert "trimesh: 4.4.1 → missing" in said


@pytest.mark.parametrize(("field", "value"), [("level", "full"), ("seed", 7), ("draws", 3)])
def test_reports_of_other_cases_are_refused(now, compare, field, value):
    setattr(now, field, value)
    done = compare()
    assert done.exit_code == 2
    assert str(value) in done.output
    assert "the same --level, --seed and --draws" in done.output


@pytest.mark.parametrize(("text", "words"), [("{", "is not JSON"), ("{}", "has schema None"), (None, "does not exist")])
def test_a_file_that_is_no_report_is_named(now, tmp_path, text, words):
    write_report(now, tmp_path / "now.json")
    if text is not None:
        (tmp_path / "other.json").write_text(text)
    done = CliRunner().invoke(main, [str(tmp_path / "now.json"), str(tmp_path / "other.json")])
    assert done.exit_code == 2
    assert f"other.json {words}" in done.output
