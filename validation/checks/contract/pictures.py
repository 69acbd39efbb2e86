"""Claims that a picture shows what a pinhole camera sees, and a film when it was."""

from __future__ import annotations

import tempfile
from itertools import product
from pathlib import Path

import numpy as np

import softbody
from softbody import Camera, Recorder, World
from softbody.render import films, png, rasteriser, webp
from softbody.render.drawing import framed, placed
from softbody.render.rasteriser import _draw_faces, _seen
from softbody.stepping import frames
from validation.answers import Answers
from validation.cases import BOX_TRIANGLES, corners_of, random_mesh, random_orientations, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.contract.kept_files import extend_evenly
from validation.fault import Fault

FAMILY = "pictures and films"

LATE = Fault(
    "every frame half a frame late",
    frames.frames_by_steps,
    "round((begun + count / rate - now) / h) → round((begun + (count + 0.5) / rate - now) / h)",
)

SIZE = 160, 120  # pixels of most pictures


def random_camera(rng: np.random.Generator) -> Camera:
    """Return a camera anywhere, that looks anywhere; some look straight up or down."""
    eye, towards = 3.0 * rng.normal(size=3), rng.normal(size=3)
    if rng.random() < 0.2:
        towards[:2] = 0.0
    return Camera(tuple(eye), tuple(eye + towards), rng.uniform(10.0, 100.0))


@check(
    section="beyond the paper",
    piece="softbody.Camera.axes, softbody.Camera.moved",
    reference="Panda3D's look_at; the way added by NumPy",
    engines=("panda3d",),
    unit="of unit vectors, or of metres",
    tolerance=2e-14,
    because="rounding of a cross product, where the view is nearly straight up",
    faults=(
        Fault("right that is left", Camera.axes, "np.cross(forward, upward) → np.cross(upward, forward)"),
        Fault("up that is z, whatever the view", Camera.axes, "np.cross(right, forward) → np.array([0.0, 0.0, 1.0])"),
        Fault(
            "a target that stays where it was", Camera.moved, "np.add(self.target, offset) → np.add(self.target, 0.0)"
        ),
        Fault(
            "a view that is forgotten",
            Camera.moved,
            "Camera((e_[0], e_[1], e_[2]), (t_[0], t_[1], t_[2]), self.view)"
            " → Camera((e_[0], e_[1], e_[2]), (t_[0], t_[1], t_[2]))",
        ),
    ),
)
def cameras_look_where_they_are_told(run: Run) -> Comparison:
    """A camera's axes are those that Panda3D turns a node to.

    That holds for cameras that look anywhere, straight up and down too. Moved, a camera stands as far away, looks the
    same way and sees as much.
    """
    from references import pinhole

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(200, 1_000, 10_000)):
        camera, offset = random_camera(rng), rng.normal(size=3)
        moved, axes = camera.moved(offset), pinhole.axes(camera.eye, camera.target).ravel()
        answers.add(
            [*camera.axes().ravel(), *moved.axes().ravel(), *moved.eye, *moved.target, moved.view],
            [*axes, *axes, *(np.array(camera.eye) + offset), *(np.array(camera.target) + offset), camera.view],
        )
    return answers.comparison()


def sky_of(camera: Camera, size: tuple[int, int] = SIZE) -> np.ndarray:
    """Return the colour (3,) of the sky in a camera's pictures."""
    return World().picture(camera=camera, size=size)[0, 0]


def covered(picture: np.ndarray, sky: np.ndarray, least: int = 0) -> np.ndarray:
    """Return which pixels (h, w) differ from the sky by more than `least` of 255."""
    return np.asarray((np.abs(picture.astype(int) - sky) > least).any(axis=2))


def spot(mask: np.ndarray) -> np.ndarray:
    """Return the middle of what a mask (h, w) covers, and the radius of a disc as large (3,) [pixels]."""
    rows, columns = np.nonzero(mask)
    if not len(rows):
        return np.zeros(3)
    return np.array([columns.mean() + 0.5, rows.mean() + 0.5, np.sqrt(len(rows) / np.pi)])


