"""Does the page say everything that is in the record, on its own, whatever the record holds?"""

import dataclasses
import re

import numpy as np
import pytest

from reports.page import growth_of, page
from reports.trend_plots import sparkline
from tests.reports.parsed import Parsed
from validation.record import FAILS, HOLDS, NOT_RUN, Case, Erratum, Figure, Group, Subject, Trend, TrendStep

EVIL = "<script>alert(1)</script>\"' onload=x {{ 7*7 }}"


@pytest.fixture(scope="module")
def made():
    """The page of a made-up record; made once, as the fixtures of a test cannot be."""
    return {}


@pytest.fixture
def parsed(report, made):
    if not made:
        made["text"] = page(report)
        made["parsed"] = Parsed(made["text"])
    return made["parsed"]


def test_the_markup_is_well_formed(parsed):
    assert parsed.broken == []
    assert parsed.stack == []
    ids = parsed.all("id")
    assert len(ids) == len(set(ids))


def test_nothing_is_fetched_from_anywhere(parsed, made):
    for link in parsed.all("src") + parsed.all("href"):
        assert link.startswith(("#", "data:")) or link in ("report.json", "junit.xml")
    assert "@import" not in made["text"]
    assert not re.search(r"https?://|url\((?!#|data:)", made["text"])
    assert parsed.all("srcset") == parsed.all("action") == []


def test_every_inner_link_has_its_target(parsed):
    ids = set(parsed.all("id"))
    assert {link[1:] for link in parsed.all("href") if link.startswith("#")} <= ids


def test_the_only_script_is_the_one_that_the_page_allows(parsed, made):
    policy = next(attrs["content"] for tag, attrs in parsed.tags if attrs.get("http-equiv"))
    assert "default-src 'none'" in policy
    assert re.search(r"script-src 'sha256-[\w+/=]{44}'", policy)
    assert made["text"].count("<script") == 1


def test_the_verdict_comes_first_and_is_never_colour_alone(parsed):
    assert parsed.text.index("claims FAIL") < parsed.text.index("How to read this page")
    for word in ("✓ holds", "✗ fails", "– not run"):
        assert word in parsed.text


def test_the_run_is_described(parsed):
    for fact in (
        "21 November 2025, 06:44 UTC",
        "standard",
        "20080101",
        "ab754e8c0ffe+",
        "with uncommitted changes",
        "2 min 31 s",
        "AMD EPYC 9654",
        "pybullet– missing",
        "numba0.60.0",
        "softbody-report/2",
        "python -m validation --seed 20080101 --level standard",
        "never a pass",
    ):
        assert fact in parsed.text


def test_the_facts_of_every_claim_are_there(parsed, report):
    for claim in report.claims:
        for fact in (
            claim.id,
            claim.claim,
            claim.piece,
            claim.reference,
            claim.because,
            claim.detail,
            *claim.faults,
            claim.why or "",
        ):
            assert fact in parsed.text
        for fact in claim.notes + [group.label for group in claim.groups]:
            assert fact in parsed.text
        assert f"python -m validation replay {claim.id} --seed {claim.seed} --level standard" in parsed.text
        assert f"claim-{claim.id}" in parsed.all("id")


def test_the_worst_case_of_a_claim_that_holds_has_inputs_and_both_answers(report, claim_of):
    errors = np.array([1e-15, 2e-13])
    answers = [0.1 + 0.2, *range(40)], [0.3, *range(40)]
    worst = Case(1234, 2e-13, 1.0, *answers, "torus", {"point": [1.5, None], "<b>": True}, 41)
    report.claims = [claim_of(0, errors, 1e-12, worst=worst)]
    found = Parsed(page(report))
    assert found.broken == found.stack == []
    text = " ".join(found.text.split()).replace("\u202f", " ")
    assert "The worst case: number 1234, torus; error 2 × 10⁻¹³ relative" in text.replace("\u00a0", " ")
    for word in ("point", "1.5, not a number", "<b>", "yes", "0.30000000000000004", "and 29 numbers more"):
        assert word in text


def test_a_run_of_some_claims_says_so_in_its_command(report):
    report.patterns = ["volume", "a b"]
    assert "python -m validation -k volume -k 'a b' --seed 20080101 --level standard" in Parsed(page(report)).text


