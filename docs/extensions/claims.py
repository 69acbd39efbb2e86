"""Claims in the pages: what there is, who judges, and which function; from the claims, never by hand.

Where a run has left its record in build/report, what it found stands beside each claim.
"""

from __future__ import annotations

from collections import defaultdict
from functools import cache
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from reports.notation import count, number
from validation.check import Check, all_checks
from validation.errata import UNMEASURED
from validation.record import KINDS, ClaimRecord, Report, read_report

RECORD = Path(__file__).parents[2] / "build" / "report" / "report.json"
MOST_LISTED = 12  # claims beside a function or module: those of soft_response alone are more than a screen


@cache
def record() -> Report | None:
    """Return what the last run of all claims has left, if there was one."""
    report = read_report(RECORD) if RECORD.is_file() else None
    return report if report and not report.patterns else None


@cache
def found() -> dict[str, ClaimRecord]:
    """Return what became of each claim, by its id."""
    report = record()
    return {claim.id: claim for claim in report.claims} if report else {}


def words(text: str) -> list[nodes.Node]:
    """Return a text whose `code` stands in backticks."""
    parts = text.split("`")
    return [nodes.literal("", part) if k % 2 else nodes.Text(part) for k, part in enumerate(parts) if part]


def label(claim: Check) -> str:
    """Return the name by which pages refer to a claim."""
    return f"claim-{claim.id}"


class Families(SphinxDirective):
    """`{claims}`: a section for each family, with all that its claims say of themselves."""

    def run(self) -> list[nodes.Node]:
        """Return the sections."""
        families: dict[str, list[Check]] = defaultdict(list)
        for claim in all_checks().values():
            families[claim.family].append(claim)
        return [self._section(family, claims) for family, claims in families.items()]

    def _section(self, family: str, claims: list[Check]) -> nodes.section:
        title = family[0].upper() + family[1:]
        entries = nodes.definition_list("", *[self._entry(claim) for claim in claims], classes=["claims"])
        return nodes.section(
            "", nodes.title("", title), entries, ids=[nodes.make_id(f"family-{family}")], names=[title]
        )

    def _entry(self, claim: Check) -> nodes.definition_list_item:
        target = nodes.make_id(label(claim))
        self.env.domains.standard_domain.note_hyperlink_target(label(claim), self.env.docname, target, claim.claim)
        facts = {
            "Judge": words(claim.reference if claim.kind in claim.reference else f"{claim.kind}: {claim.reference}"),
            "Tolerance": words(f"{number(claim.tolerance)} {claim.unit}: {claim.because}"),
            "Piece": self._links(claim.piece),
            "Turns red at": words("; ".join(fault.name for fault in claim.faults)),
            "Found": self._found(claim),
            "Name": [nodes.literal("", claim.id)],
        }
        more = [nodes.paragraph("", "", *words(claim.detail))] if claim.detail else []
        lines = [nodes.line("", "", nodes.strong("", f"{name} "), *what) for name, what in facts.items() if what]
        return nodes.definition_list_item(
            "",
            nodes.term("", "", *words(claim.claim), ids=[target]),
            nodes.definition("", *more, nodes.line_block("", *lines)),
        )

    def _links(self, pieces: str) -> list[nodes.Node]:
        """Return a link to each piece of the core that a claim names, where it is documented."""
        links: list[nodes.Node] = []
        for piece in pieces.split(", "):
            xref = addnodes.pending_xref(
                "", nodes.literal("", piece), refdomain="py", reftype="obj", reftarget=piece, refdoc=self.env.docname
            )
            links += [nodes.Text(", "), xref] if links else [xref]
        return links

    @staticmethod
    def _found(claim: Check) -> list[nodes.Node]:
        last = found().get(claim.id)
        if last is None:
            return []
        return [nodes.Text(f"{last.verdict}; largest error {number(last.value)} in {count(last.n)} comparisons")]


