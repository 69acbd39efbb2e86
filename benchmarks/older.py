"""Cores from before their files moved, by today's names: so that benchmarks of today time revisions of then."""

from __future__ import annotations

import importlib
import sys
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

MOVED = {  # what benchmarks import, by today's names → those of then; "" for a folder that there was none of
    "softbody.bodies": "",
    "softbody.collision.boxes": "",
    "softbody.collision.boxes.manifold": "softbody.collision.manifold",
    "softbody.collision.boxes.sat_boxes": "softbody.collision.sat_boxes",
    "softbody.collision.soft": "",
    "softbody.collision.soft.soft_contacts": "softbody.collision.soft_contacts",
    "softbody.collision.soft.soft_response": "softbody.collision.soft_response",
    "softbody.collision.soft.split_steps": "softbody.collision.substeps",
    "softbody.collision.soft.surface": "softbody.collision.surface",
    "softbody.compiler": "",
    "softbody.compiler.core_digest": "softbody.core_digest",
    "softbody.compiler.jit": "softbody.jit",
    "softbody.model": "",
    "softbody.model.arrays": "softbody.state",
    "softbody.model.settings": "softbody.settings",
    "softbody.stepping": "",
    "softbody.stepping.step": "softbody.step",
    "softbody.storage": "",
    "softbody.storage.snapshot": "softbody.snapshot",
}


class _Then(MetaPathFinder, Loader):
    """Finds modules of MOVED that are not in this core by their names of then; asked after all others."""

    def find_spec(self, name: str, path: Any, target: ModuleType | None = None) -> ModuleSpec | None:
        """Return what makes the module, if it is one of those."""
        return ModuleSpec(name, self, is_package=not MOVED[name]) if name in MOVED else None

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        """Return the module of then, or an empty folder."""
        return importlib.import_module(MOVED[spec.name]) if MOVED[spec.name] else None

    def exec_module(self, module: ModuleType) -> None:
        """Do nothing: it was run when it was made."""


def understand() -> None:
    """Let modules be imported by today's names, and a World of then be its own store."""
    sys.meta_path.append(_Then())
    import softbody

    world: Any = getattr(softbody, "World", None)
    if world is not None and not hasattr(world, "store"):
        world.store = property(lambda each: each)
