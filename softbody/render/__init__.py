"""Pictures and films of a world, without a display: `World.picture` and `Recorder` are made of what is here.

Nothing here is imported, or compiled, before a picture is asked for.
"""

from softbody.render.camera import Camera
from softbody.render.rasteriser import Thing, render
from softbody.render.recorder import Recorder

__all__ = ["Camera", "Recorder", "Thing", "render"]
