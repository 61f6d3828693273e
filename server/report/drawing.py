"""The plan of the report, in SVG."""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping
from typing import Any

from server.report.html import Html, join, tag
from web.viser.colors import Palette, Rgb

_PALETTE = Palette("daylight")  # for paper
_MARGIN_M = 1.0

Value = Mapping[str, Any]


def color(name: str) -> str:
    """Return a colour of the palette, for paper."""
    return _code(_PALETTE[name])


def robot_color(robot_id: str) -> str:
    """Return a robot's colour, for paper."""
    return _code(_PALETTE.robot(robot_id))


def _code(rgb: Rgb) -> str:
    return "#{:02x}{:02x}{:02x}".format(*rgb)


def data_address(picture: bytes, kind: str = "image/png") -> str:
    """Return a picture as an address that holds it."""
    return f"data:{kind};base64,{base64.b64encode(picture).decode()}"


def number(value: float) -> str:
    """Return a coordinate in SVG: centimetres are enough."""
    return re.sub(r"\.?0+$", "", f"{value:.2f}") if abs(value) >= 0.005 else "0"


def plan(
    shown: Value | None, png: bytes | None, state: Mapping[str, Value], numbers: Mapping[str, int]
) -> Html:
    """Return the plan at the end: building, links, trails, tags, robots, victims by number, notes."""
    low, high = _extent(shown, state)
    width, height = high[0] - low[0], high[1] - low[1]
    size = max(width, height) / 60.0  # of marks and letters, in metres

    def at(x_m: float, y_m: float) -> tuple[float, float]:
        return x_m - low[0], high[1] - y_m  # the page's y runs down

    parts = []
    if shown is not None and png is not None:
        x_m, y_m = shown["origin_m"]
        w, h = shown["width"] * shown["resolution_m"], shown["height"] * shown["resolution_m"]
        left, top = at(x_m, y_m + h)
        parts.append(
            tag(
                "image",
                href=data_address(png),
                x=number(left),
                y=number(top),
                width=number(w),
                height=number(h),
                preserveAspectRatio="none",
            )
        )
    for trail in _of(state, "trail"):
        points = " ".join(f"{number(x)},{number(y)}" for x, y in (at(*point) for point in trail["points_m"]))
        parts.append(
            tag(
                "polyline",
                points=points,
                fill="none",
                stroke=robot_color(trail["robot_id"]),
                stroke_width=number(size / 6),
                opacity="0.8",
            )
        )
    for each in _of(state, "tag"):
        x, y = at(each["x_m"], each["y_m"])
        r = size / 3
        parts.append(
            tag(
                "path",
                tag("title", each["tag_id"]),
                d=f"M{number(x)} {number(y - r)}l{r:.2f} {r:.2f}l{-r:.2f} {r:.2f}l{-r:.2f} {-r:.2f}Z",
                fill=color("tag"),
            )
        )
    for each in _of(state, "robot"):
        parts.append(
            _mark(
                at(each["x_m"], each["y_m"]),
                size,
                robot_color(each["robot_id"]),
                each["robot_id"],
                f"Robot {each['robot_id']}",
            )
        )
    for each in _of(state, "annotation"):
        if each["x_m"] is not None:
            parts.append(
                _mark(
                    at(each["x_m"], each["y_m"]),
                    size,
                    color("note"),
                    each["text"][:30] or each["kind"],
                    each["text"],
                )
            )
    for each in _of(state, "victim"):
        if each["victim_id"] in numbers:
            parts.append(_victim(at(each["x_m"], each["y_m"]), size, each, numbers[each["victim_id"]]))
    parts.append(_scale(width, height, size))
    view = f"0 0 {number(width)} {number(height)}"
    return tag(
        "svg",
        *parts,
        viewBox=view,
        role="img",
        aria_label="Plan of the building at the end",
        class_="plan",
        style=f"max-height:{'24cm' if height > width else '17cm'}",
    )


def _extent(
    shown: Value | None, state: Mapping[str, Value]
) -> tuple[tuple[float, float], tuple[float, float]]:
    xs, ys = [], []
    if shown is not None:
        x_m, y_m = shown["origin_m"]
        xs += [x_m, x_m + shown["width"] * shown["resolution_m"]]
        ys += [y_m, y_m + shown["height"] * shown["resolution_m"]]
    for kind in ("robot", "victim", "tag"):
        xs += [each["x_m"] for each in _of(state, kind)]
        ys += [each["y_m"] for each in _of(state, kind)]
    if not xs:
        return (-5.0, -5.0), (5.0, 5.0)
    return (min(xs) - _MARGIN_M, min(ys) - _MARGIN_M), (max(xs) + _MARGIN_M, max(ys) + _MARGIN_M)


def _of(state: Mapping[str, Value], kind: str) -> list[Value]:
    return [value for key, value in state.items() if key.startswith(f"{kind}/")]


def _mark(place: tuple[float, float], size: float, fill: str, name: str, title: str) -> Html:
    x, y = place
    circle = tag(
        "circle",
        tag("title", title),
        cx=number(x),
        cy=number(y),
        r=number(size / 2),
        fill=fill,
        stroke="#fff",
        stroke_width=number(size / 8),
    )
    return join((circle, _label(x, y + 1.5 * size, size, name, fill)))


def _victim(place: tuple[float, float], size: float, victim: Value, n: int) -> Html:
    x, y = place
    fill = _code(_PALETTE.victim(victim["status"]))
    side = 1.6 * size
    box = tag(
        "rect",
        tag("title", victim["victim_id"]),
        x=number(x - side / 2),
        y=number(y - side / 2),
        width=number(side),
        height=number(side),
        rx=number(size / 4),
        fill=fill,
        stroke="#fff",
        stroke_width=number(size / 8),
    )
    return join(
        (
            box,
            tag(
                "text",
                n,
                x=number(x),
                y=number(y + 0.4 * size),
                font_size=number(1.1 * size),
                font_weight="700",
                text_anchor="middle",
                fill="#fff",
            ),
        )
    )


def _label(x: float, y: float, size: float, name: str, fill: str) -> Html:
    return tag(
        "text",
        name,
        x=number(x),
        y=number(y),
        font_size=number(0.9 * size),
        text_anchor="middle",
        fill=fill,
        stroke="#fff",
        stroke_width=number(size / 5),
        paint_order="stroke",
        font_weight="600",
    )


def _scale(width: float, height: float, size: float) -> Html:
    length = next(n for n in (100, 50, 20, 10, 5, 2, 1) if n < width / 4 or n == 1)
    x, y = 0.5 * size, height - 0.6 * size
    bar = tag(
        "path",
        d=f"M{number(x)} {number(y - size / 3)}v{number(size / 3)}h{length}v{number(-size / 3)}",
        fill="none",
        stroke="#000",
        stroke_width=number(size / 8),
    )
    return join((bar, _label(x + length / 2, y - 0.4 * size, size, f"{length} m", "#000")))
