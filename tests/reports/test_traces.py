"""Does the page say which claims judge which piece, and which pieces nobody from outside judges?"""

from __future__ import annotations

import numpy as np
import pytest

from reports.page import page
from reports.traces import in_order, parts_of
from tests.reports.parsed import Parsed
from validation.record import NOT_RUN, Erratum, OpenErratum, PlantedFault, Sensitivity

ERRORS = np.array([1e-15])


@pytest.fixture
def traced(report, claim_of):
    """A report whose claims are about four pieces in three sections."""
    report.claims = [
        claim_of(0, ERRORS, id="a", piece="core.one", section="10.4", kind="closed form", faults=["sign", "half"]),
        claim_of(0, ERRORS, id="b", piece="core.one, core.two", section="2.3, 10.4", kind="invariant", faults=["sign"]),
        claim_of(0, ERRORS, id="c", piece="core.three", section="beyond the paper", kind="bound"),
        claim_of(0, ERRORS, id="d", piece="core.four", section="2.3", kind="exact arithmetic", verdict=NOT_RUN, n=0),
    ]
    return report


def traces(report) -> str:
    text = Parsed(page(report)).text
    start = text.index("Paper, pieces, claims")
    return text[start : text.index("Errata of the paper", start)]


def test_pieces_that_nobody_from_outside_has_judged_are_counted_and_listed(traced):
    text = traces(traced)
    assert "4 claims of this run judge 4 pieces of the core" in text
    assert "3 pieces have none" in text
    listed = text[text.index("The 3 without") : text.index("Section of the paper ×")]
    assert [name in listed for name in ("core.one", "core.two", "core.three", "core.four")] == [False, True, True, True]
    assert "d (exact arithmetic, not run)" in listed
    assert "3 of 4 pieces of the core have no judge from outside" in Parsed(page(traced)).text


def test_sections_stand_in_the_order_of_the_paper(traced):
    text = traces(traced)
    table = text[text.index("Section of the paper ×") :]
    assert table.index("§2.3") < table.index("§10.4") < table.index("beyond the paper")
    assert sorted(["beyond", "10.4", "2", "2.3", "4.10", "4.9"], key=in_order) == [
        "2", "2.3", "4.9", "4.10", "10.4", "beyond",
    ]  # fmt: skip


def test_each_piece_links_to_its_claims_and_tells_of_its_faults(traced):
    found = Parsed(page(traced))
    assert {"#claim-a", "#claim-b", "#claim-c", "#claim-d"} <= set(found.all("href"))
    assert "2, not tried" in traces(traced)
    assert "not recorded" in traces(traced)
    traced.sensitivity = Sensitivity(
        [PlantedFault("sign", "core", ["a", "b"], "caught"), PlantedFault("half", "core", ["a"], "escaped")]
    )
    assert "1 of 2 caught" in traces(traced)


def test_functions_that_no_claim_is_about_are_named(traced):
    assert "public function" not in traces(traced)
    traced.unnamed = ["core.World.run"]
    assert "1 public function that no claim is about" in traces(traced)
    assert "core.World.run" in traces(traced)


def test_records_of_before_and_of_no_claims_make_a_page(traced):
    for claim in traced.claims:
        claim.kind = ""
    assert "1 piece has none" in traces(traced), "nobody knows who judged, but of one that was not run"
    for claim in traced.claims:
        claim.piece = " , "
    assert "Paper, pieces, claims" not in Parsed(page(traced)).text
    traced.claims = []
    assert "Paper, pieces, claims" not in Parsed(page(traced)).text


def test_a_text_of_commas_is_not_a_million_sections():
    assert len(parts_of(",".join(map(str, range(100_000))))) < 30


def test_every_erratum_has_a_row_and_says_whether_it_is_confirmed(traced):
    traced.claims[0].erratum = Erratum("E2", "x", "y", 1.0, 0.5, 0.25)
    traced.claims[2].erratum = Erratum("E3", "x", "y", 1.0, 0.0, 0.0)
    traced.claims[3].erratum = Erratum("E10", "x", "y")
    traced.open_errata = [OpenErratum("E4", "divides", "does not", "both are the same"), OpenErratum("", "", "", "?")]
    found = Parsed(page(traced))
    assert found.broken == found.stack == []
    text = found.text[found.text.index("Errata of the paper") :]
    assert (
        "5 formulas of the paper are wrong or missing as printed: 1 confirmed, 1 not confirmed, 3 not measured" in text
    )
    assert text.index("E2 ") < text.index("E3 ") < text.index("E4") < text.index("E10 ")
    assert "both are the same" in text
    assert "Matyka" in text
