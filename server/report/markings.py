"""Markings as they are sprayed, in SVG."""

from __future__ import annotations

from collections.abc import Sequence

from server.markings.shapes import Marking, Shape
from server.report.drawing import color
from server.report.html import Html, tag


def sprayed(markings: Sequence[Marking]) -> Html:
    """Return markings side by side, each with its name; nothing where there are none."""
    if not markings:
        return Html("")
    return tag("div", *map(_figure, markings), class_="markings")


def _figure(marking: Marking) -> Html:
    drawn = tag(
        "svg",
        *map(_drawn, marking.shapes),
        viewBox=f"0 0 {marking.width} {marking.height}",
        role="img",
        aria_label=f"{marking.name}: {marking.words}",
    )
    return tag("figure", drawn, tag("figcaption", marking.name), class_=f"marking-{marking.width}")


def _drawn(shape: Shape) -> Html:
    paint = color("marking")
    if "text" in shape:
        x, y = shape["at"]
        return tag(
            "text", shape["text"], x=x, y=y, text_anchor=shape["anchor"],
            font_size=shape["size"], font_weight=700, fill=paint,
        )  # fmt: skip
    line = {"fill": "none", "stroke": paint, "stroke_width": shape["width"], "stroke_linecap": "square"}
    if "ring" in shape:
        x, y, r = shape["ring"]
        return tag("circle", cx=x, cy=y, r=r, **line)
    return tag("path", d=shape["path"], **line)
