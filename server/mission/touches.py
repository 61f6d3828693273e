"""Tags that people touched one after the other and that cannot both be where the map has them."""

from __future__ import annotations

from math import hypot

from robots.routes.pace import is_too_far
from robots.routes.words import metres
from server.board import Board
from server.mission.goals import sd_of
from server.schemas.reports import ReportIn


def too_far(board: Board, by: str, said: ReportIn) -> str | None:
    """Return what to tell of somebody at a tag who says at which one they were before, and how long ago.

    None where they can have come from there, or where one of the two has no place or is doubted already.
    """
    tag, before = (board.get(f"tag/{name}") for name in (said.tag_id, said.from_tag))
    if tag is None or before is None or said.after_s is None:
        return None
    if tag["state"] != "sound" or before["state"] != "sound":
        return None
    far_m = hypot(tag["x_m"] - before["x_m"], tag["y_m"] - before["y_m"])
    if not is_too_far(far_m, hypot(sd_of(tag), sd_of(before)), said.after_s):
        return None
    return (
        f"{by} touched tag {said.tag_id} {said.after_s:.0f} s after tag {said.from_tag}, which is "
        f"{metres(far_m)} away on the map: nobody is that fast. There are two tags {said.tag_id}, or one "
        "of the two was moved; have somebody look before you go by them."
    )
