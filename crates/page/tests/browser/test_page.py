"""What a person sees on the page, and does with it."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from conftest import CHROMIUM, COMMAND, OPTIONS, SCREENSHOTS, Sensor, open_page, wait_until_live
from playwright.sync_api import expect

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

MAP = ".panel.map canvas"
SURFACE = ".panel.surface canvas"
MOST_BYTES = 300_000
# The first number of a sensor.
DEPTH = "Number(document.querySelector('.numbers dd').textContent.split(' ')[0])"
# Resolves when the page has been drawn twice: the first drawing may have begun already.
DRAWN = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
# The numbers that do not fit into their boxes when they are long.
TOO_WIDE = (
    "[...document.querySelectorAll('.numbers dd')].filter("
    "dd => { dd.firstChild.textContent = '1122 / 1813 '; return dd.scrollWidth > dd.clientWidth; })"
    ".map(dd => dd.textContent)"
)
PICTURE = "selector => document.querySelector(selector).toDataURL()"


def picture(page: Page, selector: str) -> str:
    """The picture of a canvas, as text."""
    return str(page.evaluate(PICTURE, selector))


def wait_for_another(page: Page, selector: str, before: str) -> None:
    """Waits until a canvas shows another picture."""
    page.wait_for_function(
        "([selector, before]) => document.querySelector(selector).toDataURL() !== before", arg=[selector, before]
    )


def test_the_page_is_light_and_loads_nothing_from_elsewhere(page: Page, sensor: Sensor) -> None:
    entries = page.evaluate(
        "[...performance.getEntriesByType('navigation'), ...performance.getEntriesByType('resource')]"
        ".map(entry => [entry.name, entry.transferSize])"
    )
    assert all(name.startswith((sensor.address, "data:")) for name, _ in entries), entries
    assert sum(size for _, size in entries) <= MOST_BYTES, entries
    paint = page.evaluate("performance.getEntriesByName('first-contentful-paint')[0].startTime")
    figures = f"{len(entries)} files, {sum(size for _, size in entries) / 1e3:.0f} kB, first paint after {paint:.0f} ms\n"
    (SCREENSHOTS / "figures.txt").write_text(figures)


def test_depth_is_shown_and_moves(page: Page) -> None:
    page.wait_for_function(f"{DEPTH} > 0.5", timeout=60_000)
    before = picture(page, MAP)
    wait_for_another(page, MAP, before)
    assert page.locator(".health li").count() > 0


def test_the_surface_can_be_turned(page: Page) -> None:
    # Depth to look at, and then nothing moves by itself.
    page.wait_for_function(f"{DEPTH} > 0.5", timeout=60_000)
    page.keyboard.press("Space")
    page.wait_for_timeout(500)
    still = picture(page, SURFACE)
    page.wait_for_timeout(500)
    assert picture(page, SURFACE) == still
    box = page.locator(SURFACE).bounding_box()
    assert box is not None
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.move(*middle)
    page.mouse.down()
    page.mouse.move(middle[0] + 80, middle[1] + 30, steps=5)
    page.mouse.up()
    wait_for_another(page, SURFACE, still)
    turned = picture(page, SURFACE)
    page.locator(SURFACE).focus()
    page.keyboard.press("ArrowRight")
    wait_for_another(page, SURFACE, turned)


def test_the_last_minute_can_be_looked_at(page: Page) -> None:
    page.wait_for_timeout(3000)
    page.keyboard.press("Space")
    expect(page.locator("#state")).to_have_text("Paused")
    pictures = {picture(page, MAP)}
    # A press shows each depth on the way in and on the way out: not every moment shows another picture.
    for back in (1.0, 1.5, 2.0, 2.5):
        page.locator("#time").fill(str(-back))
        expect(page.locator("#time-text")).to_have_text(f"{back:.1f} s before")
        page.evaluate(DRAWN)
        pictures.add(picture(page, MAP))
    assert len(pictures) > 1
    page.locator("#pause").click()
    wait_until_live(page)


def test_a_recording_is_made_and_can_be_tracked(page: Page, sensor: Sensor, tmp_path: Path) -> None:
    page.keyboard.press("r")
    page.wait_for_function("document.getElementById('recording').textContent.startsWith('Recording to')")
    page.wait_for_timeout(1500)
    page.locator("#record").click()
    page.wait_for_function("document.getElementById('record').getAttribute('aria-pressed') === 'false'")
    [recording] = sensor.folder.glob("*.mcap")
    tracked = subprocess.run(
        [COMMAND, "track", recording, "--out", tmp_path / "run", "--quiet"], capture_output=True, text=True, timeout=300
    )
    assert tracked.returncode == 0, tracked.stderr
    assert (tmp_path / "run" / "depth.npy").exists()


def test_a_rezero_is_done_and_said(browser: Browser, tmp_path: Path) -> None:
    # On a sensor of its own: the gel may be pressed at this moment.
    with Sensor(tmp_path) as sensor:
        page = open_page(browser, sensor)
        page.keyboard.press("z")
        page.wait_for_function("/zero/i.test(document.getElementById('events').textContent)")
        wait_until_live(page)
        page.context.close()


def test_the_keys_are_listed(page: Page) -> None:
    page.keyboard.press("?")
    expect(page.locator("#help")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.locator("#help")).to_be_hidden()


def test_a_reload_is_survived(page: Page) -> None:
    page.reload()
    wait_until_live(page)
    wait_for_another(page, MAP, picture(page, MAP))


def test_a_lost_program_is_said_and_found_again(browser: Browser, tmp_path: Path) -> None:
    with Sensor(tmp_path) as first:
        page = open_page(browser, first)
    page.wait_for_function("document.getElementById('state').textContent === 'Connection lost'")
    with Sensor(tmp_path, first.port):
        wait_until_live(page)
    page.context.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize(("name", "size"), [("desk", (1280, 800)), ("phone", (390, 844))])
def test_everything_fits_on_the_screen(
    browser: Browser, sensor: Sensor, name: str, size: tuple[int, int], scheme: str
) -> None:
    page = open_page(browser, sensor, size, scheme)
    page.wait_for_function(f"{DEPTH} > 1", timeout=60_000)
    page.screenshot(path=SCREENSHOTS / f"{name}-{scheme}.png", full_page=True)
    assert page.evaluate("document.documentElement.scrollWidth") <= size[0]
    assert page.evaluate(TOO_WIDE) == []
    page.context.close()


def test_a_browser_without_webgl_says_so(sensor: Sensor, browser: Browser) -> None:
    chromium = browser.browser_type.launch(executable_path=CHROMIUM, args=[*OPTIONS[:-1], "--disable-3d-apis"])
    page = open_page(chromium, sensor)
    expect(page.locator(".panel.surface .note")).to_contain_text("no WebGL 2")
    chromium.close()


def test_nothing_is_reported_to_the_console(sensor: Sensor, browser: Browser) -> None:
    # With the page's own policy on scripts.
    page = browser.new_page()
    said: list[str] = []
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("console", lambda message: said.append(message.text) if message.type == "error" else None)
    page.goto(sensor.address)
    page.locator("#state", has_text="Live").wait_for(timeout=60_000)
    page.keyboard.press("Space")
    page.keyboard.press("a")
    page.keyboard.press("t")
    page.wait_for_timeout(500)
    assert said == []
    page.close()
