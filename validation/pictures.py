"""Pictures of the scenes: a still, a loop, and what moved, to be turned in a page."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from softbody import Camera, Recorder, World
from softbody.scenes import (
    ball_drop,
    box_pile,
    box_stack,
    boxes_in_bags,
    boxes_on_torus,
    limp,
    pool,
    rolling_torus,
    sphere_on_torus,
    torus_stack,
    tray,
    water_bags,
)
from validation.behaviour import depths
from validation.motion import Motion
from validation.record import Picture

FRAMES_A_SECOND = 20  # of what moved; the film takes every second, for it is small and the page has to be
FILM = 10  # frames a second
LAST_FRAME = 1.5  # [s] that the last one stays longer, before the film begins again
SIZE = (360, 270)
QUALITY = 45  # of films, 1 … 100: all of them are to stay below 1 MB
STEP = 0.8  # of the stable time step
BOX_STEP = 1.0 / 240.0  # [s] at most, where there are boxes

NEAR, HIGH = Camera((3.9, -5.6, 2.9), (0.2, 0.0, 0.9)), Camera((4.7, -6.8, 4.0), (0.2, 0.0, 1.5))
LOW = Camera((1.0, -8.5, 3.0), (0.0, 0.0, 1.2))
FRONT, ABOVE = Camera((1.2, -6.8, 1.8), (0.2, 0.0, 0.8)), Camera((4.7, -7.8, 7.8), (0.0, 0.0, 0.6))
CLOSE = Camera((1.0, -5.4, 3.0), (0.1, 0.0, 0.2))
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
    Scene("pool", "Boxes and balls of five densities float in water, or sink.", pool.build, CLOSE, seconds=4.0),
    Scene("water_bags", "Bags of liquid lie and hang; the denser sag more.", water_bags.build, FRONT, seconds=4.0),
    Scene(
        "boxes_in_bags",
        "Boxes rise, hang or sink in bags, and hang in a jelly.",
        boxes_in_bags.build,
        CLOSE,
        seconds=4.0,
    ),
    Scene("limp", "Limp bodies fold, and hold themselves.", limp.build, CLOSE, seconds=1.6),
    Scene("tray", "30 soft balls fall into a tray.", tray.build, ABOVE, seconds=2.4),
    Scene("box-stack", "Eight rigid plates stand on each other.", box_stack.build, HIGH, seconds=1.5),
    Scene("box-pile", "40 rigid boxes fall in a heap.", box_pile.build, FAR, seconds=4.0),
]


def make_picture(scene: Scene, folder: Path) -> Picture:
    """Film a scene; write NAME.png (its last frame), NAME.webp (looping) and NAME.npz (what moved) to `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    world, film = scene.build(), folder / f"{scene.name}.webp"
    camera = partial(following if scene.follow else standing, scene.camera)
    steps = max(1, round(1.0 / FRAMES_A_SECOND / min(BOX_STEP, STEP * world.stable_time_step())))
    time_step = 1.0 / FRAMES_A_SECOND / steps
    still, moved, motion = folder / f"{scene.name}.png", folder / f"{scene.name}.npz", Motion(world)
    look = Recorder(world, film, FILM, camera=camera, size=SIZE, quality=QUALITY, last_frame=LAST_FRAME)
    with look as recorder:
        for frame in range(round(scene.seconds * FRAMES_A_SECOND) + 1):
            if frame:
                world.step(time_step, steps)
            if frame % (FRAMES_A_SECOND // FILM) == 0:
                recorder.frame()
            motion.frame(camera(world), depths(world))
        recorder.still(still)
    motion.save(moved, code_of(scene, time_step))
    return Picture(scene.name, scene.caption, *(f"{folder.name}/{file.name}" for file in (film, still, moved)))


def code_of(scene: Scene, time_step: float) -> str:
    """Return the lines that made a scene, and those that run it."""
    module = inspect.getmodule(scene.build)
    name = module.__name__.rpartition(".")[2] if module else "scene"
    source = inspect.getsource(module or scene.build).strip()
    return (
        f"from softbody.scenes import {name}\n\nworld = {name}.build()\n"
        f"world.run({scene.seconds:g}, time_step={time_step:.6g})  # or world.view(), to steer it\n\n"
        f"# softbody/scenes/{name}.py\n{source}\n"
    )


def standing(camera: Camera, _: World) -> Camera:
    """Return the camera itself."""
    return camera


def following(camera: Camera, world: World) -> Camera:
    """Return the camera, moved along x as the first body is."""
    return camera.moved(np.array([world.soft_bodies[0].centre[0], 0.0, 0.0]))
