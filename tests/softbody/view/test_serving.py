"""A live view in a real browser, without a screen; and what is said where there cannot be one."""

from __future__ import annotations

import io
import itertools
import socket
import sys
import time
import urllib.request

import numpy as np
import pytest

import softbody
from softbody import MissingPackageError, ParameterError, ViewError
from softbody.view.serving import LiveView
from tests import browser


@pytest.fixture
def world():
    world = softbody.World()
    world.add_ground()
    world.add_soft_body(softbody.icosphere(2, 0.5), 1.0, 200.0, 30.0, (0.0, 0.0, 0.6), damping=2.0)
    return world


def wait_until(what, seconds=60.0):
    end = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < end, "it does not come"
        time.sleep(0.05)


def test_a_library_that_is_missing_is_named_with_its_cure(world, monkeypatch):
    for name in [each for each in sys.modules if each.partition(".")[0] == "viser"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(MissingPackageError, match=r"a live view needs viser: pip install softbody\[view\]"):
        world.view()


@pytest.mark.parametrize("port", [-1, 65536, "8080"])
def test_what_is_no_port_is_refused(world, port):
    with pytest.raises(ParameterError, match="port is"):
        world.view(port)


def test_a_port_that_is_taken_is_said_with_its_cure(world):
    pytest.importorskip("viser")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(ViewError, match=f"port {port} of 127.0.0.1 cannot be opened: .*give another port"):
            LiveView(world, port)


def test_a_host_that_is_none_is_said(world):
    pytest.importorskip("viser")
    with pytest.raises(ViewError, match=r"of no\.such\.host\.invalid cannot be opened"):
        LiveView(world, 0, "no.such.host.invalid")


def test_a_view_moves_the_world_answers_on_its_port_and_ends(world):
    pytest.importorskip("viser")
    with LiveView(world, 0) as live:
        assert b"<html" in urllib.request.urlopen(live.url).read()[:2000].lower()
        wait_until(lambda: world.steps > 0)
        frames = live.frames
        wait_until(lambda: live.frames > frames + 5)
    steps = world.steps
    time.sleep(0.1)
    assert world.steps == steps
    assert live.error is None


def test_an_error_in_the_loop_ends_the_view_and_is_raised(world):
    pytest.importorskip("viser")
    with LiveView(world, 0) as live:
        live.session.ask(lambda: 1 // 0)
        with pytest.raises(ZeroDivisionError):
            live.wait()


@pytest.fixture
def page(world):
    """A view of the world and a browser that shows it."""
    pytest.importorskip("viser")
    pytest.importorskip("websockets")
    if browser.found() is None:
        pytest.skip("not run: no browser")
    with LiveView(world, 0) as live, browser.Browser(live.url) as shown:
        shown.wait_for("document.querySelector('canvas') !== null")
        wait_until(lambda: world.steps > 0)
        shown.wait_for("document.body.innerText.includes('real time')")
        yield live, shown


def orange(shown):
    """Return how many pixels of a screenshot have the colour of the first body, and where their middle is."""
    image = pytest.importorskip("PIL.Image")
    pixels = np.asarray(image.open(io.BytesIO(shown.screenshot())).convert("RGB")).astype(int)[160:, :700]
    rows, columns = np.nonzero(pixels[..., 0] > pixels[..., 2] + 60)
    return len(rows), (columns.mean() if len(rows) else 0.0, 160 + rows.mean() if len(rows) else 0.0)


def press(shown, label):
    shown.evaluate(f"[...document.querySelectorAll('button')].find(each => each.innerText == '{label}').click()")


def test_the_browser_shows_the_body_and_its_buttons_and_the_mouse_move_it(page, world):
    live, shown = page
    wait_until(lambda: orange(shown)[0] > 2000)
    press(shown, "pause")
    wait_until(lambda: not live.session.is_playing)
    steps = world.steps
    press(shown, "step")
    wait_until(lambda: world.steps == steps + 1)
    press(shown, "restart")
    wait_until(lambda: live.session.is_playing)
    wait_until(lambda: world.time > 3.0)  # and the ball rests

    x, y = orange(shown)[1]
    low = softbody.SoftBody(world, 0).centre[2]
    shown.mouse("Moved", x, y)
    shown.mouse("Pressed", x, y, buttons=1)
    moves = itertools.count(1)

    def lifted():  # a busy browser drops what the mouse does between two of its frames: the hand moves on until it sees
        move = next(moves)
        shown.mouse("Moved", x + move % 2, y - min(15 * move, 300), buttons=1)
        time.sleep(0.2)
        return live.session.grip.is_holding and softbody.SoftBody(world, 0).centre[2] > low + 0.05

    wait_until(lifted)
    shown.mouse("Released", x, y - 300)
    wait_until(lambda: not live.session.grip.is_holding)
    assert live.error is None


def test_the_browser_shows_a_quantity_in_colours(page):
    live, shown = page
    wait_until(lambda: orange(shown)[0] > 2000)
    live.session.ask(lambda: live.session.show("strain"))
    shown.wait_for("document.body.innerText.includes('yellow')")
    image = pytest.importorskip("PIL.Image")

    def coloured():
        pixels = np.asarray(image.open(io.BytesIO(shown.screenshot())).convert("RGB")).astype(int)[160:, :700]
        return (pixels[..., 1] > pixels[..., 0] + 20).sum() + (pixels[..., 1] > pixels[..., 2] + 60).sum() > 2000

    wait_until(coloured)
    assert live.error is None


def test_the_ground_can_be_hidden(page):
    live, shown = page
    image = pytest.importorskip("PIL.Image")

    def grey():
        pixels = np.asarray(image.open(io.BytesIO(shown.screenshot())).convert("RGB")).astype(int)[160:, :700]
        return ((np.ptp(pixels, axis=-1) < 8) & (pixels[..., 0] < 240)).sum()

    wait_until(lambda: grey() > 10_000)
    shown.evaluate(
        "document.getElementById([...document.querySelectorAll('label')].find(each => each.innerText == 'ground')"
        ".htmlFor).click()"
    )
    wait_until(lambda: grey() < 5_000)
    assert live.error is None
