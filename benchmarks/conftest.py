"""Options of the benchmarks."""

from __future__ import annotations

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add --level, which decides how many rounds a benchmark runs."""
    parser.addoption("--level", choices=["quick", "standard", "full"], default="standard")
