"""Compiles the core ahead of its first use: `python -m softbody warmup`."""

from __future__ import annotations

import sys
from time import perf_counter

from softbody.warmup import warm_up


def main() -> int:
    """Return 0, or 2 for wrong usage."""
    if sys.argv[1:] != ["warmup"]:
        print("usage: python -m softbody warmup", file=sys.stderr)
        return 2
    start = perf_counter()
    warm_up()
    print(f"machine code is ready ({perf_counter() - start:.1f} s)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
