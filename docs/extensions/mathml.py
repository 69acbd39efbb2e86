"""Formulas without a network: MathML, which browsers draw themselves, made by docutils."""

from __future__ import annotations

from typing import Any

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx


def setup(app: Sphinx) -> dict[str, bool]:
    """Make this the way in which formulas are shown."""
    app.add_html_math_renderer("mathml", (show_inline, None), (show_block, None))
    return {"parallel_read_safe": True}


def show_inline(page: Any, node: nodes.math) -> None:
    """Write a formula within a line."""
    page.body.append(tex2mathml(node.astext()))
    raise nodes.SkipNode


def show_block(page: Any, node: nodes.math_block) -> None:
    """Write a formula on a line of its own."""
    formula = tex2mathml(node.astext()).replace("<math", '<math display="block"', 1)
    page.body.append(f'<div class="formula">{formula}</div>')
    raise nodes.SkipNode
