"""Does the page of trends say all that is in its document, on its own, and is it written whole?"""

import dataclasses
import json
import re
import xml.etree.ElementTree

import numpy as np
import pytest
from click.testing import CliRunner

from reports import trends_page
from reports.trend_plots import span, trend_plot
from reports.trends import main
from reports.trends_document import Calibration, Rate, Run, Trends, read_trends
from tests.reports.parsed import Parsed
from validation.record import Trend, TrendStep

RUNS = 12
EVIL = "<script>alert(1)</script>\"' onload=x {{ 7*7 }}"


def day(run):
    return f"2030-01-{run + 1:02}T10:00:00+00:00"


def make_trend(name="bench_step[42]", ratios=(), runs=RUNS, peer="a peer"):
    """Return a trend whose level changes by the ratios, at equal distances."""
    places = np.linspace(0, runs, len(ratios) + 2).round().astype(int)[1:-1].tolist()
    values = 0.5 + 0.001 * np.random.default_rng(1).normal(size=runs)
    for at, ratio in zip(places, ratios):
        values[at:] *= ratio
    steps = [TrendStep(at, ratio, day(at), f"before{at}", f"after{at}") for at, ratio in zip(places, ratios)]
    row = {"table": "Steps", "name": "softbody", "size": 1234567, "of": "particles", "per": "particle and step"}
    return Trend("bench_step.py", name, row, peer, [day(k) for k in range(runs)], values.tolist(), steps)


def make_trends(*trends):
    rates = [Rate(0, 600, 3, 760), Rate(3, 240, 228, 233)]
    return Trends(
        machine={"processor": "Some CPU", "cores": "2", "checksum": "0a1b2c3d"},
        runs=[Run(day(k), f"revision{k}", "quick", 1.5, {"numba": "0.60.0"}) for k in range(RUNS)],
        fewest=6,
        calibration=Calibration("2029-12-31T09:30:00+00:00", "calibrated", 2.3, rates),
        trends=list(trends),
    )


@pytest.fixture
def trends():
    return make_trends(make_trend("bench_step[42]", (0.8, 1.1)), make_trend("bench_b", (0.9,)), make_trend("bench_c"))


def test_the_page_stands_alone_and_is_well_formed(trends):
    text = trends_page.page(trends)
    parsed = Parsed(text)
    assert parsed.broken == parsed.stack == []
    ids = parsed.all("id")
    assert len(ids) == len(set(ids))
    for link in parsed.all("src") + parsed.all("href"):
        assert link == "trends.json" or link.startswith("data:") or (link[0] == "#" and link[1:] in ids)
    assert not re.search(r"https?://|url\((?!#|data:)|<script|@import", text)


def test_machine_runs_and_calibration_are_told(trends):
    text = Parsed(trends_page.page(trends)).text
    for fact in (
        "Some CPU", "0a1b2c3d", "1 January 2030", "12 January 2030", "revision0", "revision11", "quick", "numba 0.60.0",
        "31 December 2029, 09:30 UTC at revision calibrated and a load of 2.3",
        "0.5 % of 600 comparisons, drawn from 760 openings", "slow-downs by 3 % found95 % of 240",
    ):  # fmt: skip
        assert fact in text, fact


def test_without_a_calibration_it_says_how_to_get_one(trends):
    trends.calibration = None
    assert "python -m benchmarks calibrate" in Parsed(trends_page.page(trends)).text


def test_each_benchmark_has_its_last_value_its_plot_and_its_steps(trends):
    parsed = Parsed(trends_page.page(trends))
    for trend in trends.trends:
        assert f"Trend of {trend.name}; its steps are told below it" in parsed.all("aria-label")
    panel = parsed.text[parsed.text.index("bench_step[42] Steps, 1 234 567 particles") :]
    assert re.match(r".*?0\.44 × a peer in the last of 12 runs", panel)
    assert "1.25 × faster, from 5 January 2030, 10:00 UTC on: after before4, with after4." in panel
    assert "1.1 × slower, from 9 January 2030, 10:00 UTC on: after before8, with after8." in panel
    assert parsed.text.count("No step.") == 1


def test_steps_are_listed_newest_first(trends):
    text = Parsed(trends_page.page(trends)).text
    listed = text[text.index("newest first") : text.index("How to read")]
    assert re.findall(r"with after(\d+)", listed) == ["8", "6", "4"]


