"""Every claim says which piece of the core it is about."""

from __future__ import annotations

from pkgutil import resolve_name

from validation.check import all_checks


def test_the_pieces_of_all_claims_are_there() -> None:
    gone = []
    for check in all_checks().values():
        for piece in check.piece.split(", "):
            try:
                resolve_name(piece)
            except (ImportError, AttributeError):
                gone.append((check.id, piece))
    assert not gone
