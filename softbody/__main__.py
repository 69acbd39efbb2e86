"""Command line of the core: view, record, run, export and warmup; `python -m softbody --help`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

from softbody import __version__, scenes
from softbody.cli.progress import reporter
from softbody.cli.run_folder import TRAJECTORY, run_scene
from softbody.cli.warmup import warm_up
from softbody.errors import ParameterError, SoftbodyError
from softbody.model.settings import INTEGRATORS
from softbody.model.validation import check_range
from softbody.render import Recorder
from softbody.render.films import picture_path
from softbody.render.quantities import UNITS
from softbody.scenes.scene_file import read_scene
from softbody.trajectory import Trajectory
from softbody.world import World

# Exit codes: as of every command, where the machine lacks something, and after Ctrl-C.
WRONG_USAGE, CANNOT, INTERRUPTED = 2, 4, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Return 0, or another exit code: WRONG_USAGE, CANNOT, INTERRUPTED."""
    given = parser().parse_args(arguments)
    command: Callable[[argparse.Namespace], int | None] = given.command
    try:
        return command(given) or 0
    except SoftbodyError as error:
        print(f"softbody: {error}", file=sys.stderr)
        return CANNOT if isinstance(error, (OSError, ImportError)) else WRONG_USAGE


def parser() -> argparse.ArgumentParser:
    """Return what reads the command line; a command is a function of what it read."""
    listed = "\n".join(f"  {name:<16} {_first_line(name)}" for name in scenes.__all__)
    result = argparse.ArgumentParser(
        prog="python -m softbody",
        description="Pressure soft bodies and rigid boxes.",
        epilog=f"scenes:\n{listed}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    result.add_argument("--version", action="version", version=f"softbody {__version__}")
    commands = result.add_subparsers(title="commands", metavar="COMMAND", required=True)

    warmup = commands.add_parser("warmup", help="compile the core ahead of its first use, on all processor cores")
    warmup.set_defaults(command=_warmup)

    view = commands.add_parser("view", help="show a scene live in the browser (pip install softbody[view])")
    view.add_argument("scene", metavar="SCENE", type=_scene, help=f"{', '.join(scenes.__all__)}, or a scene file")
    view.add_argument("--port", type=int, default=8080, help="of the page (8080); 0 for any that is free")
    view.add_argument("--host", default="127.0.0.1", help="who may see it (127.0.0.1: this machine only)")
    view.add_argument("--integrator", choices=tuple(INTEGRATORS), help="of soft bodies (symplectic_euler)")
    view.add_argument("--substeps", type=int, help="in which soft bodies take a step, contacts once (1)")
    view.add_argument("--paper", action="store_true", help="by all of the paper's own choices")
    view.add_argument("--no-browser", action="store_true", help="open none; say the address")
    view.set_defaults(command=_view)

    record = commands.add_parser("record", help="run a scene and keep a film of it, or a picture of how it ends")
    record.add_argument("scene", metavar="SCENE", type=_scene, help=f"{', '.join(scenes.__all__)}, or a scene file")
    record.add_argument("file", metavar="FILE", help="film.webp, film.mp4, a new folder for pictures, or end.png")
    record.add_argument("--seconds", type=float, default=2.0, help="of the world's time (2)")
    record.add_argument("--substeps", type=int, help="in which soft bodies take a step, contacts once (1)")
    record.add_argument("--frames-per-second", type=float, default=20.0, help="of a film (20)")
    record.add_argument("--colour", choices=("stripes", "plain", *UNITS), default="stripes", help="what colours show")
    record.add_argument("--range", type=float, nargs=2, metavar=("LEAST", "MOST"), help="that colours stand for")
    record.add_argument("--size", type=int, nargs=2, metavar=("WIDTH", "HEIGHT"), default=(640, 480), help="[pixels]")
    record.set_defaults(command=_record)

    run = commands.add_parser("run", help="run a scene file (TOML) into a folder, and keep its trajectory")
    run.add_argument("scene", metavar="SCENE.toml", help="such as examples/ball_on_box.toml")
    run.add_argument("--out", metavar="FOLDER", required=True, help="a new folder: trajectory, last world, film")
    run.add_argument("--resume", action="store_true", help="go on with the run in that folder, to the same bits")
    run.set_defaults(command=_run)

    export = commands.add_parser(
        "export", help="write a kept run, or a saved world, as PLY, OBJ, GLB or USD (softbody[files], [usd])"
    )
    export.add_argument(
        "source", metavar="SOURCE", help="the folder of a run or of a trajectory, or a file of World.save"
    )
    export.add_argument(
        "file", metavar="FILE", help="film.glb or film.usdc, which move; of a saved world also now.ply or now.obj"
    )
    export.add_argument(
        "--each", choices=("ply", "obj", "glb", "usda", "usdc"), help="a file for each frame, in a new folder FILE"
    )
    export.add_argument("--every", type=int, default=1, help="take every so many frames (1)")
    export.set_defaults(command=_export)
    return result


def _scene(name: str) -> str:
    """Return the name of a scene, or of a scene file."""
    if name in scenes.__all__ or name.endswith(".toml"):
        return name
    known = ", ".join(map(repr, scenes.__all__))
    raise argparse.ArgumentTypeError(f"invalid choice: {name!r} (choose from {known}, or a file that ends in .toml)")


def _built(scene: str, world: World | None = None, **choices: Any) -> World:
    """Return `world`, or a new one, filled with a scene; in a new one `choices` hold in place of the scene's own."""
    if scene.endswith(".toml"):
        return read_scene(scene, world, **choices).world
    return getattr(scenes, scene).build(world=World(**choices) if world is None else world)


def _first_line(scene: str) -> str:
    """Return what a scene is, as the first line of its file says."""
    return str(getattr(scenes, scene).__doc__).partition("\n")[0]


def _warmup(given: argparse.Namespace) -> None:
    start = perf_counter()
    warm_up()
    print(f"machine code is ready ({perf_counter() - start:.1f} s)")


def _view(given: argparse.Namespace) -> None:
    said = {"integrator": given.integrator, "substeps": given.substeps}
    choices = {name: value for name, value in said.items() if value is not None}
    world = _built(given.scene, World.paper(**choices) if given.paper else None, **choices)
    world.view(given.port, host=given.host, open_browser=not given.no_browser)


def _record(given: argparse.Namespace) -> None:
    seconds = check_range(given.seconds, "seconds", "s", above=0.0)
    world = _built(given.scene, **({} if given.substeps is None else {"substeps": given.substeps}))
    look: Any = {"size": given.size, "colour": given.colour, "colour_range": given.range}
    if given.file.endswith(".png"):
        picture_path(given.file)  # whatever is in its way is said before the work
        world.run(seconds)
        world.picture(given.file, **look)
    else:
        with Recorder(world, given.file, given.frames_per_second, **look) as film:
            film.run(seconds)
    print(f"{given.file}: {given.scene} until {world.time:.3g} s")


def _run(given: argparse.Namespace) -> int | None:
    try:
        print(run_scene(given.scene, given.out, given.resume, reporter))
    except KeyboardInterrupt:
        print(f"softbody: interrupted; {given.out} has what was done, and --resume goes on", file=sys.stderr)
        return INTERRUPTED
    return None


def _export(given: argparse.Namespace) -> None:
    source = Path(given.source)
    if source.is_file():
        if given.each or given.every != 1:
            raise ParameterError(f"{source} is one moment; leave out --each and --every")
        World.load(source).export(given.file)
        print(f"{given.file}: {source}")
        return
    kept = Trajectory.open(source / TRAJECTORY if (source / TRAJECTORY).is_dir() else source)
    kept.export(given.file, given.each, every=given.every)
    print(f"{given.file}: {len(range(0, len(kept), given.every))} frames of {source}")


if __name__ == "__main__":
    sys.exit(main())
