"""Errata of the paper that a run has no numbers for, with reasons: unrun claims', and three more."""

from __future__ import annotations

from collections.abc import Iterable

from validation.check import Check, all_checks
from validation.plain_text import plain
from validation.record import OpenErratum

# What cannot be wrong by an amount: no claim evaluates it.
UNMEASURED = (
    OpenErratum(
        "E4",
        "j divided by n², the square of the normal’s length",
        "n has length 1: there is nothing to divide by",
        "both forms are the same number for normals of length 1, and the core has no others",
    ),
    OpenErratum(
        "E15",
        "volumes of tetrahedra are added to the “total velocity”",
        "to the total volume",
        "a slip of words, without a formula that could be evaluated",
    ),
    OpenErratum(
        "E22",
        "a ground is mentioned, and never defined",
        "a half-space",
        "a gap, without a formula; what the ground does is judged by the claims on softbody.dynamics.particle_ground",
    ),
)


def open_errata(checks: Iterable[Check]) -> list[OpenErratum]:
    """Return the errata that a run of some checks does not measure, each with the reason, in order of their numbers."""
    running = {check.id for check in checks}
    left_out = [
        OpenErratum(
            plain(check.erratum.id),
            plain(check.erratum.prints),
            plain(check.erratum.right),
            f"its claim, {plain(check.id)}, is not part of this run",
        )
        for check in all_checks().values()
        if check.erratum and check.id not in running
    ]
    return sorted([*UNMEASURED, *left_out], key=lambda each: (len(each.id), each.id))
