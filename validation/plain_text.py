"""Text from anywhere made fit for a terminal, JSON and XML: escaped, and of bounded length."""

from __future__ import annotations

import re

LONGEST = 2_000  # characters of one text: an engine may raise a text of any length

# What XML 1.0 cannot hold, and what moves a terminal's cursor; tab and line feed may stay.
_ODD = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")


def plain(text: object) -> str:
    """Return a text with its odd characters escaped, cut to LONGEST; what cannot be shown is said to be so."""
    try:
        shown = text if type(text) is str else str.__str__(str(text))
    except BaseException:  # by whoever wrote its __str__
        return f"({type(text).__name__} whose text cannot be shown)"
    cut = shown[:LONGEST]
    escaped = _ODD.sub(lambda odd: odd[0].encode("unicode_escape").decode(), cut)
    return escaped if len(cut) == len(shown) else f"{escaped} … ({len(shown)} characters)"
