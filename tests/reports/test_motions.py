"""Does the page hold what moved, and refuse what is no motion? And does the player show it as the film does?"""

import base64
import json
import zipfile
import zlib
from io import BytesIO

import numpy as np
import pytest

import softbody
from reports import page as pages
from reports.motions import SHAPES, coded, read_motion
from reports.page import page
from reports.reading import CannotRead
from reports.three_js import three_js
from softbody import Camera
from tests.browser import Browser, found
from validation.pictures import Scene, make_picture

EYE = Camera((3.9, -5.6, 2.9), (0.2, 0.0, 0.9))


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """A scene of soft bodies and boxes, as a run leaves it: its folder and its picture."""
    folder = tmp_path_factory.mktemp("report")
    scene = Scene("boxes", "Boxes fall.", softbody.scenes.boxes_on_torus.build, EYE, seconds=0.6)
    return folder, make_picture(scene, folder / "pictures")


def decoded(text, frames, n):
    """Return what `coded` was given (f, n, 3), one number after the other."""
    data = zlib.decompress(base64.b64decode(text))
    codes = [low + 256 * high for low, high in zip(data[: len(data) // 2], data[len(data) // 2 :])]
    off = np.array([code // 2 if code % 2 == 0 else -(code + 1) // 2 for code in codes]).reshape(frames, 3, n)
    whole = np.zeros_like(off)
    whole[0] = off[0]
    whole[1] = whole[0] + off[1]
    for k in range(2, frames):
        whole[k] = 2 * whole[k - 1] - whole[k - 2] + off[k]
    return whole.transpose(0, 2, 1)


def test_any_places_come_back_as_they_were():
    places = np.random.default_rng(0).integers(0, 2**13, (7, 11, 3)).astype(np.uint16)
    text = base64.b64encode(zlib.compress(coded(places))).decode()
    assert (decoded(text, 7, 11) == places).all()


def test_a_motion_holds_where_all_was_and_what_was_measured(filmed):
    folder, picture = filmed
    motion = read_motion(folder / picture.motion, folder, "pictures[0]")
    packed = json.loads(motion.packed)
    n = sum(packed["vertices"])
    places = packed["low"] + packed["part"] * decoded(packed["places"], len(packed["time"]), n)
    world = softbody.scenes.boxes_on_torus.build()
    begin = world.soft_bodies[0].positions
    assert np.abs(places[0, : len(begin)] - begin).max() <= 0.5001 * packed["part"] < 2e-3
    assert motion.seconds == pytest.approx(0.6)
    energy, overlap = motion.curves
    assert energy.least == 0.0 < energy.greatest
    assert 0.0 <= overlap.greatest < 200.0
    assert "def build" in motion.code
    assert "boxes_on_torus.build()" in motion.code


def changed(folder, picture, **arrays):
    """Return a file of which some arrays are others; None takes one away."""
    with np.load(folder / picture.motion) as data:
        all_of_them = {name: data[name] for name in data.files} | arrays
    file = folder / "pictures" / "changed.npz"
    np.savez_compressed(file, **{name: array for name, array in all_of_them.items() if array is not None})
    return file


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("how", ["missing", "text", "one more axis", "objects", "empty"])
def test_an_array_that_is_none_of_a_motion_is_named(filmed, name, how):
    folder, picture = filmed
    with np.load(folder / picture.motion) as data:
        old = data[name]
    new = {
        "missing": None,
        "text": np.array([b"x"]),
        "one more axis": old[None],
        "objects": np.array([{}], dtype=object),
        "empty": old[..., :0] if old.ndim else np.zeros(0),
    }[how]
    file = changed(folder, picture, **{name: new})
    if (name, how) == ("clear", "missing"):  # as of a film that was made before anything could be
        assert not any(json.loads(read_motion(file, folder, "pictures[3]").packed)["clear"])
        return
    with pytest.raises(CannotRead, match=r"pictures\[3\].*film it again"):
        read_motion(file, folder, "pictures[3]")


@pytest.mark.parametrize(
    ("name", "place", "value"),
    [("triangles", (0, 0), 65_535), ("places", (0, 0, 0), 2**13), ("energy", 0, np.nan), ("part", (), np.inf),
     ("time", 1, 0.0), ("vertices", 0, -1), ("faces", 0, 10**9), ("camera", (0, 0, 0), 1e300)],
)  # fmt: skip
def test_a_number_that_cannot_be_is_refused(filmed, name, place, value):
    folder, picture = filmed
    with np.load(folder / picture.motion) as data:
        array = data[name].copy()
    array[place] = value
    with pytest.raises(CannotRead, match="film it again"):
        read_motion(changed(folder, picture, **{name: array}), folder, "pictures[0]")


def test_files_that_are_cut_or_too_large_or_elsewhere_are_refused(filmed, tmp_path):
    folder, picture = filmed
    whole = (folder / picture.motion).read_bytes()
    file = folder / "pictures" / "cut.npz"
    for size in range(0, len(whole) - 1, len(whole) // 40):
        file.write_bytes(whole[:size])
        with pytest.raises(CannotRead):
            read_motion(file, folder, "pictures[0]")
    header = BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": (10**15,)})
    with zipfile.ZipFile(file, "w") as container:
        container.writestr("code.npy", header.getvalue())
    with pytest.raises(CannotRead):
        read_motion(file, folder, "pictures[0]")
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as container:
        container.writestr("code.npy", bytes(2**27))
    with pytest.raises(CannotRead, match="more than"):
        read_motion(file, folder, "pictures[0]")
    with pytest.raises(CannotRead, match="leads out"):
        read_motion(folder / picture.motion, tmp_path, "pictures[0]")


def test_a_page_without_three_js_has_its_films_curves_and_code(filmed, report, monkeypatch):
    folder, picture = filmed
    report.pictures = [picture]
    monkeypatch.setattr(pages, "three_js", lambda: None)
    text = page(report, folder)
    assert text.count("<script") == 1
    assert "deepest overlap" in text
    assert "The lines that made it" in text
    assert "Turn it" not in text


PLACE = """(() => {
  const box = document.querySelector(".canvas").getBoundingClientRect();
  return [box.x + scrollX, box.y + scrollY, box.width, box.height];
})()"""
TO_THE_END = """(() => {
  const slider = document.querySelector(".controls input");
  slider.value = slider.max;
  slider.dispatchEvent(new Event("input"));
})()"""
MIDDLE = """(() => {
  document.querySelector(".canvas").scrollIntoView({ block: "center" });
  const box = document.querySelector(".canvas").getBoundingClientRect();
  return [box.x + box.width / 2, box.y + box.height / 2];
})()"""
FRAMES = """new Promise((go) => {
  let left = 4;
  const next = () => (left-- ? requestAnimationFrame(next) : go(true));
  next();
})"""
FETCHED = (
    "performance.getEntriesByType('resource').map((each) => each.name).filter((name) => !/^(data|blob):/.test(name))"
)
CLOCK = "document.querySelector('.controls output').textContent"


def mask(png):
    """Return what of a picture's middle, 4 wide and 3 high, is neither sky nor ground: what has a colour."""
    from PIL import Image

    picture = Image.open(BytesIO(png)).convert("RGB")
    aside = (picture.width - picture.height * 4 / 3) / 2
    middle = picture.resize((480, 360), box=(aside, 0, picture.width - aside, picture.height))
    return np.ptp(np.asarray(middle).astype(int), axis=2) > 20


def overlap(a, b):
    return (a & b).sum() / (a | b).sum()


@pytest.mark.skipif(found() is None, reason="not run: no browser")
@pytest.mark.skipif(three_js() is None, reason="not run: trimesh has another viewer")
def test_the_player_shows_what_the_film_shows_and_stops_steps_and_turns(filmed, report, tmp_path):
    folder, picture = filmed
    report.pictures = [picture]
    file = folder / "index.html"
    file.write_text(page(report, folder), encoding="utf-8")
    with Browser("about:blank", (1100, 900)) as browser:
        browser.call("Page.enable")
        browser.call("Page.navigate", url=file.as_uri() + "#scene-1")
        browser.wait_for("document.querySelector('.player')?.dataset.ready === 'yes'")
        assert browser.evaluate(FETCHED) == []

        def click(label):
            browser.evaluate(f"document.querySelector(\"[aria-label='{label}']\").click()")

        def seen():
            browser.evaluate(FRAMES)
            clip = dict(zip(("x", "y", "width", "height"), browser.evaluate(PLACE)), scale=1)
            shot = browser.call("Page.captureScreenshot", format="png", clip=clip, captureBeyondViewport=True)
            return mask(base64.b64decode(shot["data"]))

        browser.evaluate(TO_THE_END)
        shown = seen()
        assert browser.evaluate(CLOCK) == "0.60 s of 0.60 s"
        assert overlap(shown, mask((folder / picture.still).read_bytes())) > 0.93  # but for pale stripes and edges
        click("One frame back")
        assert (before := (seen() != shown).sum()) > 20
        assert browser.evaluate(CLOCK) == "0.55 s of 0.60 s"
        click("One frame on")
        assert (seen() != shown).sum() < before / 10
        x, y = browser.evaluate(MIDDLE)
        browser.mouse("Pressed", x, y)
        browser.mouse("Moved", x + 160, y + 20, buttons=1)
        browser.mouse("Released", x + 160, y + 20)
        assert overlap(seen(), shown) < 0.95
        click("Look from where the film does")
        assert overlap(seen(), shown) > 0.999
        browser.evaluate(
            "document.querySelector('.controls select').value = '0.1'"
        )  # far from its end when it is stopped
        click("Play or pause")
        browser.wait_for(f"parseFloat({CLOCK}) > 0 && parseFloat({CLOCK}) < 0.5")
        click("Play or pause")
        stopped = browser.evaluate(CLOCK)
        browser.evaluate(FRAMES)
        assert browser.evaluate(CLOCK) == stopped
