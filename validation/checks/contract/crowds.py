"""Worlds whose bodies come and go, for claims about files: which bodies there are is told beside, in plain arrays."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import softbody
from softbody import Mesh, World
from validation.cases import random_orientations

STEP = 1e-3  # [s]


class Crowd:
    """Bodies far from each other, of which some have names; `change` adds, removes or replaces one."""

    def __init__(self, rng: np.random.Generator, least: int = 0) -> None:
        self.world, self._rng, self._least, self.added = World(integrator="rk4"), rng, least, 0
        self.soft: list[tuple[softbody.SoftBody, Mesh]] = []
        self.boxes: list[tuple[softbody.Box, np.ndarray]] = []
        self.add_soft()
        self.add_box()

    def add_soft(self, name: str | None = None) -> None:
        """Add a soft body."""
        torus = softbody.torus(1.0, self._rng.uniform(0.2, 0.8), *self._rng.integers(3, 12, 2).tolist())
        mesh = [softbody.octahedron(), softbody.tetrahedron(), torus][self._rng.integers(3)]
        place, speed = self._free(), self._rng.normal(size=3)
        body = self.world.add_soft_body(mesh, 1.0, 1.0, 0.0, place, speed, name=name or self._name("soft"))
        self.soft.append((body, mesh))

    def add_box(self, name: str | None = None, size: np.ndarray | None = None) -> None:
        """Add a box."""
        size = self._rng.uniform(0.2, 1.0, 3) if size is None else size
        turn = random_orientations(self._rng, 1)[0]
        name = name or self._name("box")
        box = self.world.add_box(size, 1.0, self._free(), turn, self._rng.normal(size=3), name=name)
        self.boxes.append((box, size))

    def remove(self, is_soft: bool, number: int) -> str | None:
        """Remove a soft body or a box; return its name."""
        those: list[Any] = self.soft if is_soft else self.boxes
        gone, _ = those.pop(number)
        name: str | None = gone.name
        self.world.remove(gone)
        return name

    def swap(self) -> None:
        """Let another box be there in place of the last one: of the same size, and another name."""
        if self.boxes:
            _, size = self.boxes[-1]
            self.remove(False, -1)
            self.add_box(f"other of {self.added}", size)

    def change(self) -> None:
        """Let other bodies be there: one more, one less, or another one, perhaps of the same name."""
        is_soft, way = bool(self._rng.random() < 0.5), self._rng.integers(3)
        count, name = len(self.soft if is_soft else self.boxes), None
        if way and count > self._least:
            name = self.remove(is_soft, int(self._rng.integers(count)))
            if way == 2:
                return
        (self.add_soft if is_soft else self.add_box)(name if self._rng.random() < 0.7 else None)

    def advance(self) -> None:
        """Go on by a step, if there is anything to move."""
        if self.soft or self.boxes:
            self.world.step(STEP)
        else:
            self.world.time += STEP

    def saved(self, path: Path) -> Crowd:
        """Return another such world, as this one is: saved, and loaded."""
        self.world.save(path)
        other = Crowd(self._rng, self._least)
        other.world, other.added = World.load(path), self.added
        other.soft = [(body, mesh) for body, (_, mesh) in zip(other.world.soft_bodies, self.soft)]
        other.boxes = [(box, size) for box, (_, size) in zip(other.world.boxes, self.boxes)]
        return other

    def what(self) -> list[object]:
        """Return which bodies there are: their names, triangles and sizes."""
        names = [body.name for body, _ in (*self.soft, *self.boxes)]
        return [names, *(mesh.triangles for _, mesh in self.soft), *(size for _, size in self.boxes)]

    def where(self) -> list[object]:
        """Return what a frame must have of them: time, positions and velocities, of boxes with turns."""
        soft, boxes = [body for body, _ in self.soft], [box for box, _ in self.boxes]
        rows = [
            self._rows([body.positions for body in soft], 3),
            self._rows([body.velocities for body in soft], 3),
            self._rows([box.position[None] for box in boxes], 3),
            self._rows([box.orientation[None] for box in boxes], 4),
            self._rows([box.velocity[None] for box in boxes], 3),
            self._rows([box.angular_velocity[None] for box in boxes], 3),
        ]
        return [self.world.time, *rows]

    def titles(self) -> list[str]:
        """Return what its bodies are called in exported files."""
        soft = [body.name or f"soft_body_{k}" for k, (body, _) in enumerate(self.soft)]
        return soft + [box.name or f"box_{k}" for k, (box, _) in enumerate(self.boxes)]

    def _rows(self, parts: list[np.ndarray], columns: int) -> np.ndarray:
        return np.concatenate([np.zeros((0, columns)), *parts])

    def _free(self) -> np.ndarray:
        """Return a place where nobody is."""
        self.added += 1
        return np.array([10.0 * self.added, 0.0, 0.0])

    def _name(self, kind: str) -> str | None:
        return f"{kind} of {self.added}" if self._rng.random() < 0.6 else None


def what_in(bodies: softbody.Bodies) -> list[object]:
    """Return the same of the bodies of a frame as `Crowd.what`."""
    triangles = [bodies.triangles(k) for k in range(bodies.soft_count)]
    return [[*bodies.soft_names, *bodies.box_names], *triangles, *bodies.box_sizes]


def where_in(frame: softbody.Frame) -> list[object]:
    """Return the same of a frame as `Crowd.where`."""
    soft, boxes = [frame.positions, frame.velocities], [frame.box_positions, frame.box_orientations]
    return [frame.time, *soft, *boxes, frame.box_velocities, frame.box_angular_velocities]


def bits_of(told: list[object]) -> list[bytes]:
    """Return the bits of arrays and numbers, and of names."""
    return [repr(each).encode() if isinstance(each, list) else np.asarray(each).tobytes() for each in told]
