"""What do the scenes look like? Runs each and leaves a still and a looping animation."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import softbody
from softbody import Box, SoftBody, World
from softbody.quaternion import rotate
from softbody.scenes import (
    ball_drop,
    box_pile,
    box_stack,
    boxes_on_torus,
    rolling_torus,
    sphere_on_torus,
    torus_stack,
    tray,
)
from validation.record import Picture
from validation.render import Camera, Thing, render

FRAMES_A_SECOND = 20
STEP = 0.8  # of the stable time step
BOX_STEP = 1.0 / 240.0  # [s] at most, where there are boxes

COLOURS = [(0.86, 0.44, 0.24), (0.24, 0.50, 0.80), (0.38, 0.64, 0.36), (0.75, 0.60, 0.22), (0.58, 0.40, 0.70)]


NEAR, HIGH = Camera((3.6, -5.2, 3.0), (0.0, 0.0, 0.7)), Camera((5.2, -7.5, 4.2), (0.0, 0.0, 1.4))
LOW = Camera((1.0, -8.5, 3.0), (0.0, 0.0, 1.2))
FRONT, ABOVE = Camera((1.0, -6.5, 1.8), (0.0, 0.0, 0.8)), Camera((4.5, -7.5, 7.5), (0.0, 0.0, 0.7))


@dataclass(frozen=True)
class Scene:
    """A world to film: for how long, from where, and whether the camera follows the first body along x."""

    name: str
    caption: str
    build: Callable[[], World]
    camera: Camera
    follow: bool = False
    seconds: float = 2.5


# The paper's (§9), then others.
SCENES = [
    Scene("sphere-on-torus", "A soft sphere comes to rest on a soft torus.", sphere_on_torus.build, NEAR),
    Scene("rolling-torus", "A soft torus rolls, pushed by half its weight.", rolling_torus.build, LOW, follow=True),
    Scene("boxes-on-torus", "Rigid planks fall on a soft torus.", boxes_on_torus.build, NEAR),
    Scene("torus-stack", "A stack of four equal soft bodies.", torus_stack.build, HIGH),
    Scene("ball-drop", "Balls of 100, 400 and 1 600 N/m are dropped.", ball_drop.build, FRONT, seconds=2.0),
    Scene("tray", "30 soft balls fall into a tray.", tray.build, ABOVE),
    Scene("box-stack", "Eight rigid plates stand on each other.", box_stack.build, HIGH, seconds=1.5),
    Scene("box-pile", "40 rigid boxes fall in a heap.", box_pile.build, HIGH, seconds=3.0),
]


def make_picture(scene: Scene, folder: Path) -> Picture:
    """Film a scene; write NAME.png (its last frame) and NAME.webp (looping) to `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    frames = list(film(scene))
    _write(folder / f"{scene.name}.png", frames[-1:])
    _write(folder / f"{scene.name}.webp", frames)
    return Picture(scene.name, scene.caption, f"{folder.name}/{scene.name}.webp", f"{folder.name}/{scene.name}.png")


def film(scene: Scene) -> Iterator[np.ndarray]:
    """Run a scene and yield its frames (height, width, 3)."""
    world = scene.build()
    step = min(BOX_STEP, STEP * world.stable_time_step())
    steps = max(1, round(1.0 / FRAMES_A_SECOND / step))
    for _ in range(round(scene.seconds * FRAMES_A_SECOND)):
        world.step(1.0 / FRAMES_A_SECOND / steps, steps)
        camera = scene.camera
        if scene.follow:
            along = np.array([SoftBody(world, 0).centre[0], 0.0, 0.0])
            camera = Camera(tuple(camera.eye + along), tuple(camera.target + along))
        yield render(list(things(world)), camera, world.model.ground_height)


def things(world: World) -> Iterator[Thing]:
    """Yield everything in a world, as meshes to draw."""
    soft = world.model.soft_count
    for i in range(soft):
        body = SoftBody(world, i)
        yield Thing(body.positions, body.triangles, COLOURS[i % len(COLOURS)])
    for i in range(world.model.box_count):
        box, mesh = Box(world, i), softbody.box(world.model.box_size[i])
        corners = [rotate(tuple(box.orientation), tuple(corner)) for corner in mesh.vertices]
        colour = COLOURS[(soft + i) % len(COLOURS)]
        yield Thing(np.array(corners) + box.position, mesh.triangles, colour, smooth=False)


def _write(path: Path, frames: list[np.ndarray]) -> None:
    """Write one frame, or a loop of many, whole or not at all."""
    from PIL import Image

    images = [Image.fromarray(frame) for frame in frames]
    buffer = io.BytesIO()
    options = {"save_all": True, "append_images": images[1:], "loop": 0, "duration": 1000 // FRAMES_A_SECOND}
    kind = path.suffix[1:].upper()
    images[0].save(buffer, kind, **(options | {"quality": 60, "method": 4} if kind == "WEBP" else {}))
    temporary = path.with_name(f".{path.name}")
    temporary.write_bytes(buffer.getvalue())
    temporary.replace(path)
