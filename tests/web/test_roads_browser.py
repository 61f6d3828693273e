"""The phone's routes and words in a real browser: on any mission the same as the server's, to the letter."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from fastapi import FastAPI
from playwright.sync_api import Browser, Page

from robots.routes.texts import Language, say
from robots.routes.words import is_last_uncertain, is_uncertain, leg_text
from robots.team import TeamGrid
from server.board import Board
from server.errors import ApiError
from server.mission.pocket import base_out, pack_of
from server.mission.routes import Routes
from server.mission.whereabouts import whereabouts
from web.mount import mount_web

CASES = 30
KINDS = {"", "corridor", "room", "open_area"}  # that chance draws
ASK = """async (cases) => {
  const { Roads } = await import("/static/phone/roads.js");
  const { routeTo, whereIs } = await import("/static/phone/where.js");
  return cases.map(({ pocket, routes, tags }) => {
    const roads = new Roads(pocket);
    return {
      routes: routes.map(([from, to]) => routeTo(pocket, roads, from, to)),
      where: tags.map((tag) => whereIs(pocket, roads, tag)),
    };
  });
}"""


@pytest.fixture
def page(browser: Browser, serve: Any, language: Language) -> Iterator[Page]:
    app = FastAPI()
    mount_web(app)
    context = browser.new_context(locale=language)
    page = context.new_page()
    page.goto(f"http://{serve(app)}/static/logo.svg")  # any page of the server's
    yield page
    context.close()


def board_of(rng: np.random.Generator) -> tuple[Board, TeamGrid | None]:
    """A mission drawn by chance: tags on a lattice (so that many ways cost the same), trails over them."""
    side = int(rng.integers(2, 7))
    board = Board()
    names = [f"T{k}" for k in range(side * side)]
    places = {name: (2.5 * (k // side), 2.5 * (k % side)) for k, name in enumerate(names)}
    for name, (x, y) in places.items():
        moved = 0.0 if rng.random() < 0.5 else float(rng.normal(0, 0.3))
        places[name] = x + moved, y
        variance = float(rng.choice([0.01, 0.2, 2.0]))
        state, notice = ("sound", "") if rng.random() < 0.9 else ("doubtful", "Read at two places.")
        value = {"tag_id": name, "x_m": x + moved, "y_m": y, "covariance": [variance, 0.0, variance]}
        board.publish({f"tag/{name}": value | {"state": state, "notice": notice}})
    for robot in range(int(rng.integers(0, 4))):
        at = int(rng.integers(len(names)))
        stops = [(places[names[at]][0] + float(rng.choice([0.3, 1.2])), places[names[at]][1])]
        for _ in range(3 * side):
            stops.append(places[names[at]])
            step = int(rng.choice([1, -1, side, -side]))
            at = at + step if 0 <= at + step < len(names) else at
        line = [np.linspace(a, b, 20) for a, b in itertools.pairwise(stops)]
        bent = np.vstack(line) + np.where(rng.random() < 0.5, 0.0, rng.normal(0, 0.25, (1, 2)))
        board.publish({f"robot/r{robot}": {"robot_id": f"r{robot}"}})
        board.publish({f"trail/r{robot}": {"robot_id": f"r{robot}", "points_m": bent.round(2).tolist()}})

    def where() -> list[float]:
        return rng.uniform(-4, 2.5 * side + 4, 2).round(4).tolist()

    for k in range(int(rng.integers(0, 6))):
        x, y = where()
        status = str(rng.choice(["suspected", "confirmed", "dismissed"], p=[0.4, 0.4, 0.2]))
        said = {
            "status": status,
            "merged_into": None,
            "live": 1,
            "dead": 0,
            "triage": "minor",
            "note": "",
            "by": "",
        }
        variance = float(rng.choice([0.1, 0.4, 18.0]))
        value = {"victim_id": f"v{k}", "x_m": x, "y_m": y, "covariance": [variance, 0.0, variance]}
        value["confidence"] = 0.9
        board.publish({f"victim/v{k}": value | said})
    for k in range(int(rng.integers(0, 4))):
        x, y = where()
        kind = str(rng.choice(["hazard", "note", "exit"]))
        side = float(rng.choice([3.0, 20.0]))  # with sides far longer than a hazard reaches
        area = [[x, y], [x + side, y], [x, y + side]] if rng.random() < 0.4 else []
        at_tag = not area and rng.random() < 0.5
        value = {"annotation_id": f"n{k}", "kind": kind, "text": "" if rng.random() < 0.3 else f"hole {k}"}
        value |= {"x_m": None if area or at_tag else x, "y_m": None if area or at_tag else y, "area_m": area}
        value |= {
            "tag_id": str(rng.choice(names)) if at_tag else None,
            "by": "ann",
            "changed_unix_s": float(k),
        }
        board.publish({f"annotation/n{k}": value})
    for _ in range(int(rng.integers(0, 5))):
        one, other = (str(name) for name in rng.choice(names, 2))
        walk = {"from_tag": one, "to_tag": other, "after_s": float(rng.choice([0.0, 0.1, 60.0]))}
        walk["steps_m"] = None if rng.random() < 0.5 else float(rng.uniform(0.0, 12.0))
        if one != other:
            board.publish({f"walk/{one}~{other}": walk})
    if rng.random() < 0.5:
        return board, None
    cells = np.where(rng.random((200, 200)) < rng.choice([0.01, 0.05]), 100, 0).astype(np.int8)
    if rng.random() < 0.4:  # walls between the tags: corridors, and with the second ones rooms
        cells[(6.0 + 12.5 * np.arange(15)).astype(int)] = 100
        cells[:, 6 :: 25 if rng.random() < 0.5 else 200] = 100
    return board, TeamGrid(cells, (-5.0, -5.0), 0.2, 1)


def case_of(seed: int, language: Language) -> tuple[dict[str, Any], dict[str, Any]]:
    rng = np.random.default_rng(seed)
    board, grid = board_of(rng)
    kinds = {kind: board.of_kind(kind) for kind in ("tag", "trail", "victim", "annotation", "walk")}
    if seed % 2:
        board.publish({"georeference": {"yaw_rad": float(rng.uniform(-4.0, 4.0))}})
    routes = Routes(board)
    head = {
        "mission_id": "m",
        "mission_name": "M",
        "state": "running",
        "created_unix_s": 0.0,
        "evacuation": None,
        "x_axis_deg": routes.north.x_axis_deg,
    }
    head["base"] = base_out(routes, routes.roads(grid), grid)
    pocket = json.loads(pack_of(head, kinds, routes.roads(grid), None, grid, routes.place_kind).plain())
    names = [value["tag_id"] for value in kinds["tag"]]
    goals = [f"tag:{name}" for name in names] + [f"victim:{v['victim_id']}" for v in kinds["victim"]]
    goals += [f"note:{note['annotation_id']}" for note in kinds["annotation"]]
    goals += [f"exit:{note['annotation_id']}" for note in kinds["annotation"]]
    asked = [(str(rng.choice(names)), str(rng.choice(goals))) for _ in range(40)]
    asked += [(name, to) for name in names[:5] for to in ("exit", "base")]
    tags = [str(name) for name in rng.choice(names, 5)]
    expected = {
        "routes": [route_of(routes, grid, *each, language) for each in asked],
        "where": [whereabouts(board, routes, grid, tag, language) for tag in tags],
    }
    return {"pocket": pocket, "routes": asked, "tags": tags}, expected


def route_of(
    routes: Routes, grid: TeamGrid | None, from_tag: str, to: str, language: Language
) -> dict[str, Any] | None:
    try:
        found = routes.find(grid, from_tag, to, language)
    except ApiError:
        return None
    legs = [
        {
            "tags": [leg.way.from_tag, leg.way.to_tag],
            "text": leg_text(leg, language, routes.north),
            "bearing": routes.north.bearing_deg(*leg.way.points_m[:2]),
            "uncertain": is_uncertain(leg),
            "hazards": list(leg.hazards),
            "points": leg.way.points_m.tolist(),
        }
        for leg in found.legs
    ]
    unsure = is_last_uncertain(found.last_sd_m) if found.last else None
    last = found.last_text or None
    return {"legs": legs, "last": last, "last_uncertain": unsure, "distance_m": found.distance_m}


@pytest.mark.parametrize("language", ["en", "de"])
def test_a_phone_finds_the_servers_routes_and_words(page: Page, language: Language) -> None:
    cases = [case_of(seed, language) for seed in range(CASES)]
    answers = page.evaluate(ASK, [asked for asked, _ in cases])
    found = sum(route is not None for _, expected in cases for route in expected["routes"])
    told = [route for _, expected in cases for route in expected["routes"] if route]
    texts = [leg["text"] for route in told for leg in route["legs"]]
    texts += [route["last"] for route in told if route["last"]]
    assert found > 200
    assert len(texts) > 500
    for key in ("walked", "last_leg_unsure", "goal_exit", "goal_base"):
        blanks = dict.fromkeys(("tag", "far", "way", "goal", "doubt", "name"), "")
        word = say(language, key, **blanks).strip().split(":")[0][-9:]
        assert any(word in text for text in texts), word
    unnamed = say(language, "take_care", hazard=say(language, "a_hazard"))
    assert any(text.endswith(unnamed) for text in texts)
    assert {where["place_kind"] for _, expected in cases for where in expected["where"]} == KINDS
    for (_, expected), answer in zip(cases, answers, strict=True):
        for theirs, ours in zip(expected["routes"], answer["routes"], strict=True):
            assert (ours is None) == (theirs is None)
            if theirs is None:
                continue
            assert [
                {
                    "tags": [leg["from_tag"], leg["to_tag"]],
                    "text": leg["text"],
                    "bearing": pytest.approx(leg["bearing_deg"], abs=1e-9),
                    "uncertain": leg["uncertain"],
                    "hazards": leg["hazards"],
                    "points": leg["points_m"],
                }
                for leg in ours["legs"]
            ] == theirs["legs"]
            assert (ours["last"] and ours["last"]["text"]) == theirs["last"]
            assert (ours["last"] and ours["last"]["uncertain"]) == theirs["last_uncertain"]
            assert ours["distance_m"] == pytest.approx(theirs["distance_m"])
        for theirs, ours in zip(expected["where"], answer["where"], strict=True):
            assert ours["text"] == theirs["text"]
            assert ours["sd_m"] == pytest.approx(theirs["sd_m"], abs=1e-3)
            assert [(v["victim_id"], v["reachable"]) for v in ours["victims"]] == [
                (v["victim_id"], v["reachable"]) for v in theirs["victims"]
            ]
