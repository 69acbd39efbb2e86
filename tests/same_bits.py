"""Do two worlds, states or arrays have the same bits?"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from softbody import World

Some = World | Mapping[str, np.ndarray] | Iterable[np.ndarray] | np.ndarray


def same_bits(one: Some, other: Some) -> bool:
    """Tell whether all arrays are alike in kind, shape and every bit; of worlds, those of their snapshots."""
    mine, its = _arrays(one), _arrays(other)
    return len(mine) == len(its) and all(
        a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes() for a, b in zip(mine, its)
    )


def _arrays(some: Some) -> list[np.ndarray]:
    if isinstance(some, np.ndarray):
        return [some]
    rows = some.snapshot() if isinstance(some, World) else some
    if isinstance(rows, Mapping):
        rows = [rows[name] for name in sorted(rows)]
    return [np.asarray(row) for row in rows]
