"""The palette of all pages: both themes have the same names; what is read stands out (WCAG 1.4.3, 1.4.11)."""

from __future__ import annotations

import re
from itertools import product

import pytest

from web.mount import STATIC
from web.viser.colors import PALETTE_FILE, ROBOTS, THEMES, Palette, Rgb, robot_color

TEXT, SHAPE = 4.5, 3.0  # smallest contrast
SURFACES = ("ground", "panel", "raised", "raised-more", "sunk")
WORDS = ("text", "text-soft", "text-faint", "accent", "good", "warn", "danger", "best")
ON_MAP = (*(f"robot-{k}" for k in range(1, 13)), "tag", "doubted", "silent", "note")
PAIRS = [
    *((word, surface, TEXT) for word, surface in product(WORDS, SURFACES)),
    *((mark, surface, TEXT) for mark, surface in product(ON_MAP, ("panel", "raised-more", "halo"))),
    *((mark, ground, SHAPE) for mark, ground in product((*ON_MAP, "wall"), ("unknown", "floor"))),
    *(("on-mark", mark, TEXT) for mark in ("good", "warn", "danger", "accent", "silent", "note")),
    ("on-accent", "accent", TEXT),
    ("on-chosen", "chosen", TEXT),
    ("on-best", "best-deep", TEXT),
    ("warn", "warn-deep", TEXT),
    ("on-warn-deep", "warn-deep", TEXT),
    ("danger", "danger-deep", TEXT),
    ("danger", "danger-quiet", TEXT),
    ("on-danger", "danger-strong", TEXT),
    ("on-danger", "danger-pressed", TEXT),
    ("on-danger-deep", "danger-deep", TEXT),
    ("on-danger-deep", "danger-deeper", TEXT),
    ("line-strong", "panel", SHAPE),
    ("line-strong", "raised", SHAPE),
    ("marking", "marking-wall", SHAPE),
]


def _luminance(color: Rgb) -> float:
    """Relative luminance as WCAG 2.2 defines it."""
    shares = [value / 255 for value in color]
    linear = [s / 12.92 if s <= 0.04045 else ((s + 0.055) / 1.055) ** 2.4 for s in shares]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(a: Rgb, b: Rgb) -> float:
    low, high = sorted((_luminance(a), _luminance(b)))
    return (high + 0.05) / (low + 0.05)


def test_contrast_is_what_wcag_says() -> None:
    assert contrast((0, 0, 0), (255, 255, 255)) == pytest.approx(21.0)
    assert contrast((119, 119, 119), (255, 255, 255)) == pytest.approx(4.48, abs=0.01)


@pytest.mark.parametrize("theme", ["dark", "daylight"])
def test_what_is_read_stands_out(theme: str) -> None:
    colors = THEMES[theme]
    weak = [
        f"{front} on {back}: {contrast(colors[front], colors[back]):.2f}"
        for front, back, least in PAIRS
        if contrast(colors[front], colors[back]) < least
    ]
    assert weak == []


def test_both_themes_have_the_same_names_and_pages_use_no_other() -> None:
    assert THEMES["dark"].keys() == THEMES["daylight"].keys()
    known = set(re.findall(r"--([\w-]+):", PALETTE_FILE.read_text()))
    for path in STATIC.rglob("*.css"):
        own = set(re.findall(r"--([\w-]+):", path.read_text()))
        used = set(re.findall(r"var\(--([\w-]+)", path.read_text()))
        basic = {
            "radius",
            "gap",
            "mono",
            "robot",
            "status",
            "alert",
            "size",
            "split",
        }  # set by base.css and scripts
        assert used - known - own - basic == set(), path


def test_plan_and_scene_give_a_robot_the_same_color() -> None:
    for theme, colors in THEMES.items():
        assert len({colors[f"robot-{k}"] for k in range(1, ROBOTS + 1)}) == ROBOTS
        assert robot_color("r1", theme) == robot_color("r13", theme) == colors["robot-1"]
        assert Palette(theme).robot("rover12") == colors["robot-12"]
    assert robot_color("alpha") == robot_color("alpha")
    assert robot_color("alpha") != robot_color("bravo")
