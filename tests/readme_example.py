"""Print the README's first Python example: `python tests/readme_example.py README.md`."""

from __future__ import annotations

import re
import sys
from pathlib import Path


def python_blocks(page: Path) -> list[str]:
    """Return all blocks of Python in a Markdown file."""
    return re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


def readme_example(readme: Path) -> str:
    """Return the first block of Python in a Markdown file."""
    blocks = python_blocks(readme)
    if not blocks:
        raise ValueError(f"{readme} has no Python example")
    return blocks[0]


if __name__ == "__main__":
    print(readme_example(Path(sys.argv[1])))
