"""A live simulated sensor and a browser that shows its page.

`cargo xtask page-test` sets the variables: the command, Chromium, and a folder for screenshots.
"""

from __future__ import annotations

import json
import os
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

COMMAND = os.environ["FINGERVISION_COMMAND"]
CHROMIUM = os.environ["FINGERVISION_CHROMIUM"]
SCREENSHOTS = Path(os.environ["FINGERVISION_SCREENSHOTS"])

# Without the network of an update, without a graphics processor: SwiftShader draws WebGL 2.
OPTIONS = ["--no-sandbox", "--disable-background-networking", "--disable-component-update", "--enable-unsafe-swiftshader"]
NOTE = "the page: "
# The press is solved first.
LONGEST_START_S = 120.0


class Sensor:
    """`fingervision live` with a press that repeats without end."""

    def __init__(self, folder: Path, port: int = 0) -> None:
        """Starts it in a folder, where its recordings go, and waits for its page."""
        scene = "sim:letter?loop&draft&fps=20"
        arguments = [COMMAND, "live", scene, "--json", "--port", str(port)]
        self.folder = folder
        self.notes = folder / "notes.txt"
        with self.notes.open("w") as notes:
            self.program = subprocess.Popen(arguments, cwd=folder, stderr=notes, stdout=subprocess.DEVNULL)
        self.address = self.wait_for_page()

    def wait_for_page(self) -> str:
        """The address of the page, from the notes on standard error."""
        end = time.monotonic() + LONGEST_START_S
        while time.monotonic() < end:
            for line in self.notes.read_text().splitlines():
                note = json.loads(line).get("note", "") if line.endswith("}") else ""
                if note.startswith(NOTE):
                    return note.removeprefix(NOTE)
            time.sleep(0.1)
        self.kill()
        raise AssertionError("no page: " + self.notes.read_text())

    @property
    def port(self) -> int:
        """The port of the page."""
        return int(self.address.rstrip("/").rsplit(":", 1)[1])

    def __enter__(self) -> Sensor:
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()

    def kill(self) -> None:
        """Ends it at once, as a power cut does."""
        self.program.kill()
        self.program.wait()


@pytest.fixture(scope="session")
def sensor(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Sensor]:
    """A sensor that runs for all tests."""
    with Sensor(tmp_path_factory.mktemp("live")) as running:
        yield running


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Chromium, for all tests."""
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=OPTIONS)
        yield chromium
        chromium.close()


@pytest.fixture
def page(browser: Browser, sensor: Sensor) -> Iterator[Page]:
    """The page of the sensor, live."""
    page = open_page(browser, sensor)
    yield page
    page.context.close()


def open_page(browser: Browser, sensor: Sensor, size: tuple[int, int] = (1280, 800), scheme: str = "light") -> Page:
    """Opens the page of a sensor, and waits until it shows readings."""
    # The page allows no scripts from text, which is what these tests wait with.
    context = browser.new_context(
        viewport={"width": size[0], "height": size[1]},
        color_scheme="dark" if scheme == "dark" else "light",
        bypass_csp=True,
    )
    page = context.new_page()
    page.goto(sensor.address)
    wait_until_live(page)
    return page


def wait_until_live(page: Page) -> None:
    """Waits until the page shows new readings."""
    page.wait_for_function("document.getElementById('state').textContent === 'Live'", timeout=60_000)
