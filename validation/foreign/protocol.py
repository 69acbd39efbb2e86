"""How an engine in a Python of its own answers questions of ours: the protocol of validation/foreign/__init__.py.

Nothing of the suite is imported here: the environment has the engine, and NumPy.
"""

from __future__ import annotations

import json
import os
import struct
import sys
import time
from collections.abc import Callable
from contextlib import contextmanager
from typing import Any

import numpy as np

Answer = Callable[..., dict[str, np.ndarray]]
_spent = [0.0]


@contextmanager
def spending() -> Any:
    """Count what is done meanwhile as the engine's work."""
    begun = time.process_time()
    try:
        yield
    finally:
        _spent[0] += time.process_time() - begun


def serve(answers: dict[str, Answer]) -> None:
    """Answer questions until nobody asks: `answers` has a function for each, of its numbers and arrays as keywords."""
    answer_to = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what the engine prints is no answer
    while True:
        (length,) = struct.unpack("<d", _taken(8))
        asked = json.loads(_taken(int(length)))
        arrays = {name: _array(shape) for name, shape in asked["shapes"].items()}
        _spent[0] = 0.0
        try:
            rows = {
                k: np.ascontiguousarray(v, "<f8")
                for k, v in answers[asked["ask"]](**asked["numbers"], **arrays).items()
            }
            said: dict[str, Any] = {"shapes": {k: row.shape for k, row in rows.items()}, "seconds": _spent[0]}
        except Exception as error:
            said, rows = {"shapes": {}, "error": f"{type(error).__name__}: {error}"}, {}
        head = json.dumps(said).encode()
        answer_to.write(b"".join([struct.pack("<d", len(head)), head, *(row.tobytes() for row in rows.values())]))
        answer_to.flush()


def _taken(count: int) -> bytes:
    taken = sys.stdin.buffer.read(count)
    if len(taken) < count:
        sys.exit()  # nobody asks any more
    return taken


def _array(shape: list[int]) -> np.ndarray:
    return np.frombuffer(_taken(8 * int(np.prod(shape))), "<f8").reshape(shape)
