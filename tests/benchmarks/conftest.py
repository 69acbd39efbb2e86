"""What pytest-benchmark writes, in small."""

from __future__ import annotations

import pytest


def document(
    started="2030-01-01T00:00:00", ours=(1e-3, 2e-3, 1.5e-3), peer=(2e-3, 4e-3, 3e-3), brand="Some CPU", own=(), **more
):
    info = {
        "table": "Steps",
        "name": "softbody",
        "size": 42,
        "of": "particles",
        "per": "step",
        "units": 10,
        "errors": {},
        "own": list(own),
    }
    info["peers"] = {"a peer": {"units": 10, "seconds": list(peer)}} if peer else {}
    race = {"fullname": "benchmarks/bench_x.py::bench_x[42]", "extra_info": info, "stats": {"data": list(ours)}}
    machine = {"machine": "x86_64", "system": "Linux", "cpu": {"brand_raw": brand, "count": 2}}
    commit = {"id": "0123456789abcdef", "dirty": False}
    return {"datetime": started, "machine_info": machine, "commit_info": commit, "benchmarks": [race], **more}


@pytest.fixture
def make_document():
    return document
