"""The 3D view and the plan of one page: the same things, and the same selection, marked and clicked there."""

from __future__ import annotations

import io
import uuid
from collections.abc import Callable
from typing import Any

import httpx
import numpy as np
import pytest
from fastapi import FastAPI
from PIL import Image
from playwright.sync_api import Browser, Page, expect

pytestmark = pytest.mark.browser

SOON_MS = 60_000  # a page beside a scene that is drawn in software


def write_on(client: httpx.Client, at: str, tag: str) -> None:
    """A plan under the map, a sector, a hazard and a photo."""
    plan, photo = io.BytesIO(), io.BytesIO()
    cells = np.full((160, 240), 255, np.uint8)
    cells[[0, -1], :] = cells[:, [0, -1]] = cells[:100, 120] = 0
    Image.fromarray(cells).save(plan, "PNG")
    Image.new("RGB", (64, 48), (200, 80, 40)).save(photo, "JPEG")
    where = {"resolution_m": 0.1, "origin_x_m": -8.0, "origin_y_m": -8.0, "source": "the owner's plan"}
    png, jpeg = {"Content-Type": "image/png"}, {"Content-Type": "image/jpeg"}
    client.put(f"{at}/base-map", params=where, content=plan.getvalue(), headers=png).raise_for_status()
    sector = {"name": "B2", "area_m": [[-1, -4], [3, -4], [3, 0], [-1, 0]], "status": "second_look"}
    client.put(f"{at}/sectors/{uuid.uuid4()}", json=sector).raise_for_status()
    hazard = {"kind": "hazard", "text": "smell of gas", "x_m": 5.0, "y_m": -2.0}
    client.put(f"{at}/annotations/{uuid.uuid4()}", json=hazard).raise_for_status()
    of = {"photo_id": str(uuid.uuid4()), "tag_id": tag}
    client.post(f"{at}/photos", params=of, content=photo.getvalue(), headers=jpeg).raise_for_status()


class View:
    """The 3D part of a page: how viser's side of it stands, and where in the page a place is seen."""

    def __init__(self, page: Page, app: FastAPI) -> None:
        self.page = page
        self._server = app.state.scenes._running["drill"].scene("daylight")._server
        self.until(self._server.get_clients)

    @property
    def client(self) -> Any:
        """The one viewer: another one after a page that was too busy to be heard was let go and came back."""
        self.until(self._server.get_clients)
        return list(self._server.get_clients().values())[-1]

    def has(self, name: str) -> bool:
        """Whether a node of this viewer's own is there."""
        return self.client.scene.get_handle_by_name(name) is not None

    def marked(self) -> tuple[float, ...] | None:
        """Where the mark stands, x and y; None where there is none."""
        frame = self.client.scene.get_handle_by_name("/selected")
        return None if frame is None else tuple(frame.position[:2])

    def looks_at(self, x_m: float, y_m: float) -> bool:
        return bool(np.allclose(self.client.camera.look_at, (x_m, y_m, 0.0), atol=0.05))

    def is_as_wide_as_its_pane(self) -> bool:
        """Whether viser knows of the pane's size as it is; it tells when its camera moves."""
        box = self.page.locator("#scene-pane").bounding_box()
        assert box is not None
        self.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        self.page.mouse.wheel(0, 1)
        return bool(abs(self.client.camera.image_width - box["width"]) < 2)

    def click(self, x_m: float, y_m: float, z_m: float = 0.0) -> None:
        """Click where a place is seen."""
        camera = self.client.camera
        along = camera.look_at - camera.position
        along /= np.linalg.norm(along)
        right = np.cross(along, (0.0, 0.0, 1.0))
        right /= np.linalg.norm(right)
        there = np.array((x_m, y_m, z_m)) - camera.position
        shares = np.array((there @ right, there @ np.cross(along, right))) / (there @ along)
        box = self.page.locator("#scene-pane").bounding_box()
        assert box is not None
        half = box["height"] / 2
        x, y = shares / np.tan(camera.fov / 2) * half + (box["width"] / 2, half)
        self.page.mouse.click(box["x"] + x, box["y"] + y)

    def until(self, condition: Callable[[], Any], seconds: int = 60) -> None:
        for _ in range(5 * seconds):
            if condition():
                return
            self.page.wait_for_timeout(200)
        pytest.fail("it did not happen in time")


def test_what_is_selected_is_marked_in_3d_and_what_is_clicked_there_is_selected(
    browser: Browser, drill: dict[str, Any]
) -> None:
    tag = drill["tags"][0]
    with httpx.Client(base_url=f"http://{drill['host']}/api/v1", timeout=90) as client:
        write_on(client, "/missions/drill", tag)
        place = client.get(f"/missions/drill/tags/{tag}").json()
    x_m, y_m = place["x_m"], place["y_m"]
    page = browser.new_page(viewport={"width": 1190, "height": 560}, color_scheme="light")
    card = page.locator(f".tag-card[data-tag='{tag}']")
    try:
        page.goto(f"http://{drill['host']}/console?mission=drill")
        expect(page.locator(".connection")).to_have_text("Live", timeout=SOON_MS)
        page.get_by_role("button", name="2D + 3D", exact=True).click()
        expect(page.locator("#scene-pane iframe")).to_be_visible(timeout=SOON_MS)
        view = View(page, drill["app"])

        # a robot by its card, a victim by its key, a tag by its name: marked, and the camera over it
        page.locator(".robot-card .card-body").click()
        view.until(view.marked)
        of_robot = view.marked()
        page.keyboard.press("j")
        view.until(lambda: view.marked() not in (None, of_robot))
        page.get_by_label("Find a robot").fill(tag)
        page.keyboard.press("Enter")
        expect(card).to_be_visible(timeout=SOON_MS)
        view.until(lambda: view.has("/selected/label") and view.looks_at(x_m, y_m))
        assert view.marked() == pytest.approx((x_m, y_m), abs=1e-3)
        page.locator("#plan").focus()
        page.keyboard.press("Escape")
        expect(card).to_have_count(0)
        view.until(lambda: not view.has("/selected"))

        # clicked in 3D: a tag, its photo, the ground of a sector
        view.click(x_m, y_m)
        expect(card).to_be_visible(timeout=SOON_MS)
        view.until(lambda: view.has("/selected/label"))
        view.click(x_m + 0.45, y_m - 0.45, 1.2)
        photo = page.get_by_role("dialog", name="Photo")
        expect(photo).to_be_visible(timeout=SOON_MS)
        photo.get_by_role("button", name="Close").click()
        view.click(2.0, -3.0)
        expect(page.get_by_role("region", name="Sector B2")).to_be_visible(timeout=SOON_MS)
        expect(card).to_have_count(0)
        view.until(lambda: view.has("/selected/outline"))

        # without the plan the cards are there as well
        page.get_by_role("button", name="Close the sectors").click()
        page.get_by_role("button", name="3D", exact=True).click()
        expect(page.locator("#plan")).to_be_hidden()
        view.until(view.is_as_wide_as_its_pane)
        view.click(x_m, y_m)
        expect(card).to_be_in_viewport()
        view.until(lambda: view.has("/selected/ring"))
    finally:
        page.close()
