"""Print the README's Python example: `python tests/readme_example.py README.md`."""

from __future__ import annotations

import re
import sys
from pathlib import Path


def readme_example(readme: Path) -> str:
    """Return the first block of Python in a Markdown file."""
    found = re.search(r"```python\n(.*?)```", readme.read_text(encoding="utf-8"), re.DOTALL)
    if found is None:
        raise ValueError(f"{readme} has no Python example")
    return found.group(1)


if __name__ == "__main__":
    print(readme_example(Path(sys.argv[1])))