def test_a_few_runs_have_no_step_for_their_number():
    one = make_trend(runs=1, peer=None)
    text = Parsed(trends_page.page(make_trends(one))).text
    assert "ns per particle and step in the only run" in text
    assert "Too few runs for a step: 6 are needed." in text


@pytest.mark.parametrize(
    ("ratios", "sentence", "is_open"),
    [
        (((),), "No step in 1 benchmark", False),
        (((1.1,), (1.2,), (0.9,)), "2 of 3 benchmarks became slower, 1 faster", True),
        (((1.1, 0.9), ()), "1 of 2 benchmarks became faster", False),
    ],
)
def test_the_headline_counts_last_steps(ratios, sentence, is_open):
    trends = make_trends(*(make_trend(f"bench_{k}", one) for k, one in enumerate(ratios)))
    text = trends_page.page(trends)
    assert f"{sentence}." in Parsed(text).text
    assert ('<header class="open">' in text) == is_open


@pytest.mark.parametrize(
    ("runs", "sentence"),
    [
        ((1,), "Too few runs to see a step: 1 of 6"),
        ((2, 5), "Too few runs to see a step: 5 of 6"),
        ((RUNS, 5), "No step in 2 benchmarks, 1 with too few runs"),
    ],
)
def test_too_few_runs_are_never_good(runs, sentence):
    trends = make_trends(*(make_trend(f"bench_{k}", runs=count) for k, count in enumerate(runs)))
    text = trends_page.page(trends)
    assert f"– {sentence}." in " ".join(Parsed(text).text.split())
    assert '<header class="open">' in text


def test_text_of_the_document_is_text(trends):
    trends.trends[0] = dataclasses.replace(trends.trends[0], name=EVIL, file=EVIL, peer=EVIL)
    trends.machine["processor"] = EVIL
    trends.runs[-1].revision = EVIL
    parsed = Parsed(trends_page.page(trends))
    assert parsed.broken == parsed.stack == []
    assert "script" not in {tag for tag, _ in parsed.tags}
    assert EVIL in parsed.text


def test_a_plot_marks_every_step_with_its_ratio():
    svg = trend_plot(make_trend(ratios=(0.8, 1.1)))
    root = xml.etree.ElementTree.fromstring(svg)
    words = " ".join(e.text or "" for e in root.iter() if e.tag.endswith("text")).replace("\xa0", " ")
    assert "1.25 × faster" in words
    assert "1.1 × slower" in words
    dashed = [e.get("style") for e in root.iter() if "stroke-dasharray" in (e.get("style") or "")]
    assert [style.count("--holds") + 2 * style.count("--fails") for style in dashed] == [1, 2]


def test_small_noise_does_not_fill_the_axis():
    low, high = span([1.0, 1.01])
    assert high - low > 0.2
    assert span([1.0, 3.0])[0] < 1.0 < 3.0 < span([1.0, 3.0])[1]
    assert span([1.0, 10.0])[0] >= 0.0


def test_the_page_is_written_beside_the_document(tmp_path, trends):
    (tmp_path / "trends.json").write_text(json.dumps(dataclasses.asdict(trends)), encoding="utf-8")
    assert read_trends(tmp_path / "trends.json") == trends
    done = CliRunner().invoke(main, [str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert sorted(path.name for path in tmp_path.iterdir()) == ["trends.html", "trends.json"]
    assert (tmp_path / "trends.html").read_text(encoding="utf-8") == trends_page.page(trends)


def test_what_is_interrupted_leaves_the_old_page(tmp_path, trends, monkeypatch):
    (tmp_path / "trends.json").write_text(json.dumps(dataclasses.asdict(trends)), encoding="utf-8")
    (tmp_path / "trends.html").write_text("the old page")

    def interrupted(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(trends_page, "page", interrupted)
    assert CliRunner().invoke(main, [str(tmp_path)]).exit_code != 0
    assert (tmp_path / "trends.html").read_text() == "the old page"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "trends.json does not exist; write it by `python -m benchmarks publish FOLDER`"),
        ("{", "is not JSON"),
        (json.dumps({"schema": "softbody-report/1"}), "softbody-report/1"),
        (json.dumps({"schema": "softbody-trends/1"}), "is damaged"),
    ],
)
def test_a_document_that_is_none_is_refused(tmp_path, text, words):
    if text is not None:
        (tmp_path / "trends.json").write_text(text)
    done = CliRunner().invoke(main, [str(tmp_path)])
    assert done.exit_code == 2
    assert words in done.output
    assert not (tmp_path / "trends.html").exists()
