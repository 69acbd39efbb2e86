"""Motion of a scene, kept frame by frame, with energy and deepest overlap, for a page that turns it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from softbody import Camera, World
from softbody.render.drawing import Drawing, ground_of
from softbody.render.rasteriser import Thing

FINENESS = 2**11 - 1  # parts of the scene's largest extent: two millimetres in 4 m, less than half a pixel of a page


class Motion:
    """Frames of a world: where all that is drawn was, and what was measured then."""

    def __init__(self, world: World) -> None:
        self._world, self._drawing = world, Drawing(world)
        self._things: list[Thing] = []
        self._places: list[np.ndarray] = []
        self._cameras: list[tuple[tuple[float, ...], tuple[float, ...]]] = []
        self._measured: list[tuple[float, float, float]] = []

    def frame(self, camera: Camera, depths: Iterable[float]) -> None:
        """Keep the world as it is, seen by a camera; `depths` [m] are how deep things are in each other."""
        self._things = self._drawing.things()
        self._places.append(np.concatenate([thing.vertices for thing in self._things]))
        self._cameras.append((camera.eye, camera.target))
        self._view = camera.view
        self._measured.append((self._world.time, self._world.energy(), max(depths, default=0.0)))

    def save(self, path: Path, code: str) -> None:
        """Write an .npz of plain arrays; `code` made the scene. Places are right to half a part."""
        things, places = self._things, np.array(self._places)
        low = places.min(axis=(0, 1))
        part = float((places.max(axis=(0, 1)) - low).max()) / FINENESS
        height = ground_of(self._world)
        time, energy, depth = np.array(self._measured).T
        np.savez_compressed(
            path,
            code=np.array(code),
            time=time,
            energy=energy,
            depth=depth,
            camera=np.array(self._cameras),
            view=np.array(self._view),
            ground=np.array(np.nan if height is None else height),
            low=low,
            part=np.array(part),
            places=np.round((places - low) / part).astype(np.uint16),
            vertices=np.array([len(thing.vertices) for thing in things]),
            faces=np.array([len(thing.triangles) for thing in things]),
            triangles=np.concatenate([thing.triangles for thing in things]).astype(np.uint16),
            smooth=np.array([thing.smooth for thing in things]),
            clear=np.array([thing.is_clear for thing in things]),
            colours=np.array([np.broadcast_to(thing.colours, (2, 3)) for thing in things]),
            along=np.concatenate([along_of(thing) for thing in things]),
        )


def along_of(thing: Thing) -> np.ndarray:
    """Return which of a thing's two colours its vertices have (n,), by sign; 127 is as far as the farthest."""
    if thing.along is None:
        return np.full(len(thing.vertices), -1, np.int8)
    across = thing.along - 0.5
    return np.round(127.0 * across / max(float(np.abs(across).max()), 1e-300)).astype(np.int8)