class Judges(SphinxDirective):
    """`{judges}`: how many claims each kind of judge decides, and where their verdicts are from."""

    def run(self) -> list[nodes.Node]:
        """Return a table and a paragraph."""
        claims = all_checks().values()
        decided = {kind: sum(claim.kind == kind for claim in claims) for kind in KINDS}
        rows = [[kind, what, str(decided[kind])] for kind, what in KINDS.items()]
        faults = len({(fault.place, fault.find, fault.put, fault.nth) for claim in claims for fault in claim.faults})
        summary = f"{len(claims)} claims, and {faults} different faults of the core that must turn them red. "
        report = record()
        if report is None:
            summary += "No run of all claims has left its record here: after `make report` the next build shows it."
        else:
            holding = sum(claim.verdict == "holds" for claim in report.claims)
            summary += f"The last run here, of {report.created[:10]} at level {report.level}: {holding} hold."
        return [table(["judge", "what it is", "claims"], rows), *self.parse_text_to_nodes(summary)]


class Errata(SphinxDirective):
    """`{errata}`: what the paper prints, what is right, and the claim that shows it, or why none does."""

    def run(self) -> list[nodes.Node]:
        """Return a table."""
        rows = [
            [each.erratum.id, f"§{each.section}", each.erratum.prints, each.erratum.right, link(self, each)]
            for each in all_checks().values()
            if each.erratum
        ]
        rows += [[each.id, "", each.prints, each.right, f"no claim: {each.why}"] for each in UNMEASURED]
        rows.sort(key=lambda row: int(row[0][1:]))
        return [table(["", "section", "as printed", "right", "shown by"], rows)]


def link(directive: SphinxDirective, claim: Check) -> nodes.Node:
    """Return a link to a claim."""
    return addnodes.pending_xref(
        "",
        nodes.inline("", "this claim"),
        refdomain="std",
        reftype="ref",
        reftarget=label(claim).lower(),
        refexplicit=True,
        refdoc=directive.env.docname,
    )


def table(head: list[str], rows: list[list[str | nodes.Node]]) -> nodes.table:
    """Return a table of texts and inline nodes."""

    def line(cells: list[Any]) -> nodes.row:
        inner = [each if isinstance(each, nodes.Node) else nodes.Text(each) for each in cells]
        return nodes.row("", *[nodes.entry("", nodes.paragraph("", "", each)) for each in inner])

    group = nodes.tgroup("", *[nodes.colspec(colwidth=1) for _ in head], cols=len(head))
    group += nodes.thead("", line(head))
    group += nodes.tbody("", *[line(row) for row in rows])
    return nodes.table("", group)


@cache
def judging() -> dict[str, list[Check]]:
    """Return the claims that judge each piece of the core, by its dotted name."""
    by_piece: dict[str, list[Check]] = defaultdict(list)
    for claim in all_checks().values():
        for piece in claim.piece.split(", "):
            by_piece[piece].append(claim)
    return by_piece


def add_claims(app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Add to a docstring the claims that judge its function."""
    claims = judging().get(name, [])
    if not claims:
        return
    lines += ["", f"Judged by {len(claims)} {'claim' if len(claims) == 1 else 'claims'}:", ""]
    for claim in claims[:MOST_LISTED]:
        sentence = claim.claim.replace("`", "").replace("<", "‹").replace("\\", "")
        lines.append(f"* :ref:`{sentence} <{label(claim)}>`")
    if len(claims) > MOST_LISTED:
        lines += ["", f"and by {len(claims) - MOST_LISTED} more of :doc:`the list </verified>`."]
    lines.append("")


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the directives, and let autodoc list the claims."""
    app.add_directive("claims", Families)
    app.add_directive("judges", Judges)
    app.add_directive("errata", Errata)
    app.connect("autodoc-process-docstring", add_claims, priority=600)
    return {"parallel_read_safe": True}
