"""Each viewer's own camera: over the whole building, stepping back as it grows, until the viewer moves it."""

from __future__ import annotations

from math import hypot, tan
from typing import Any

import numpy as np
import viser

from web.viser.map_layer import Grid

_SLANT = 0.6  # distance aside per height; 0 would be straight above
_FROM_ABOVE = 0.02  # straight above has no up direction
_MARGIN = 1.3  # of the view beyond the building
_SMALLEST_M = 6.0
_CLOSE_M = 14.0  # a room and its neighbours fill the view
_STEP_M = 0.05  # by less nobody sees a robot move


class Cameras:
    """Places the cameras, and gives each viewer two buttons that place it again."""

    def __init__(self, server: viser.ViserServer):
        self._server = server
        self._low = np.full(2, np.inf)  # corners of all that was drawn, in metres
        self._high = np.full(2, -np.inf)
        self._placed: dict[int, tuple[float, Any, Any]] = {}  # viewer -> slant, position, frame when placed
        server.on_client_connect(self._welcome)

    def see(self, x_m: float, y_m: float) -> None:
        """Take a point into what has to be in view."""
        self._low = np.minimum(self._low, (x_m - 1.0, y_m - 1.0))
        self._high = np.maximum(self._high, (x_m + 1.0, y_m + 1.0))

    def see_grid(self, grid: Grid) -> None:
        """Take the known part of a grid into view, and forget what was in view before."""
        rows, columns = np.nonzero(grid.cells >= 0)
        if len(rows):
            origin = np.array(grid.origin_m)
            self._low = origin + grid.resolution_m * np.array((columns.min(), rows.min()))
            self._high = origin + grid.resolution_m * np.array((columns.max() + 1, rows.max() + 1))

    def keep_in_view(self) -> None:
        """Step back as the building grows, for every viewer who has not moved the camera since."""
        clients = self._server.get_clients()
        for gone in self._placed.keys() - clients.keys():
            del self._placed[gone]
        for client_id, client in clients.items():
            slant, position, frame = self._placed.get(client_id, (_SLANT, None, None))
            is_ours = position is not None and np.allclose(client.camera.position, position, atol=0.05)
            if is_ours and not np.allclose(self._frame(client), frame, atol=0.5):
                self._look(client, slant)

    def centre(self, client: viser.ClientHandle, place: tuple[float, float]) -> None:
        """Let a viewer look at a place, in metres, from where they look now, and not from far off."""
        aside = np.asarray(client.camera.position) - client.camera.look_at
        distance_m = float(np.linalg.norm(aside))
        self._look_at(client, place, aside * min(1.0, _CLOSE_M / distance_m))

    def follow(self, client: viser.ClientHandle, place: tuple[float, float], is_new: bool) -> None:
        """Take a viewer along to a place, however they have turned or come closer meanwhile."""
        if is_new:
            self.centre(client, place)
        elif float(np.hypot(*(client.camera.look_at[:2] - place))) > _STEP_M:
            self._look_at(client, place, np.asarray(client.camera.position) - client.camera.look_at)

    def _look_at(self, client: viser.ClientHandle, place: tuple[float, float], aside: Any) -> None:
        self._placed[client.client_id] = (_SLANT, None, None)  # it is no more for us to step back
        target = np.append(place, 0.0)
        with client.atomic():
            client.camera.position = target + aside
            client.camera.look_at = target

    def _welcome(self, client: viser.ClientHandle) -> None:
        overview = client.gui.add_button("Overview", hint="Look at the whole building at a slant")
        above = client.gui.add_button("From above", hint="Look straight down on the whole building")
        overview.on_click(lambda _event: self._look(client, _SLANT))
        above.on_click(lambda _event: self._look(client, _FROM_ABOVE))
        self._look(client, _SLANT)

    def begin_over_all(self) -> None:
        """Put the camera of whoever comes over all that was drawn."""
        extent = self._extent()
        centre = np.append(extent.mean(axis=0), 0.0)
        distance_m = _MARGIN * float((extent[1] - extent[0]).max())
        start = self._server.initial_camera
        start.position = centre + distance_m * np.array((0.0, -_SLANT, 1.0)) / hypot(_SLANT, 1.0)
        start.look_at = centre

    def _extent(self) -> Any:
        """Return the lower and upper corner, shape (2, 2) in metres; a small square if nothing is known."""
        if not np.isfinite(self._low).all():
            return np.array(((-_SMALLEST_M, -_SMALLEST_M), (_SMALLEST_M, _SMALLEST_M))) / 2.0
        return np.array((self._low, self._high))

    def _frame(self, client: viser.ClientHandle) -> Any:
        """Return what decides where a camera belongs, shape (5,): extent, and height of a view 10 wide."""
        return np.append(self._extent(), 10.0 / client.camera.aspect)

    def _look(self, client: viser.ClientHandle, slant: float) -> None:
        """Put a viewer's camera over the middle of what is known, so far off that all of it is in view."""
        extent = self._extent()
        centre = np.append(extent.mean(axis=0), 0.0)
        width_m, depth_m = np.maximum(extent[1] - extent[0], _SMALLEST_M)
        reach = tan(client.camera.fov / 2.0)  # half the view's height at distance 1
        distance_m = _MARGIN / 2.0 * max(depth_m / reach, width_m / (reach * client.camera.aspect))
        position = centre + distance_m * np.array((0.0, -slant, 1.0)) / hypot(slant, 1.0)
        with client.atomic():
            client.camera.up_direction = (0.0, 0.0, 1.0)
            client.camera.position = position
            client.camera.look_at = centre
        self._placed[client.client_id] = (slant, position, self._frame(client))
