"""The pictures in docs: a live mission of simulated robots as people see it, on screens of several sizes.

``make pictures``, or ``python -m server.benchmarks.pictures docs console-past`` for some of them alone. Look
at them before they are committed.
"""

from __future__ import annotations

import io
import multiprocessing
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PIL import Image

from robots.sim.live import play
from robots.sim.scenario import ScenarioConfig
from server.benchmarks.browser import chromium, server_process

MISSION = "school"
_MINUTES, _SEED = 60.0, 3
_PATIENCE_MS, _SHOT_MS = 1_800_000, 300_000
_WEBGL = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
_EXPLORED = """(clock_s) => {
  const clock = document.querySelector(".bar-figure dd")?.textContent ?? "";
  const [hours, minutes, seconds] = clock.split(":").map(Number);
  return hours * 3600 + minutes * 60 + seconds > clock_s
    && document.querySelector(".victim-card")
    && !document.querySelector(".robot-card:not([data-link=live])");
}"""
_DRAWN = "() => document.querySelector('canvas.building')?.width > 0"
_COLORS = 255


@dataclass(frozen=True, slots=True)
class Team:
    """Robots in a generated building, and how long they explore before the first picture."""

    robots: int = 6
    area_m2: int = 800
    explores_s: float = 120.0


@dataclass(frozen=True, slots=True)
class Picture:
    """A page as it is shown: its size in pixels, look, and what is done on it before it is taken."""

    name: str
    size: tuple[int, int]
    theme: str = "dark"
    look: str = "desk"
    act: Callable[[Any], None] = lambda page: page.wait_for_timeout(2_000)


def _in_3d(page: Any) -> None:
    page.get_by_role("button", name="3D", exact=True).click()
    _wait_for_scene(page)


def _wait_for_scene(page: Any) -> None:
    """Wait for the 3D view, which a wide page has beside the plan from the beginning."""
    scene = page.frame_locator("#scene-pane iframe")
    scene.locator("canvas").first.wait_for(timeout=120_000)
    page.wait_for_timeout(8_000)
    for told in scene.locator(".mantine-Notification-closeButton").all():  # that it is drawn without a GPU
        told.click()
    page.wait_for_timeout(2_000)


def _back_in_time(page: Any) -> None:
    slider = page.get_by_label("Moment of the mission")
    slider.evaluate(
        """(slider) => {
          slider.value = String(0.45 * Number(slider.max));
          slider.dispatchEvent(new Event("input", { bubbles: true }));
        }"""
    )
    page.locator(".past-banner").wait_for(timeout=60_000)
    page.wait_for_timeout(4_000)


PICTURES = (
    Picture("console", (1920, 1080), act=_wait_for_scene),
    Picture("console-daylight", (1366, 768), "daylight"),
    Picture("console-past", (1366, 768), act=_back_in_time),
    Picture("console-wall", (2560, 1440), look="wall", act=_wait_for_scene),
    Picture("console-phone", (390, 844)),
    Picture("console-3d", (1920, 1080), "daylight", act=_in_3d),
)


def take(folder: Path, names: Sequence[str] = (), team: Team | None = None) -> None:
    """Write the pictures of these names, else all; takes as long as the robots need to see enough.

    Raises:
        CannotMeasureError: there is no browser here.
    """
    team = team or Team()
    with server_process() as home, chromium(*_WEBGL) as browser:
        driving = multiprocessing.get_context("spawn").Process(target=_drive, args=(home, team), daemon=True)
        driving.start()
        try:
            for picture in PICTURES:
                if names and picture.name not in names:
                    continue
                page = _open(browser, home, picture)
                page.wait_for_function(_EXPLORED, arg=team.explores_s, timeout=_PATIENCE_MS)
                picture.act(page)
                _save(page.screenshot(timeout=_SHOT_MS), folder / f"{picture.name}.png")
                page.close()
        finally:
            driving.kill()
            driving.join()


def _drive(home: str, team: Team) -> None:
    config = ScenarioConfig(map=f"office:{team.area_m2}", robots=team.robots, minutes=_MINUTES, seed=_SEED)
    play(config, home, MISSION, name="Collapsed school", responder="Kim")


def _open(browser: Any, home: str, picture: Picture) -> Any:
    width, height = picture.size
    page = browser.new_page(viewport={"width": width, "height": height})
    look = f'{{"theme": "{picture.theme}", "size": "{picture.look}"}}'
    page.add_init_script(f"localStorage.setItem('waymark.look', '{look}')")
    page.goto(f"{home}/console")
    page.wait_for_function(_DRAWN, timeout=_PATIENCE_MS)
    return page


def _save(png: bytes, path: Path) -> None:
    """Write a picture in so few colours that it stays small."""
    picture = Image.open(io.BytesIO(png)).convert("RGB")
    picture.quantize(_COLORS, dither=Image.Dither.NONE).save(path, optimize=True)


if __name__ == "__main__":
    take(Path(sys.argv[1]), sys.argv[2:])