@check(
    section="beyond the paper",
    piece="softbody.World.picture",
    reference="closed form: the cone around a sphere, cut by the picture; the camera's axes by Panda3D",
    engines=("panda3d",),
    kind="closed form",
    unit="pixels, of the middle and of a mean radius of some 25 to 100",
    tolerance=0.6,
    because="a pixel that is touched counts as covered: half a pixel more each way",
    faults=(
        Fault("a view across", rasteriser.render, "size[1] → size[0]"),
        Fault("a picture that is mirrored", _seen, "0.5 * columns + scale * right → 0.5 * columns - scale * right"),
        Fault("a picture upside down", _seen, "0.5 * rows - scale * up → 0.5 * rows + scale * up"),
        Fault(
            "a camera that stands a hundredth to the side", _seen, "vertices - film.eye → vertices - 1.01 * film.eye"
        ),
    ),
)
def balls_are_seen_where_they_are(run: Run) -> Comparison:
    """A ball is seen where a pinhole camera has it.

    It is seen as large, too: the middle and the area of the ellipse are compared. Cameras are anywhere, of any angle of
    view, and pictures of any shape.
    """
    from references import pinhole

    rng, answers = run.fresh_rng(), Answers()
    ball = softbody.icosphere(4, 1.0)
    while len(answers) < run.count(20, 100, 1_000):
        size = int(rng.integers(160, 320)), int(rng.integers(160, 320))
        view, centre = rng.uniform(20.0, 90.0), 5.0 * rng.normal(size=3)
        forward, reach = rng.normal(size=3), rng.uniform(0.15, 0.35) * min(size)  # pixels
        half = np.arctan(reach / pinhole.focal_length(view, size))
        eye = centre - forward / np.linalg.norm(forward) / np.sin(half)
        target = centre + 0.2 * rng.normal(size=3)
        disc = pinhole.disc(eye, target, view, size, centre, 1.0)
        if (np.abs(disc.middle - 0.5 * np.array(size)) + disc.reach >= 0.5 * np.array(size)).any():
            continue  # the picture's edge may cut it off
        world = World()
        world.add_soft_body(ball, 1.0, 100.0, 10.0, centre)
        camera = Camera(tuple(eye), tuple(target), view)
        seen = covered(world.picture(camera=camera, size=size), sky_of(camera, size))
        answers.add(spot(seen), [*disc.middle, np.sqrt(disc.area / np.pi)])
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.World.picture",
    reference="trimesh with embree: rays through the pixels' middles; the camera's axes by Panda3D",
    engines=("trimesh", "embreex", "panda3d"),
    because="a pixel is a mean of four samples: those whose neighbours see something else are left out",
    faults=(
        Fault("bodies painted one over the other", _draw_faces, "far >= film.distance[r, s] → False"),
        Fault("the undersides of triangles", _draw_faces, "faces_up(a, b, c) → not faces_up(a, b, c)"),
        Fault("every tenth triangle left out", _draw_faces, "faces_up(a, b, c) → faces_up(a, b, c) or t % 10 == 0"),
        Fault("a box that is not turned", placed, "vertices + w_ * t_ + np.cross(a_, t_) + p_ → vertices + p_"),
    ),
)
def the_nearest_is_seen(run: Run) -> Comparison:
    """What is in front is seen, what is behind is not.

    At every pixel that is not next to an outline, that is the body that embree's ray meets first, or the sky. Soft
    bodies are of all kinds, in the colours of least and greatest speed, and boxes are grey.
    """
    from references import pinhole, trimesh

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(6, 30, 300)):
        world, surfaces = World(), []
        for speed, kind in zip((0.0, 1.0), rng.choice(["sphere", "torus", "dented sphere", "lumpy sphere"], 2)):
            mesh = random_mesh(str(kind), rng)
            mesh = mesh.scaled(1.0 / np.abs(mesh.vertices).max())
            body = world.add_soft_body(mesh, 1.0, 100.0, 10.0, 0.7 * rng.normal(size=3), (speed, 0.0, 0.0))
            surfaces.append((body.positions.copy(), mesh.triangles))
        size, place, turn = rng.uniform(0.3, 1.5, 3), 0.7 * rng.normal(size=3), random_orientations(rng, 1)[0]
        world.add_box(size, 1.0, place, turn)
        surfaces.append((corners_of(size) @ rotation_matrix(turn).T + place, BOX_TRIANGLES))
        eye = rng.normal(size=3)
        eye *= 6.0 / np.linalg.norm(eye)
        target, view = 0.2 * rng.normal(size=3), rng.uniform(25.0, 45.0)
        camera = Camera(tuple(eye), tuple(target), view)
        picture = world.picture(camera=camera, size=SIZE, colour="speed", colour_range=(0.0, 1.0))
        rays = pinhole.rays(eye, target, view, SIZE)
        judged = trimesh.first_met(eye, rays, surfaces).reshape(SIZE[::-1])
        clear = _like_neighbours(judged)
        kinds = [("sky", "the slow one", "the fast one", "the box")[k + 1] for k in judged[clear]]
        agree = _who(picture, sky_of(camera))[clear] == judged[clear]
        answers.extend(agree, np.ones(len(agree), bool), kind=kinds)
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.World.picture",
    reference="invariance: the same world and ground, raised or lowered",
    kind="invariant",
    unit="of the pixels",
    tolerance=1e-4,
    because="three pixels at an edge, which rounding may decide: none in 72 pictures of twelve seeds",
    faults=(Fault("shadows of a ground at 0", framed, "(points[:, 2:] - height) * SLANT → points[:, 2:] * SLANT"),),
)
def the_same_elsewhere(run: Run) -> Comparison:
    """A picture shows the same at any height of the ground.

    Balls, boxes and their ground, all of it raised by up to 128 m or lowered by up to 64 m, seen by the camera that
    frames them with their shadows.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(6, 20, 100)):
        places, turn = rng.uniform(-1.0, 1.0, (4, 3)) + [0.0, 0.0, 2.0], random_orientations(rng, 1)[0]
        seen = []
        for up in (0.0, float(rng.choice([-64.0, -8.0, 16.0, 128.0]))):
            world = World()
            world.add_ground(up)
            for place in places[:2]:
                world.add_soft_body(softbody.icosphere(2, 0.4), 1.0, 100.0, 1.0, place + [0.0, 0.0, up])
            for place in places[2:]:
                world.add_box((0.6, 0.4, 0.3), 1.0, place + [0.0, 0.0, up], turn)
            seen.append(world.picture(size=(200, 150), colour="plain").astype(int))
        differ = (np.abs(seen[0] - seen[1]).max(axis=2) > 8).mean()
        answers.add(differ, 0.0, kind="raised", places=places)
    return answers.comparison()


def _like_neighbours(seen: np.ndarray) -> np.ndarray:
    """Tell which pixels (h, w) see the same as all eight around them; those at the border do not."""
    same = np.zeros(seen.shape, bool)
    around = np.lib.stride_tricks.sliding_window_view(seen, (3, 3))
    same[1:-1, 1:-1] = (around == seen[1:-1, 1:-1, None, None]).all(axis=(2, 3))
    return same


def _who(picture: np.ndarray, sky: np.ndarray) -> np.ndarray:
    """Return who is seen (h, w), by colours: −1 the sky, 0 the purple one, 1 the yellow one, 2 the grey box."""
    green, blue = picture[:, :, 1], picture[:, :, 2]
    most, least = picture.max(axis=2).astype(float), picture.min(axis=2).astype(float)
    grey = most - least < 0.12 * most
    who = np.where(grey, 2, np.where(blue > green, 0, 1))
    return np.where(covered(picture, sky), who, -1)


def _falling(rng: np.random.Generator) -> tuple[World, Camera, np.ndarray, np.ndarray]:
    """Return a ball that flies without touching anything, a camera that sees all of it, where and how fast it began."""
    world = World(integrator="rk4")
    start, speed = np.array([-1.0, 0.0, 0.4]), np.array([rng.uniform(1.0, 2.0), 0.0, rng.uniform(2.0, 3.0)])
    world.add_soft_body(softbody.icosphere(2, 0.4), 1.0, 300.0, 0.0, start, speed)
    world.equilibrium()
    world.soft_bodies[0].velocities = speed
    return world, Camera((0.0, -6.0, 0.3), (0.0, 0.0, 0.3), 40.0), start, speed


def _middles(camera: Camera, start: np.ndarray, speed: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Return column, row and mean radius (f, 3) [pixels] of the ball at times [s], by the parabola."""
    from references import pinhole

    rows = []
    for t in times:
        centre = start + speed * t - (0.0, 0.0, 0.5 * 9.81 * t**2)
        disc = pinhole.disc(camera.eye, camera.target, camera.view, SIZE, centre, 0.4)
        rows.append([*disc.middle, np.sqrt(disc.area / np.pi)])
    return np.array(rows)


