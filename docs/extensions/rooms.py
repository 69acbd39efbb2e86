"""Modules of a room of the core, all documented by `{room} softbody.geometry`, so that none is forgotten."""

from __future__ import annotations

import importlib
import pkgutil
from typing import ClassVar

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


class Room(SphinxDirective):
    """`{room} PACKAGE`: a section for each of its modules, but for those to `:leave-out:`."""

    required_arguments = 1
    option_spec: ClassVar = {"leave-out": str.split}

    def run(self) -> list[nodes.Node]:
        """Return the sections."""
        package = importlib.import_module(self.arguments[0])
        root = f"{package.__name__}."
        here = [
            each.name.removeprefix(root) for each in pkgutil.walk_packages(package.__path__, root) if not each.ispkg
        ]
        names = [name for name in here if name not in self.options.get("leave-out", ())]
        text = "\n\n".join(
            f"## {name.replace('.', '/')}\n\n```{{eval-rst}}\n.. automodule:: {root}{name}\n   :members:\n```"
            for name in names
        )
        return self.parse_text_to_nodes(text, allow_section_headings=True)


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the directive."""
    app.add_directive("room", Room)
    return {"parallel_read_safe": True}
