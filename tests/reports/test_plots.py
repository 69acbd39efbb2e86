"""Do the plots show the errors, the tolerance and the costs, and nothing of the machine that drew them?"""

import xml.etree.ElementTree

import numpy as np
import pytest

from reports.plots import error_plot, series, timing_plot, work_plot
from validation.record import Distribution, Timing


@pytest.fixture
def errors():
    return 10.0 ** np.random.default_rng(1).normal(-14, 0.5, 500)


def test_a_plot_is_small_clean_and_well_formed(claim_of, errors):
    svg = error_plot(claim_of(0, errors), "a")
    xml.etree.ElementTree.fromstring(svg)
    assert len(svg) < 20_000
    for unwanted in ("http", "xmlns", "<style", "<metadata", "font-family", "clip-path", "#0"):
        assert unwanted not in svg


def test_the_same_claim_gives_the_same_bytes(claim_of, errors):
    assert error_plot(claim_of(0, errors), "a") == error_plot(claim_of(0, errors), "a")


def test_ids_differ_between_plots_of_a_page(claim_of, errors):
    def ids(svg):
        return {e.get("id") for e in xml.etree.ElementTree.fromstring(svg).iter()} - {None}

    a, b = ids(error_plot(claim_of(0, errors), "a")), ids(error_plot(claim_of(0, errors), "b"))
    assert a
    assert not a & b


def test_tolerance_unit_and_zeros_are_labelled(claim_of, errors):
    errors[:100] = 0.0
    words = text_of(error_plot(claim_of(0, errors, 1.25e-3, "m/s"), "a"))
    assert "tolerance 0.00125" in words
    assert "error [m/s]" in words
    assert "0" in words


def test_a_unit_is_text_and_never_markup_or_mathematics(claim_of, errors):
    assert "error [$x^2$ <b>]" in text_of(error_plot(claim_of(0, errors, unit="$x^2$ <b>"), "a"))


def test_only_bars_beyond_the_tolerance_are_red(claim_of, errors):
    holds, fails = error_plot(claim_of(0, errors, 1e-9), "a"), error_plot(claim_of(0, errors, 1e-14), "a")
    assert "fill: var(--holds)" in holds
    assert "fill: var(--holds)" in fails
    assert bars(holds, "--fails") == 0
    assert bars(fails, "--fails") == 1


@pytest.mark.parametrize("tolerance", [0.0, 1e-300, 1e-12, 1e300, None])
def test_any_errors_can_be_drawn(claim_of, tolerance):
    for sample in ([0.0], [0.0, 1e-12], [1e-12], [1e-310, 1e300], [5e-324]):
        claim = claim_of(0, np.array(sample), tolerance)
        assert error_plot(claim, "a") is None or "<svg" in error_plot(claim, "a")


def test_without_finite_errors_there_is_no_plot(claim_of):
    assert error_plot(claim_of(0, np.ones(3), errors=None), "a") is None
    assert error_plot(claim_of(0, np.ones(3), errors=Distribution({}, 0, [], [])), "a") is None


def timing(name, size, *costs):
    return Timing("a step", name, size, "particles", "particle", *costs, rounds=5)


def test_costs_are_drawn_a_series_a_name():
    rows = [timing(name, n, 20.0, 18.0, 25.0) for name in ("rk4", "$euler$") for n in (642, 163842)]
    svg = timing_plot(rows)
    assert {"--series-1", "--series-2"} <= {f"--series-{n}" for n in range(7) if f"var(--series-{n})" in svg}
    assert "163\u202f842" in text_of(svg)


def test_more_names_than_colours_still_look_different():
    looks = series([timing(str(n), 642, 20.0, None, None) for n in range(20)])
    assert len(set(looks.values())) == 20


def test_errors_are_drawn_against_costs():
    rows = [timing(name, n, 20.0 * n, None, None) for name in ("rk4", "euler") for n in (10, 20, 40)]
    assert work_plot(rows) is None
    for row in rows:
        row.error = 1.0 / row.size
    svg = work_plot(rows)
    assert "relative error" in text_of(svg)
    assert "ns per particle" in text_of(svg)


def test_costs_that_are_no_numbers_are_left_out():
    assert timing_plot([]) is None
    assert timing_plot([timing("a", 642, None, None, None)]) is None
    assert "<svg" in timing_plot([timing("a", 642, 20.0, None, None), timing("a", 0, None, None, None)])


def text_of(svg):
    return [e.text for e in xml.etree.ElementTree.fromstring(svg).iter() if e.tag.endswith("text")]


def bars(svg, colour):
    tree = xml.etree.ElementTree.fromstring(svg)
    return sum(e.tag.endswith("path") and e.get("style") == f"fill: var({colour})" for e in tree.iter())