def test_a_run_of_some_claims_that_all_hold_is_not_green(report):
    report.claims = [claim for claim in report.claims if claim.verdict == HOLDS]
    report.patterns, report.registered, count = ["volume"], 400, len(report.claims)
    text = page(report)
    assert f"<title>{count} of 400 selected (-k volume): all {count} claims hold" in text
    assert '<header class="open">' in text


def test_every_measured_claim_has_a_plot_and_a_place_on_the_axis(parsed, report):
    measured = [c for c in report.claims if c.errors and c.tolerance and c.unit != "disagreements"]
    labels = parsed.all("aria-label")
    assert sum(label.startswith("Histogram") for label in labels) == len(measured)
    assert sum(label.startswith("median, 99th") for label in labels) == len(measured)


def test_claims_that_count_say_how_many_disagree(parsed):
    assert re.search(r"\b192 of 20 000 disagree", parsed.text)
    assert "0 of 500 differ" in parsed.text


def test_errata_are_sorted_by_number(parsed):
    table = parsed.text[parsed.text.index("Errata of the paper") :]
    places = [table.index(f"{name} ") for name in ("E2", "E10", "E11", "E20")]
    assert places == sorted(places)
    assert "10.7 %" in table
    assert "x' = x + a t" in table


def test_each_table_of_costs_has_its_times_its_ratios_and_its_plot(parsed, made):
    costs = parsed.text[parsed.text.index("What it costs") :]
    assert costs.index("A step") < costs.index("A query")
    assert "ns per thing and step" in costs
    assert "12.6 – 16.8" in costs  # ours at 642, quartiles
    assert "2.79 × faster (speed × 2.5 – 3.01)" in costs  # theirs over ours
    assert made["text"].count("the numbers are in the table") == 2


def test_a_table_says_how_our_cost_grows(report, parsed):
    assert "The whole cost grows as (things)" in parsed.text
    rows = [dataclasses.replace(report.timings[0], size=n, nanoseconds=5.0 * n**0.5) for n in (10, 100, 1_000)]
    assert growth_of(rows) == pytest.approx(1.5)
    assert growth_of(rows[:2]) is None


def test_precision_stands_beside_its_cost_and_figures_below(report):
    for timing in report.timings:
        timing.error = 0.0123
    report.figures = [Figure("first step", 0.45, "s"), Figure("memory", 554.0, "bytes each", 500.0)]
    found = Parsed(page(report))
    assert found.broken == found.stack == []
    assert "0.0123" in found.text
    assert "The whole cost grows" not in found.text
    assert re.search(r"first step\s*0\.45\s+s", found.text)
    assert re.search(r"memory\s*554\s+bytes each goal ≤ 500: missed", found.text)


def test_what_is_timed_by_the_second_of_motion_has_a_real_time_factor(parsed):
    scene = parsed.text[parsed.text.index("A scene") :]
    assert "ns per simulated second" in scene
    assert "× real time" in scene
    assert "6.2" in scene  # 1 s / 0.16 s
    assert "× real time" not in parsed.text[parsed.text.index("A step") : parsed.text.index("A scene")]


@pytest.fixture
def trend(report):
    """The trend of the first timing, which has become slower."""
    row = {"table": "A step", "name": "ours", "size": 642, "of": "things", "per": "thing and step"}
    days = [f"2030-01-0{day}T10:00:00+00:00" for day in range(1, 7)]
    steps = [TrendStep(3, 1.25, days[3], "oldrevision", "newrevision")]
    report.timings[0].trend = Trend("bench_x.py", "bench_x[642]", row, "a peer", days, [1.0] * 3 + [1.25] * 3, steps)
    return report.timings[0].trend


def test_goals_of_speed_are_told_with_how_far_they_are_met(report):
    found = Parsed(page(report))
    assert "Goals of speed: 2 of 4 are met" in found.text
    assert "2 of 4 goals of speed are met." in found.text
    assert "ours against others A step ≥ 30 21 (20 – 22) 2 562 things missed" in found.text
    assert "growth of ours A step ≤ 1.1 1.05 642 to 163 842 things met" in found.text
    assert "Not measured: ours against somebody else (A query)." in found.text
    report.goals = []
    assert "oals of speed" not in Parsed(page(report)).text


