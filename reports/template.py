"""Page made from its template: one self-contained text, in the style and notation of all pages."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from reports import notation
from reports.trend_plots import sparkline

HERE = Path(__file__).parent
NOTATION = ("number", "faster", "count", "percent", "duration", "date", "section", "prose")


def rendered(template: str, **what: Any) -> str:
    """Return a template filled with what it names, and with the style sheet as `style`."""
    style = Markup((HERE / "page.css").read_text(encoding="utf-8"))
    return _environment().get_template(template).render(style=style, **what)


@cache
def _environment() -> Environment:
    """Return what keeps the templates, once they are compiled."""
    environment = Environment(
        loader=FileSystemLoader(HERE), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    own: dict[str, Callable[..., str]] = {
        "breakable": breakable,
        "with_code": with_code,
        "slug": slug,
        "sparkline": lambda trend: Markup(sparkline(trend)),
    }
    environment.filters |= {name: getattr(notation, name) for name in NOTATION} | own
    return environment


def slug(family: str) -> str:
    """Return the id of a family, for links to it."""
    return "family-" + re.sub(r"[^\w.-]+", "-", family)


def breakable(name: str) -> Markup:
    """Return an identifier that a narrow column may break after a dot or an underscore."""
    return Markup(re.sub(r"([._])(?=\w)", r"\1<wbr>", str(escape(name))))


def with_code(text: str) -> Markup:
    """Return a text in which what stands between backticks is code."""
    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text))))
