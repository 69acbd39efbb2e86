"""Live view on a port: a session, which moves a world, and a page, which shows it, together."""

from __future__ import annotations

import logging
import os
import socket
import sys
import threading
import webbrowser
from time import perf_counter, sleep

from softbody.errors import ViewError
from softbody.extras import library
from softbody.model.validation import check_whole
from softbody.stepping.runner import Steppable
from softbody.view.page import Page
from softbody.view.session import Session

LONGEST_TURN = 1.0 / 60.0  # [s] by the clock that a turn of the loop makes up for at most: beyond, the world is slow
TURN = 1.0 / 120.0  # [s]
FRAME = 1.0 / 60.0  # [s] at least, from one frame that is sent to the next
HOST, PORT = "127.0.0.1", 8080


class LiveView:
    """A world on a port, moved by a thread of its own, until it is closed; a `with` block closes it."""

    def __init__(self, world: Steppable, port: int = PORT, host: str = HOST) -> None:
        port = check_whole(port, "port", 0, 65535)
        viser = library("viser", "viser", "view", "a live view")
        port = _free_port(host, port)
        # Browsers open connections that they never use, and each would be printed as an error.
        logging.getLogger("websockets.server").addHandler(logging.NullHandler())
        self.session = Session(world)
        self._server = viser.ViserServer(host=host, port=port, label="softbody", verbose=False)
        self.url = f"http://{host}:{self._server.get_port()}"
        self.frames = 0  # that were sent
        self.error: BaseException | None = None
        self._page = Page(self._server, self.session, perf_counter)
        self._closed = threading.Event()
        self._threads = [threading.Thread(target=self._guarded, args=(turn,)) for turn in (self._move, self._draw)]
        for thread in self._threads:
            thread.daemon = True
            thread.start()

    def __enter__(self) -> LiveView:
        """Return the view."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the view."""
        self.close()

    def wait(self) -> None:
        """Wait until it is closed, or cannot go on: then raise why."""
        while not self._closed.wait(0.2):
            pass
        if self.error is not None:
            raise self.error

    def close(self) -> None:
        """Stop the world and free the port."""
        self._closed.set()
        for thread in self._threads:
            thread.join()
        self._server.stop()

    def _guarded(self, turn: object) -> None:
        """Repeat what a thread does until the view is closed; an error closes it."""
        assert callable(turn)
        try:
            turn()
        except BaseException as error:
            self.error = error
            self._closed.set()

    def _move(self) -> None:
        """Move the world with the clock."""
        last = perf_counter()
        while not self._closed.is_set():
            now = perf_counter()
            self.session.tick(min(now - last, LONGEST_TURN))
            last = now
            sleep(max(0.0, TURN - (perf_counter() - now)))

    def _draw(self) -> None:
        """Send the newest frame, as often as there is one."""
        drawn = None
        while not self._closed.is_set():
            begun, frame = perf_counter(), self.session.frame
            if frame is not drawn:
                self._page.draw(frame)
                drawn, self.frames = frame, self.frames + 1
            sleep(max(0.001, FRAME - (perf_counter() - begun)))


def view(world: Steppable, port: int, host: str, open_browser: bool) -> None:
    """Do what `World.view` says."""
    with LiveView(world, port, host) as live:
        print(f"{live.url} shows the world, until Ctrl-C", flush=True)
        if open_browser and _has_display():
            webbrowser.open(live.url)
        try:
            live.wait()
        except KeyboardInterrupt:
            print("closed")


def _free_port(host: str, port: int) -> int:
    """Return the port, or any free one for 0; raises ViewError where it cannot be had."""
    try:
        family, kind, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        with socket.socket(family, kind) as probe:
            if os.name == "posix":
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # as a server does
            probe.bind(address)
            return int(probe.getsockname()[1])
    except OSError as error:
        cure = "give another port, or 0 for any that is free"
        raise ViewError(f"port {port} of {host} cannot be opened: {error.strerror or error}; {cure}") from error


def _has_display() -> bool:
    """Tell whether a browser can be opened here, and not in a terminal."""
    return sys.platform in ("win32", "darwin") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
