"""Page that shows a world in the browser, and what can be pressed and pulled there."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from softbody.model.colours import STATIC, colour_of
from softbody.model.settings import INTEGRATORS, integrator_name
from softbody.render.camera import VIEW
from softbody.render.colour_map import SHADES, palette_of
from softbody.render.drawing import Drawing, framed, liquid_of
from softbody.render.lines import COLOUR as LINE
from softbody.render.quantities import QUANTITIES, UNITS
from softbody.render.rasteriser import LIQUID
from softbody.view.adjustments import SLIDERS, shown_at_start
from softbody.view.bands import LEVELS, bands_of
from softbody.view.frame import Frame
from softbody.view.session import Session

NOTHING = "bodies"  # what colours show, where they show no quantity
RED = (220, 40, 40)
DOT = 0.02  # the diameter of the point of a contact, of the scene's size
SHAPE = 0.9  # width to height of the part of the page that the controls do not cover
PLOT_EVERY = 0.25  # [s] by the clock


class Page:
    """The controls and the scene of one server of viser's, for one session."""

    def __init__(self, server: Any, session: Session, clock: Callable[[], float]) -> None:
        self._server, self._session, self._clock = server, session, clock
        middles = np.linspace(0.5, LEVELS - 0.5, LEVELS) * SHADES / LEVELS
        self._palette = [_bytes(colour) for colour in palette_of("viridis")[middles.astype(int)].tolist()]
        # (What is empty is a triangle without an area: what is hidden and shown again comes some frames too late.)
        self._nothing = np.zeros((3, 3), np.float32), np.array([[0, 1, 2]])
        self._range: tuple[float, float] | None = None  # of the quantity that colours show, since it was chosen
        self._quantity: str | None = None
        self._wireframe = False
        self._plotted = -np.inf
        self._make_scene()
        self._make_controls()

    def draw(self, frame: Frame) -> None:
        """Show an instant."""
        with self._server.atomic():
            self._show_bodies(frame)
            for handle, position, turn in zip(self._boxes, frame.box_position, frame.box_orientation):
                handle.position, handle.wxyz = position, turn
            self._show_colours(frame)
            self._show_contacts(frame)
            self._show_joints(frame)
            self._show_pull(frame)
        if self._clock() - self._plotted >= PLOT_EVERY:
            self._plotted = self._clock()
            self._show_numbers(frame)

    def _make_scene(self) -> None:
        scene, world = self._server.scene, self._session.world
        model, first = world.store.model, self._session.frame
        drawing = Drawing(world, "plain")
        camera = framed(world, drawing.things(), drawing.joint_ends(), SHAPE)
        size = float(np.linalg.norm(np.subtract(camera.eye, camera.target))) / 4.0
        self._server.initial_camera.position, self._server.initial_camera.look_at = camera.eye, camera.target
        self._server.initial_camera.fov = float(np.radians(VIEW))
        self._ground = None
        if model.ground_height > -np.inf:
            self._ground = scene.add_grid(
                "/ground", width=200.0, height=200.0, infinite_grid=True, fade_distance=30.0 * size,
                cell_size=0.5, section_size=1.0, shadow_opacity=0.35, position=(0.0, 0.0, model.ground_height),
            )  # fmt: skip
        level = liquid_of(world)
        if level is not None:
            corners = np.array([[100.0 * x, 100.0 * y, level] for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
            blue: Any = _bytes(tuple(LIQUID.tolist()))
            scene.add_mesh_simple("/liquid", corners, np.array([[0, 1, 2], [0, 2, 3]]), color=blue, opacity=0.4)
        # One looks into bodies with boxes inside.
        self._opacity = {i: 0.4 for i in range(model.soft_count) if i in model.box_host}
        self._soft, self._bands, self._triangles = list[Any](), list[list[Any]](), list[np.ndarray]()
        for vertices, triangles in zip(first.soft, first.triangles):
            self._add_body(vertices, triangles)
        self._boxes = []
        for i in range(model.box_count):
            is_static = model.box_inverse_mass[i] == 0.0
            colour = STATIC if is_static else colour_of(model.soft_count + i)
            where = {"position": first.box_position[i], "wxyz": first.box_orientation[i]}
            self._boxes.append(scene.add_box(f"/boxes/{i}", _bytes(colour), tuple(model.box_size[i]), **where))
        self._contacts = scene.add_point_cloud(
            "/contacts", np.zeros((1, 3), np.float32), RED, point_size=DOT * size, point_shape="circle",
            precision="float32", visible=False,
        )  # fmt: skip
        self._pull = scene.add_line_segments(
            "/pull", np.zeros((1, 2, 3)), RED, thickness=0.5 * DOT * size, visible=False
        )
        self._joints = scene.add_line_segments(
            "/joints", np.zeros((1, 2, 3)), _bytes(LINE), thickness=0.25 * DOT * size, visible=False
        )
        for i, handle in enumerate(self._boxes):
            if model.box_inverse_mass[i] > 0.0:
                handle.on_drag(partial(self._dragged, "box", i))

    def _add_body(self, vertices: np.ndarray, triangles: np.ndarray) -> None:
        """Add a soft body to the scene, after those that there are."""
        scene, i, shown = self._server.scene, len(self._soft), self._quantity is None
        look: dict[str, Any] = {"opacity": self._opacity.get(i), "wireframe": self._wireframe}
        self._triangles.append(triangles)
        colour = _bytes(colour_of(i))
        self._soft.append(scene.add_mesh_simple(f"/soft/{i}", vertices, triangles, color=colour, visible=shown, **look))
        self._bands.append(
            [
                scene.add_mesh_simple(
                    f"/colours/{i}/{k}", *self._nothing, color=self._palette[k], visible=not shown, **look
                )
                for k in range(LEVELS)
            ]
        )
        for each in (self._soft[i], *self._bands[i]):
            each.on_drag(partial(self._dragged, "soft", i))

    def _show_bodies(self, frame: Frame) -> None:
        """Show where soft bodies are, and what of them has torn; what there is no more is a point."""
        for i, (vertices, triangles) in enumerate(zip(frame.soft, frame.triangles)):
            if i == len(self._soft):
                self._add_body(vertices, triangles)
                continue
            self._soft[i].vertices = vertices
            if not np.array_equal(triangles, self._triangles[i]):
                self._soft[i].faces = self._triangles[i] = triangles
        for i in range(len(frame.soft), len(self._soft)):
            self._triangles[i] = self._nothing[1]
            for handle in (self._soft[i], *self._bands[i]):
                handle.vertices, handle.faces = self._nothing

    async def _dragged(self, kind: str, index: int, event: Any) -> None:
        """Pull a body to where the mouse is (asynchronous, for viser keeps such calls in order)."""
        grip, target = self._session.grip, np.array(event.end_position)
        if event.phase == "start":
            self._session.ask(partial(self._session.grab, kind, index, np.array(event.start_position)))
        elif event.phase == "end":
            self._session.ask(grip.let_go)
            return
        self._session.ask(partial(setattr, grip, "target", target))

    def _make_controls(self) -> None:
        gui, session = self._server.gui, self._session
        gui.set_panel_label("softbody")
        gui.configure_theme(control_width="medium", show_logo=False, show_share_button=False)
        self._status = gui.add_markdown(session.status)
        self._buttons = gui.add_button_group("run", ("pause", "go on", "step", "restart"))
        self._buttons.on_click(lambda event: self._press(event.target.value))
        self._speed = gui.add_slider("speed, × real time", 0.05, 2.0, 0.05, session.speed)
        self._speed.on_update(lambda event: setattr(session, "speed", event.target.value))
        with gui.add_folder("What acts"):
            start = shown_at_start(session.world)
            for name, slider in SLIDERS.items():
                value = min(max(start[name], slider.least), slider.most)
                handle = gui.add_slider(slider.label, slider.least, slider.most, slider.step, value)
                handle.on_update(partial(self._slide, name))
            choice = gui.add_dropdown(
                "integrator", tuple(INTEGRATORS), initial_value=integrator_name(session.world.store.settings)
            )
            choice.on_update(lambda event: session.ask(partial(session.set_integrator, event.target.value)))
        with gui.add_folder("What is shown"):
            colours = gui.add_dropdown("colours", (NOTHING, *QUANTITIES))
            colours.on_update(lambda event: self._choose_colours(event.target.value))
            self._legend = gui.add_markdown("", visible=False)
            springs = gui.add_checkbox("springs", False)
            springs.on_update(lambda event: self._show_springs(event.target.value))
            self._with_contacts = gui.add_checkbox("contacts", True)
            self._with_joints = gui.add_checkbox("joints", True, visible=len(session.frame.joints) > 0)
            if self._ground is not None:
                ground = gui.add_checkbox("ground", True, hint="Hidden, there is less to draw.")
                ground.on_update(lambda event: setattr(self._ground, "visible", event.target.value))
            gui.add_markdown("Drag a body with the mouse to pull it; drag beside it to turn the view.")
        self._plot = gui.add_uplot(
            (np.zeros(1), np.zeros(1), np.zeros(1)),
            (
                {"label": "time [s]"},
                {"label": "kinetic [J]", "stroke": "#dc7040", "width": 2},
                {"label": "all, less that at the start [J]", "stroke": "#3d80cc", "width": 2},
            ),
            title="energy [J]", scales={"x": {"time": False}}, aspect=1.6,
        )  # fmt: skip

    def _slide(self, name: str, event: Any) -> None:
        self._session.ask(partial(self._session.set_slider, name, event.target.value))

    def _press(self, button: str) -> None:
        """Do what a button says."""
        session = self._session
        what: dict[str, Callable[[], None]] = {
            "pause": partial(session.play, False),
            "go on": partial(session.play, True),
            "step": session.step_once,
            "restart": session.restart,
        }
        session.ask(what[button])

    def _choose_colours(self, choice: str) -> None:
        quantity = None if choice == NOTHING else choice
        self._session.ask(partial(self._session.show, quantity))

    def _show_springs(self, yes: bool) -> None:
        self._wireframe = yes
        for handle in (*self._soft, *(band for body in self._bands for band in body)):
            handle.wireframe = yes

    def _show_colours(self, frame: Frame) -> None:
        """Colour bodies by what the frame has values of."""
        if self._quantity != frame.quantity:
            self._quantity, self._range = frame.quantity, None
            self._legend.visible = bool(frame.quantity)
            for handle, bands in zip(self._soft, self._bands):
                handle.visible = frame.quantity is None
                for band in bands:
                    band.visible = frame.quantity is not None
        if not frame.values:
            return
        least, greatest = (f([float(f(each)) for each in frame.values]) for f in (min, max))
        if self._range is not None:
            least, greatest = min(least, self._range[0]), max(greatest, self._range[1])
        self._range = least, greatest
        for body, vertices, triangles, values in zip(self._bands, frame.soft, frame.triangles, frame.values):
            for handle, part in zip(body, bands_of(vertices, triangles, values, least, greatest)):
                handle.vertices, handle.faces = part if len(part[1]) else self._nothing

    def _show_contacts(self, frame: Frame) -> None:
        self._contacts.visible = bool(self._with_contacts.value and len(frame.contacts))
        if self._contacts.visible:
            self._contacts.points = frame.contacts

    def _show_joints(self, frame: Frame) -> None:
        self._joints.visible = bool(self._with_joints.value and len(frame.joints))
        if self._joints.visible:
            self._joints.points = frame.joints

    def _show_pull(self, frame: Frame) -> None:
        self._pull.visible = frame.pull is not None
        if frame.pull is not None:
            self._pull.points = frame.pull[None].astype(np.float32)

    def _show_numbers(self, frame: Frame) -> None:
        session = self._session
        counts = f"{sum(len(each) for each in frame.soft)} particles, {len(frame.box_position)} boxes"
        numbers = (
            f"**{frame.time:.2f} s** · {session.real_time_factor:.2f} × real time · {len(frame.contacts)} contacts"
        )
        self._status.content = f"{numbers}\n\n{session.status or counts}"
        if self._range is not None:
            unit = f" {UNITS[self._quantity or '']}".rstrip()
            self._legend.content = f"purple {self._range[0]:.3g}{unit} … yellow {self._range[1]:.3g}{unit}"
        history = np.array(session.history)
        self._plot.data = (history[:, 0], history[:, 1], history[:, 2] - history[0, 2])


def _bytes(colour: tuple[float, float, float]) -> tuple[int, int, int]:
    red, green, blue = (round(255 * part) for part in colour)
    return red, green, blue