@check(
    section="beyond the paper",
    piece="softbody.Recorder.run, softbody.Recorder.frame, softbody.Recorder.close",
    reference="Pillow's decoder; the parabola through a pinhole camera, of which Panda3D tells the axes",
    engines=("PIL", "panda3d"),
    unit="pixels; or of a millisecond, and of 1 for numbers of frames",
    tolerance=1.0,
    because="a pixel that is touched counts as covered, WebP blurs it, and steps of one's own are up to half of one off"
    " the frame's time: 0.1 pixels; durations are whole milliseconds",
    faults=(
        Fault("no first frame", Recorder.run, "if self.frames == 0:\n    self.frame() → "),
        LATE,
        Fault(
            "milliseconds cut off",
            Recorder._milliseconds,
            "round(1000.0 * (k + 1) / self._rate) - round(1000.0 * k / self._rate) → int(1000.0 / self._rate)",
        ),
        Fault("a last frame that stays no longer", Recorder.close, "round(1000.0 * self._last_frame) → 0"),
        Fault(
            "only what has changed is drawn over, and not what it left",
            webp.WebpFilm.add,
            "changed if self._stale is None else _around(changed, self._stale)"
            " → (*changed[:2], changed[2], max(changed[1] + 1, changed[3] - 8))",
        ),
    ),
)
def films_keep_time(run: Run) -> Comparison:
    """A film has a frame each 1/f s.

    The first comes at once, and each shows where a ball that flies was then. Each stays until the next one's time, the
    last for longer, if told so. So it is as WebP and as a folder of pictures, with steps of the world's choice, of
    one's own, and with frames taken one by one.
    """
    rng, answers = run.fresh_rng(), Answers()
    ways = ("steps of one's own", "the world's steps", "one by one")
    for _, way, name in product(range(run.count(1, 3, 20)), ways, ("film.webp", "film")):
        world, camera, start, speed = _falling(rng)
        rate, count, stays = float(rng.integers(13, 30)), int(rng.integers(5, 9)), rng.uniform(0.1, 0.9)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / name
            with Recorder(world, path, rate, camera=camera, size=SIZE, quality=90, last_frame=stays) as film:
                if way == "steps of one's own":
                    film.run(count / rate, 0.7 * world.stable_time_step())
                elif way == "the world's steps":
                    film.run(count / rate)
                else:
                    film.frame()
                    for _ in world.frames(count / rate, rate):
                        film.frame()
            frames, milliseconds = _shown(path)
        times, sky, kind = np.arange(count + 1) / rate, sky_of(camera), f"{name}, {way}"
        spots = np.array([spot(covered(frame, sky, 40)) for frame in frames])
        judged = _middles(camera, start, speed, times)
        extend_evenly(answers, spots, judged, kind)
        ends = 1e3 * (times + 1.0 / rate) + np.where(np.arange(count + 1) == count, 1e3 * stays, 0.0)
        if milliseconds is not None:
            # Numbers of frames and of times that they end at [ms], each a row of its own.
            off = np.cumsum(milliseconds) - ends if len(milliseconds) == len(ends) else np.full(1, np.inf)
            answers.extend(np.column_stack([off, np.zeros((len(off), 2))]), np.zeros((len(off), 3)), kind=kind)
    return answers.comparison()


