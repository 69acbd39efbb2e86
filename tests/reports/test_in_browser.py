"""The page as a reader has it: in a browser, wide and narrow, dark, without scripts, without network."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from reports.page import page
from tests.browser import Browser, found

pytestmark = pytest.mark.skipif(found() is None, reason="not run: no browser")

LONG = " of the mobility, of the push, of the motion and of the impulse"  # a unit of a claim, all in one line

CONTRAST = 4.5  # of text against its ground, at least: WCAG 2.2, level AA

# The least contrast of all texts that are seen, and where.
LEAST_CONTRAST = """(() => {
  const numbers = (text) => text.match(/[\\d.]+/g).map(Number);
  const linear = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
  const light = ([r, g, b]) => 0.2126 * linear(r / 255) + 0.7152 * linear(g / 255) + 0.0722 * linear(b / 255);
  const ground = (node) => {
    for (let each = node; each; each = each.parentElement) {
      const colour = numbers(getComputedStyle(each).backgroundColor);
      if (colour.length === 3 || colour[3] === 1) return colour.slice(0, 3);
    }
    return [255, 255, 255];
  };
  let least = [99, ""];
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const node = walk.currentNode.parentElement;
    if (!walk.currentNode.textContent.trim() || node.closest("svg, script, style") || !node.checkVisibility()) continue;
    const [a, b] = [numbers(getComputedStyle(node).color), ground(node)].map(light).sort((x, y) => y - x);
    const contrast = (a + 0.05) / (b + 0.05);
    if (contrast < least[0]) least = [contrast, `${node.outerHTML}`.slice(0, 200)];
  }
  return least;
})()"""


@pytest.fixture
def shown(tmp_path, report) -> Callable:
    """Return a function that shows the page of a report: of a width, light or dark, with scripts or without."""
    for claim in report.claims:
        claim.unit += "" if claim.unit == "disagreements" else LONG
    file = tmp_path / "index.html"
    file.write_text(page(report), encoding="utf-8")

    @contextmanager
    def show(width: int, scheme: str = "light", scripts: bool = True, place: str = "") -> Iterator[Browser]:
        with Browser("about:blank", (width, 900)) as browser:
            browser.call("Page.enable")
            browser.call(
                "Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=width < 600
            )
            browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
            browser.call("Emulation.setScriptExecutionDisabled", value=not scripts)
            browser.call("Page.navigate", url=file.as_uri() + place)
            browser.wait_for("location.href.startsWith('file:') && document.readyState === 'complete'")
            yield browser

    return show


@pytest.mark.parametrize("width", [1900, 1400, 1000, 700, 500, 390, 320])
def test_nothing_is_wider_than_the_window(shown, width):
    with shown(width) as browser:
        assert browser.evaluate("document.scrollingElement.scrollWidth") <= width
        browser.evaluate("document.querySelectorAll('details').forEach((each) => { each.open = true; })")
        assert browser.evaluate("document.scrollingElement.scrollWidth") <= width


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_text_can_be_read(shown, scheme):
    with shown(1400, scheme) as browser:
        browser.evaluate("document.querySelectorAll('details').forEach((each) => { each.open = true; })")
        contrast, where = browser.evaluate(LEAST_CONTRAST)
        assert contrast >= CONTRAST, where


def test_nothing_is_fetched(shown):
    with shown(1400) as browser:
        names = browser.evaluate("performance.getEntriesByType('resource').map((each) => each.name)")
        assert [name for name in names if not name.startswith("data:")] == []


def test_words_and_lists_narrow_the_claims_down(shown, report):
    with shown(1400) as browser:
        seen = "[...document.querySelectorAll('details.claim')].filter((each) => !each.hidden).length"
        type_in = "(text) => {{ const box = document.querySelector('{0}'); box.value = text; "
        type_in += "box.dispatchEvent(new Event('input', {{ bubbles: true }})); }}"
        assert browser.evaluate(seen) == len(report.claims)
        browser.evaluate(f"({type_in.format('#find [type=search]')})('pybullet')")
        wanted = [claim for claim in report.claims if "pybullet" in claim.engines]
        assert 0 < len(wanted) <= browser.evaluate(seen) < len(report.claims)
        browser.evaluate(f"({type_in.format('#find [type=search]')})('')")
        browser.evaluate(f"({type_in.format('#find select')})('fails')")
        assert browser.evaluate(seen) == sum(claim.verdict == "fails" for claim in report.claims)


def test_what_is_looked_for_is_in_the_address_and_words_that_mean_the_same_are_found(shown, report):
    seen = "[...document.querySelectorAll('details.claim')].filter((each) => !each.hidden).map((each) => each.id)"
    with shown(1400) as browser:
        browser.evaluate(
            "((box) => { box.value = 'Collision'; box.dispatchEvent(new Event('input', { bubbles: true })); })"
            "(document.querySelector('#find [type=search]'))"
        )
        place, those = browser.evaluate("location.hash"), browser.evaluate(seen)
        assert place == "#find=Collision"
    with shown(1400, place=place) as browser:
        assert browser.evaluate(seen) == those
    with shown(1400, place="#find=contact") as browser:
        assert browser.evaluate(seen) == those
    assert 0 < len(those) < len(report.claims)


def test_a_link_to_a_family_opens_it(shown):
    with shown(1400) as browser:
        anchor = browser.evaluate("document.querySelectorAll('details.family')[2].id")
    with shown(1400, place=f"#{anchor}") as browser:
        assert browser.evaluate(f"document.getElementById('{anchor}').open")


def test_a_link_to_a_claim_opens_it(shown):
    with shown(1400) as browser:
        anchor = browser.evaluate("document.querySelectorAll('details.claim')[20].id")
    with shown(1400, place=f"#{anchor}") as browser:
        assert browser.evaluate(f"document.getElementById('{anchor}').checkVisibility()")
        assert browser.evaluate(f"document.getElementById('{anchor}').open")


def test_it_is_whole_without_scripts(shown, report):
    with shown(1400, scripts=False) as browser:
        assert browser.evaluate("document.querySelectorAll('details.claim').length") == len(report.claims)
        assert browser.evaluate("document.getElementById('find').hidden")