def test_a_timing_with_a_history_has_its_trend_and_its_steps(report, trend):
    found = Parsed(page(report))
    assert found.broken == found.stack == []
    assert [label for label in found.all("aria-label") if label.startswith("Trend")] == ["Trend, × a peer, over 6 runs"]
    assert [attrs["class"] for tag, attrs in found.tags if tag == "line" and "slower" in attrs.get("class", "")]
    told = "ours, 642 things: 1.25 × slower, from 4 January 2030, 10:00 UTC on: after oldrevision, with newrevision."
    assert told in found.text
    assert "upright lines are steps" in found.text
    assert found.text[: found.text.index("A query")].count(" trend ") == 1


def test_without_a_history_one_line_says_how_to_get_one(report, parsed):
    assert "trend" not in parsed.text
    report.trends_why = "nothing is stored; `python -m benchmarks run` measures something"
    why = "No timing has a trend: nothing is stored; <code>python -m benchmarks run</code> measures something."
    assert why in page(report)


def test_a_sparkline_goes_through_all_runs_and_stays_in_its_frame(trend):
    for values in ([1.0], [1.0, 3.0, 2.0], trend.values):
        started = trend.started[: len(values)]
        svg = sparkline(dataclasses.replace(trend, started=started, values=values, steps=[]))
        points = re.search(r'points="([^"]*)"', svg)[1].split()
        assert len(points) == len(values)
        x, y = np.array([point.split(",") for point in points], float).T
        assert (np.diff(x) > 0).all()
        assert (x > 0).all()
        assert (x < 96).all()
        assert (y >= 0).all()
        assert (y <= 22).all()


def test_the_papers_own_rules_stand_beside_the_defaults(parsed):
    rules = parsed.text[parsed.text.index("The paper’s own rules") : parsed.text.rindex("What it costs")]
    assert rules.index("defaults") < rules.index("the paper's own")
    for fact in ("2: rolling torus", "2.1 %", "< 0.1 %", "9.4 %", "0.7 %", "100 %", "0.8", "14"):
        assert fact in rules.replace("\u202f", " ")


def test_a_record_without_scenes_has_no_table_of_rules(report):
    report.behaviours = []
    assert "The paper’s own rules" not in page(report)


def test_the_same_record_gives_the_same_bytes(report, parsed, made):
    assert page(report) == made["text"]


def test_sixty_claims_stay_small(report_of):
    assert len(page(report_of(60)).encode()) < 1_500_000


def test_an_empty_record_makes_a_page(report):
    report.claims, report.timings, report.engines, report.environment = [], [], {}, {}
    report.timings_why, report.revision = "pytest-benchmark is not installed", None
    found = Parsed(page(report))
    assert found.broken == found.stack == []
    assert "Nothing was claimed" in found.text
    assert "There are no timings: pytest-benchmark is not installed." in found.text


def test_a_record_of_which_nothing_was_run_makes_a_page_that_is_no_pass(report, claim_of):
    skipped = {"verdict": NOT_RUN, "value": None, "n": 0, "errors": None, "groups": [], "why": "fcl is not installed"}
    report.claims = [claim_of(i, np.ones(3), **skipped) for i in range(3)]
    found = Parsed(page(report))
    assert "None of 3 claims was run" in found.text
    assert found.text.count("fcl is not installed") >= 6
    assert "✓" not in found.text.replace("✓ 0 hold", "")


def test_nulls_are_named_and_never_crash_the_page(report, claim_of):
    errors = np.array([1e-15, 2e-15])
    quantiles = {"0": None, "0.5": None, "0.9": None, "0.99": None, "1": None}
    for i in range(6):
        claim = claim_of(i, errors, verdict=FAILS, value=None, why="1 of 2 comparisons are not finite")
        claim.groups = [Group("a", 2, None, None, None)]
        claim.erratum = Erratum(f"E{i}", "a", "b", None, None, None)
        claim.n = 3 if i != 5 else 0
        report.claims.append(claim)
        claim.errors.quantiles = quantiles if i % 2 else {}
        if i == 2:
            claim.errors = None
        if i == 3:
            claim.unit, claim.tolerance = "disagreements", 0.0
        if i == 4:
            claim.tolerance = claim.seconds = None
    report.seconds = None
    for timing in report.timings:
        timing.low = timing.high = timing.nanoseconds = None
    found = Parsed(page(report))
    assert found.broken == found.stack == []
    assert "not a number" in found.text
    assert "not finite, and not shown" in found.text
    assert "None" not in found.text
    assert "nan" not in found.text.split()


