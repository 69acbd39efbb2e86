"""Rates are those of the verdicts on what was recorded; a planted slow-down is real, and changes no answer."""

from __future__ import annotations

import click
import numpy as np
import pytest

from benchmarks.calibration import DRAWN, Calibration, from_document, rate_of
from benchmarks.cores import digest_of
from benchmarks.planted import BEFORE, slower
from benchmarks.sides import Side, checked_out


def sessions(mean, noise, count=15, between=0.0, seed=0):
    rng = np.random.default_rng(seed)
    return [(mean + between * rng.normal() + noise * rng.normal(size=4)).tolist() for _ in range(count)]


def test_rates_count_verdicts():
    assert rate_of(0, {"bench": sessions(0.0, 0.01)}).found == 0
    assert rate_of(3, {"bench": sessions(0.03, 0.01)}).found == DRAWN
    assert rate_of(10, {"bench": sessions(-0.1, 0.01)}).found == 0  # faster is not what was planted
    both = rate_of(3, {"a": sessions(0.03, 0.01), "b": sessions(0.0, 0.01), "never opened": []})
    assert (both.found, both.comparisons, both.openings) == (DRAWN, 2 * DRAWN, 120)


def test_what_processes_have_by_chance_makes_false_alarms_and_they_are_counted():
    assert rate_of(0, {str(k): sessions(0.0, 0.002, between=0.05, seed=k) for k in range(5)}).found > 0


def test_a_calibration_comes_back_from_its_document():
    calibration = Calibration("2030-01-01T00:00:00", "abc", 1.5, 60.0, {"0": {"bench": sessions(0.0, 0.01)}})
    assert from_document(calibration.document()) == calibration
    assert "2030-01-01, load 1.5: false alarms in 0.0 % of 60" in str(calibration)


def test_a_gate_stops_what_is_estimated_to_be_slower_than_it_allows():
    series = {"0": {"bench": sessions(0.0, 0.01)}, "3": {"bench": sessions(0.03, 0.01)}}
    calibration = Calibration("2030-01-01T00:00:00", "abc", 1.5, 60.0, series)
    stops = "stops, by that calibration, 0.0 % of benchmarks as fast as before"
    assert calibration.gate(0.02) == f"--fail-slower 2% {stops}, 100.0 % of benchmarks slowed by 3 %"
    assert "--fail-slower 4.5%" in calibration.gate(0.045)
    assert "0.0 % of benchmarks slowed by 3 %" in calibration.gate(0.045)


@pytest.fixture
def core(tmp_path):
    from benchmarks.cli import ROOT

    return checked_out(".", ROOT, tmp_path)


def test_a_slow_down_is_planted_in_a_core_of_its_own(core):
    planted = slower(core, 3)
    assert planted.folder != core.folder
    assert digest_of(planted.folder / "softbody") == planted.folder.name
    lines = (planted.folder / "softbody" / "stepping" / "step.py").read_text().splitlines()
    kernel = (core.folder / "softbody" / "stepping" / "step.py").read_text().splitlines()
    added = [line.strip() for line in lines if line not in kernel]
    assert added == [
        "spare = copied(state)",
        "move_soft_bodies(soft_bodies_of(model, controls, spare), motion, settings, h, (steps * 3 + 50) // 100)",
    ]
    assert slower(core, 3) == planted


def test_a_core_that_reads_otherwise_is_refused(core):
    kernel = core.folder / "softbody" / "stepping" / "step.py"
    kernel.write_text(kernel.read_text().replace(BEFORE, ""))
    with pytest.raises(click.ClickException, match="no slow-down can be planted"):
        slower(Side("x", "x", core.folder), 3)


def test_the_same_core_is_laid_out_once(core, tmp_path):
    from benchmarks.cli import ROOT

    assert checked_out(".", ROOT, tmp_path) == core
    assert [path.name for path in tmp_path.iterdir()] == [core.folder.name]
    assert (core.folder / "softbody" / "world.py").read_text() == (ROOT / "softbody" / "world.py").read_text()
