"""A copy of the core that is to be damaged, with the switch behind which each damage sleeps until it is woken."""

from __future__ import annotations

import ast
import shutil
from pathlib import Path

ROOT = Path(__file__).parents[1]

IMPORT = "from softbody.switch import is_awake"


def copy_core(folder: Path) -> Path:
    """Make `folder`/softbody a copy of the core, with a switch that is asked `is_awake(number)`; return it."""
    core = folder / "softbody"
    shutil.copytree(ROOT / "softbody", core, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(Path(__file__).with_name("switch.py"), core / "switch.py")
    return core


def add_imports(tree: ast.Module, *imports: str) -> None:
    """Put imports where a module may have them: after its docstring and what it takes from the future."""
    late = [k for k, node in enumerate(tree.body) if isinstance(node, ast.ImportFrom) and node.module == "__future__"]
    first = late[-1] + 1 if late else int(ast.get_docstring(tree) is not None)
    tree.body[first:first] = [node for each in imports for node in ast.parse(each).body]
