"""Machine that was measured on: what bears on a timing, beside what pytest-benchmark writes of its own."""

from __future__ import annotations

import hashlib
import os
from importlib import metadata
from typing import Any

from pytest_benchmark.plugin import pytest_benchmark_generate_machine_info


def circumstances(level: str) -> dict[str, Any]:
    """Return versions, the digest of the core, flags, and how busy the machine is now."""
    from softbody.compiler.core_digest import CORE_DIGEST, FLAGS

    return {
        "core": CORE_DIGEST[:16],
        "level": level,
        "load": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
        "flags": {flag: os.environ[flag] for flag in (*FLAGS, "NUMBA_NUM_THREADS") if flag in os.environ},
        "versions": {name: metadata.version(name) for name in ("numba", "numpy", "llvmlite")},
    }


def checksum(machine_info: dict[str, Any]) -> str:
    """Return a name for a machine, from pytest-benchmark's description: the same for equal processors and systems."""
    cpu = machine_info.get("cpu") or {}
    what = [cpu.get("brand_raw"), cpu.get("count"), machine_info.get("machine"), machine_info.get("system")]
    return hashlib.sha256(repr(what).encode()).hexdigest()[:8]


def machine_here() -> str:
    """Return the checksum of this machine."""
    return checksum(pytest_benchmark_generate_machine_info())
