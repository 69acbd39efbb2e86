"""What do the scenes look like? Runs each and leaves a still and a looping animation."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import softbody
from softbody import Box, SoftBody, World
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
from validation.cases import rotation_matrix
from validation.record import Picture
from validation.render import Camera, Thing, render

FRAMES_A_SECOND = 20
LAST_FRAME = 1.5  # [s] that the last one stays, before the film begins again
STEP = 0.8  # of the stable time step
BOX_STEP = 1.0 / 240.0  # [s] at most, where there are boxes

COLOURS = [(0.86, 0.44, 0.24), (0.24, 0.50, 0.80), (0.38, 0.64, 0.36), (0.75, 0.60, 0.22), (0.58, 0.40, 0.70)]
STATIC = (0.70, 0.72, 0.75)  # the colour of boxes that cannot move
STRIPES = 4  # of each of its two colours, around a soft body
RIBBON = 0.1  # half the width of the ribbon around a box, of the box's longest side

NEAR, HIGH = Camera((3.9, -5.6, 2.9), (0.2, 0.0, 0.9)), Camera((4.7, -6.8, 4.0), (0.2, 0.0, 1.5))
LOW = Camera((1.0, -8.5, 3.0), (0.0, 0.0, 1.2))
FRONT, ABOVE = Camera((1.2, -6.8, 1.8), (0.2, 0.0, 0.8)), Camera((4.7, -7.8, 7.8), (0.0, 0.0, 0.6))
FAR = Camera((6.2, -9.0, 5.6), (0.2, 0.0, 1.9))


@dataclass(frozen=True)
class Scene:
    """A world to film: for how long, from where, and whether the camera follows the first body along x."""

    name: str
    caption: str
    build: Callable[[], World]
    camera: Camera
    follow: bool = False
    seconds: float = 2.5


# The paper's (§9), then others. They end when all lies still, or at a moment that says something.
SCENES = [
    Scene("sphere-on-torus", "A soft sphere comes to rest on a soft torus.", sphere_on_torus.build, NEAR),
    Scene("rolling-torus", "A soft torus rolls, pushed by half its weight.", rolling_torus.build, LOW, follow=True),
    Scene("boxes-on-torus", "Rigid cubes fall on a soft torus.", boxes_on_torus.build, HIGH),
    Scene("torus-stack", "A stack of four equal soft bodies.", torus_stack.build, HIGH, seconds=4.0),
    Scene("ball-drop", "Balls of 100, 400 and 1 600 N/m are dropped.", ball_drop.build, FRONT, seconds=1.4),
    Scene("tray", "30 soft balls fall into a tray.", tray.build, ABOVE, seconds=4.0),
    Scene("box-stack", "Eight rigid plates stand on each other.", box_stack.build, HIGH, seconds=1.5),
    Scene("box-pile", "40 rigid boxes fall in a heap.", box_pile.build, FAR, seconds=4.0),
]


def make_picture(scene: Scene, folder: Path) -> Picture:
    """Film a scene; write NAME.png (its last frame) and NAME.webp (looping) to `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    frames = list(film(scene))
    _write(folder / f"{scene.name}.png", frames[-1:])
    _write(folder / f"{scene.name}.webp", frames)
    return Picture(scene.name, scene.caption, f"{folder.name}/{scene.name}.webp", f"{folder.name}/{scene.name}.png")


def film(scene: Scene) -> Iterator[np.ndarray]:
    """Run a scene and yield its frames (height, width, 3), the first before anything has moved."""
    world = scene.build()
    stripes = [stripes_of(SoftBody(world, i)) for i in range(world.model.soft_count)]
    step = min(BOX_STEP, STEP * world.stable_time_step())
    steps = max(1, round(1.0 / FRAMES_A_SECOND / step))
    for frame in range(round(scene.seconds * FRAMES_A_SECOND) + 1):
        if frame > 0:
            world.step(1.0 / FRAMES_A_SECOND / steps, steps)
        camera = scene.camera
        if scene.follow:
            along = np.array([SoftBody(world, 0).centre[0], 0.0, 0.0])
            camera = Camera(tuple(camera.eye + along), tuple(camera.target + along))
        yield render(list(things(world, stripes)), camera, world.model.ground_height)


def stripes_of(body: SoftBody) -> np.ndarray:
    """Return what is positive (n,) on the stripes of a soft body: across its surface, around the way it is thinnest.

    Made from the shape that it starts in, and kept, they show how it turns.
    """
    x = body.positions - body.centre
    flat = 2 - int(np.argmin(np.ptp(x, axis=0)[::-1].round(6)))  # up, where it is as thin either way
    across, along = np.delete(x, flat, axis=1).T
    return np.hypot(across, along) * np.cos(STRIPES * np.arctan2(along, across))


def things(world: World, stripes: list[np.ndarray]) -> Iterator[Thing]:
    """Yield everything in a world, as meshes to draw: soft bodies with their `stripes`, boxes with a ribbon."""
    soft = world.model.soft_count
    for i in range(soft):
        body = SoftBody(world, i)
        yield Thing(body.positions, body.triangles, COLOURS[i % len(COLOURS)], stripes=stripes[i])
    for i in range(world.model.box_count):
        box, size = Box(world, i), world.model.box_size[i]
        mesh, longest = softbody.box(size, 2), int(size.argmax())
        place = mesh.vertices @ rotation_matrix(box.orientation).T + box.position
        if world.model.box_inverse_mass[i] == 0.0:
            yield Thing(place, mesh.triangles, STATIC, smooth=False)
            continue
        ribbon = RIBBON * size[longest] - np.abs(mesh.vertices[:, longest])
        yield Thing(place, mesh.triangles, COLOURS[(soft + i) % len(COLOURS)], smooth=False, stripes=ribbon)


def _write(path: Path, frames: list[np.ndarray]) -> None:
    """Write one frame, or a loop of many, whole or not at all."""
    from PIL import Image

    images = [Image.fromarray(frame) for frame in frames]
    buffer = io.BytesIO()
    durations = [1000 // FRAMES_A_SECOND] * (len(images) - 1) + [round(1000 * LAST_FRAME)]
    options = {"save_all": True, "append_images": images[1:], "loop": 0, "duration": durations}
    kind = path.suffix[1:].upper()
    images[0].save(buffer, kind, **(options | {"quality": 60, "method": 4} if kind == "WEBP" else {}))
    temporary = path.with_name(f".{path.name}")
    temporary.write_bytes(buffer.getvalue())
    temporary.replace(path)