def _shown(path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the frames (f, h, w, 3) of a film, and how long each stays (f,) [ms], if that is kept."""
    from references import pillow

    if path.is_dir():
        return np.array([pillow.picture(each) for each in sorted(path.iterdir())]), None
    film = pillow.film(path)
    return film.frames, film.milliseconds


@check(
    section="beyond the paper",
    piece="softbody.World.picture, softbody.Recorder.still",
    reference="Pillow's decoder",
    engines=("PIL",),
    because="PNG keeps every bit",
    faults=(
        Fault(
            "rows that are told to be as they are",
            png.png_of,
            "np.full((height, 1), UP, np.uint8) → np.zeros((height, 1), np.uint8)",
        ),
        Fault(
            "colours the other way round",
            png.png_of,
            "picture.reshape(height, 3 * width) → picture[:, :, ::-1].reshape(height, 3 * width)",
        ),
        Fault(
            "the picture before the last as the still",
            Recorder.frame,
            "self._pixels = pixels → self._pixels = pixels if self._pixels is None else self._pixels",
        ),
        Fault("pictures of a folder a row short", films.PngFolder.add, "picture → picture[::-1]"),
    ),
)
def pictures_as_files(run: Run) -> Comparison:
    """PNG files hold the pixels that `picture` returns, to the bit.

    They are those of a picture, of a film's folder and of its last frame, of any size, as Pillow reads them.
    """
    from references import pillow

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(4, 20, 200)):
        world, camera, *_ = _falling(rng)
        world.add_ground(-1.0)
        size = int(rng.integers(1, 200)), int(rng.integers(1, 200))
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            with Recorder(world, folder / "film", camera=camera, size=size) as film:
                film.frame()
                world.run(0.1)
                film.frame()
                film.still(folder / "still.png")
            pixels = world.picture(folder / "now.png", camera=camera, size=size)
            for file in ("now.png", "still.png", "film/000001.png"):
                same = (pillow.picture(folder / file).reshape(-1, 3) == pixels.reshape(-1, 3)).all(axis=1)
                answers.extend(same, np.ones(len(same), bool), kind=file.removesuffix(".png"))
    return answers.comparison()