def test_text_of_the_record_is_text(report, claim_of):
    claim = claim_of(0, np.array([1e-3, 0.0]), why="x", notes=["x"], erratum=Erratum("x", "x", "x", 1.0, 1.0, 1.0))
    report.claims = [everywhere(claim, EVIL)]
    report.claims[0].verdict = FAILS
    report.timings = [dataclasses.replace(t, name=EVIL) for t in report.timings]
    report.level = report.revision = report.softbody_version = report.created = EVIL
    report.environment, report.engines = {EVIL: EVIL}, {EVIL: EVIL}
    text = page(report)
    found = Parsed(text)
    assert text.count("<script") == 1
    assert found.broken == found.stack == []
    assert not [attrs for _, attrs in found.tags if "onload" in attrs]
    assert EVIL in found.text
    assert "{{ 7*7 }}" in found.text


def everywhere(thing, text):
    """Return a record with `text` in every field that holds words."""
    changes = {}
    for field in dataclasses.fields(thing):
        value = getattr(thing, field.name)
        if isinstance(value, str):
            changes[field.name] = text
        elif dataclasses.is_dataclass(value) and field.name == "erratum":
            changes[field.name] = everywhere(value, text)
        elif isinstance(value, list) and value:
            changes[field.name] = [text if isinstance(v, str) else everywhere(v, text) for v in value]
    return dataclasses.replace(thing, **changes)


def test_claims_whose_ids_differ_in_odd_characters_have_their_own_anchors(report, claim_of):
    report.claims = [claim_of(0, np.array([1e-15]), id=name) for name in ("a b", "a-b", "a<b")]
    ids = [name for name in Parsed(page(report)).all("id") if name.startswith("claim-")]
    assert len(ids) == len(set(ids)) == 3


def test_the_ledger_says_who_was_right_with_an_example_and_how_engines_were_set(parsed):
    text = parsed.text
    assert re.search(r"FCL ?1 ?60 ?12 ?20", text), "claims, answers, wrong, share"
    assert re.search(r"softbody ?1 ?60 ?0 ?none", text)
    assert "Decided by exact arithmetic" in text
    assert "0.1, 0.2, 0.30000000000000004" in text
    assert re.search("no contacts ?with them it misses what just touches", text)


def test_another_engine_has_a_page_in_its_name_without_what_is_of_the_core(report):
    report.subject, report.timings, report.behaviours = Subject("rapier3d", "0.36.1"), [], []
    for claim in report.claims:
        claim.erratum = None
    parsed = Parsed(page(report))
    assert parsed.broken == []
    assert "rapier3d 0.36.1 · judged by the claims of softbody" in parsed.text
    assert "Who is judged here is rapier3d 0.36.1, not softbody" in parsed.text
    assert "python -m validation --subject rapier3d --seed" in parsed.text
    assert {"errata", "timings"}.isdisjoint(parsed.all("id"))
    assert {link[1:] for link in parsed.all("href") if link.startswith("#")} <= set(parsed.all("id"))


def test_a_look_tells_what_is_nearest_to_failing_and_who_judges(report, parsed):
    ratios = {c.id: c.value / c.tolerance for c in report.claims if c.verdict == "holds" and c.value and c.tolerance}
    measured = {c.id for c in report.claims if c.errors and c.unit != "disagreements"}
    nearest = max(measured & set(ratios), key=ratios.get)
    glance = parsed.text[parsed.text.index("Nearest to failing") : parsed.text.index("One line a family")]
    assert nearest in glance
    assert "ns per thing and step" in glance


def test_the_contents_name_what_is_there_and_only_that(report, parsed):
    assert "What they detect" not in parsed.text
    contents = parsed.text[: parsed.text.index("Nearest to failing")]
    for title in ("The claims", "Errata", "What it costs", "Where it ran"):
        assert title in contents


def test_every_claim_says_what_it_can_be_found_by(parsed, report):
    assert len(parsed.all("data-verdict")) == len(report.claims)
    assert len(parsed.all("data-kind")) == len(report.claims)
    assert all(float(ratio) >= 0.0 for ratio in parsed.all("data-ratio"))
