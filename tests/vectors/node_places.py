"""Where one is by what one hears of nodes: what server and phone are both held to.

`python -m tests.vectors.node_places` writes the file anew.
"""

from __future__ import annotations

import json
from math import hypot, log10, sqrt
from pathlib import Path
from typing import Any

import numpy as np

from robots.config import RadioConfig
from robots.estimation.radio.hearing import Ears, NodePlace
from robots.estimation.radio.locating import Located, Plan, Since, locate
from robots.estimation.radio.model import NODE
from robots.routes.fix_words import fix_text
from server.mission.locating import radio_value

FILE = Path(__file__).with_suffix(".json")
CASES = 24


def vectors() -> list[dict[str, Any]]:
    """Return all cases: what a phone carries and hears, and what comes of it."""
    return [_case(seed) for seed in range(CASES)]


def _case(seed: int) -> dict[str, Any]:
    rng = np.random.default_rng([seed, 7])
    radio = NODE if seed % 3 else RadioConfig(-59.0, 3.27, 5.2, fading_sd_db=1.0)
    count = 1 + seed % 6
    tags = [
        {
            "tag_id": f"N{k}",
            "x_m": round(float(rng.uniform(0, 16)), 2),
            "y_m": round(float(rng.uniform(0, 12)), 2),
            "sd_m": round(float(rng.uniform(0.05, 0.4)), 3),
        }
        for k in range(count)
    ]
    here = float(rng.uniform(2, 14)), float(rng.uniform(2, 10))
    gain = float(rng.normal(0, 2.0))
    signals: dict[str, list[float]] = {"moon": [-40.0]} if seed % 5 == 0 else {}
    for tag in tags:
        far = max(hypot(tag["x_m"] - here[0], tag["y_m"] - here[1]), 0.1)
        mean = (
            radio.power_at_1m_dbm
            - 10 * radio.path_loss_exponent * log10(far)
            + gain
            + float(rng.normal(0, 2))
        )
        signals[tag["tag_id"]] = [
            round(mean + float(e), 1) for e in rng.normal(0, 1, int(rng.integers(1, 8)))
        ]
    if seed % 8 == 7:
        signals[tags[-1]["tag_id"]] = [-20.0, -50.0, -80.0]
    since = None
    if seed % 2:
        since = {"x_m": round(here[0], 1), "y_m": round(here[1], 1), "sd_m": 0.6, "at_most_m": 4.0}
    rows = ["1" * 32] * 24
    rows = [row if k % 9 else row[:7] + "2" * 15 + row[22:] for k, row in enumerate(rows)]
    plan = {"rows": rows, "origin_m": [0.0, 0.0], "resolution_m": 0.5} if seed % 4 else None
    ears = Ears(radio)
    case = {"radio": radio_value(ears), "tags": tags, "signals": signals, "since": since, "plan": plan}
    return case | {"expected": expected(case, ears)}


def expected(case: dict[str, Any], ears: Ears) -> dict[str, Any]:
    """Return what Python makes of a case."""
    nodes = {
        t["tag_id"]: NodePlace(t["tag_id"], t["x_m"], t["y_m"], t["sd_m"] / sqrt(2)) for t in case["tags"]
    }
    heard = [ears.by_signal(nodes[name], rssis) for name, rssis in case["signals"].items() if name in nodes]
    used = [each for each in heard if each is not None]
    if not used:
        return {}
    plan = None
    if case["plan"]:
        classes = np.array([[int(cell) for cell in row] for row in case["plan"]["rows"]], np.uint8)
        plan = Plan(classes, (0.0, 0.0), case["plan"]["resolution_m"])
    found = locate(used, ears.shared, Since(**case["since"]) if case["since"] else None, plan)
    unknown = sorted(case["signals"].keys() - nodes.keys())
    tags = {name: (node.x_m, node.y_m) for name, node in nodes.items()}
    return {**_value(found), "text": fix_text(found, tags, unknown)}


def _value(found: Located) -> dict[str, Any]:
    names = ("x_m", "y_m", "var_x", "var_xy", "var_y", "share")
    ring = found.ring
    return {
        "places": [
            {name: round(getattr(place, name), 9) for name in names} | {"is_hollow": place.is_hollow}
            for place in found.places
        ],
        "ring": ring
        and {"node_id": ring.node_id, "range_m": round(ring.range_m, 9), "sd_m": round(ring.sd_m, 9)},
        "left_out": found.left_out,
        "fits": found.fits,
    }


if __name__ == "__main__":
    text = ",\n".join(json.dumps(vector, separators=(",", ":")) for vector in vectors())
    FILE.write_text(f"[\n{text}\n]\n", encoding="utf-8")
