"""Victims and sectors in every state that they can be in, as the board has them."""

from typing import Any, get_args

from hypothesis import strategies as st

from db.victim_records import VictimStatus
from db.worksites import Entry, Found, Risk, WorksiteTriage

WORD = st.text("ABCDEFGHIJKLMNOPQRSTUVWXYZ 0123456789-.", max_size=30).map(str.strip)
COUNT = st.none() | st.sampled_from([0, 1, 2, 12, 10_000])
BEFORE = st.lists(st.sampled_from([1, 2, 12, 10_000]), max_size=4)
PLACE = st.sampled_from([-5.0, 2.5, 7.5])
NIGHT_UNIX_S = 1_790_000_000


@st.composite
def victims(draw: Any) -> dict[str, Any]:
    """Return a victim as far as markings ask; what was counted before is nothing where a count is unknown."""
    live, dead = draw(COUNT), draw(COUNT)
    return {
        "status": draw(st.sampled_from(get_args(VictimStatus))),
        "live": live,
        "dead": dead,
        "live_before": [] if live is None else draw(BEFORE),
        "dead_before": [] if dead is None else draw(BEFORE),
        "merged_into": draw(st.sampled_from([None, None, None, "V2"])),
        "x_m": draw(PLACE),
        "y_m": draw(PLACE),
    }


@st.composite
def visits(draw: Any) -> dict[str, Any]:
    """Return a team that is or was inside."""
    entered = draw(st.integers(NIGHT_UNIX_S, NIGHT_UNIX_S + 40_000_000))
    left = draw(st.none() | st.integers(0, 100_000).map(lambda s: entered + s))
    return {
        "team": draw(st.sampled_from(["AUS01", "AUS-01", "Feuerwehr Mitte", "X" * 20])),
        "level": draw(st.none() | st.integers(1, 5)),
        "entered_unix_s": entered,
        "left_unix_s": left,
        "is_finished": left is not None and draw(st.booleans()),
        "parts": draw(st.sampled_from(["", "Ground Floor A to D", "Floor 1 and Basement 1, all quadrants"])),
    }


WHEN = st.integers(NIGHT_UNIX_S, NIGHT_UNIX_S + 40_000_000)
TEAM = st.sampled_from(["AUS01", "AUS-01", "TX-TF1", "X" * 20])
RATINGS = st.builds(
    dict,
    team=TEAM,
    risk=st.sampled_from(get_args(Risk)),
    entry=st.sampled_from([None, *get_args(Entry)]),
    rated_unix_s=WHEN,
)
CLEARANCES = st.builds(dict, team=TEAM, found=st.sampled_from(get_args(Found)), cleared_unix_s=WHEN)


@st.composite
def sectors(draw: Any) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Return a sector with the victims of its mission."""
    worksite = None
    if draw(st.integers(0, 9)):
        came = draw(st.lists(visits(), max_size=3))
        worksite = {
            "worksite_id": draw(st.sampled_from(["C-5", "C-12b", "Z-9999z", "AUS01-0102"])),
            "hazards": draw(WORD),
            "triage": draw(st.sampled_from([None, *get_args(WorksiteTriage)])),
            "is_complete": draw(st.booleans()) and all(each["left_unix_s"] is not None for each in came),
            "visits": came,
            **draw(st.sampled_from([{}, {"ratings": [], "clearances": []}])),
        }
        if draw(st.booleans()):
            worksite["ratings"] = draw(st.lists(RATINGS, min_size=1, max_size=2))
            worksite["clearances"] = draw(st.lists(CLEARANCES, max_size=2))
    area = [[0.0, 0.0], [5.0, 0.0], [5.0, 5.0], [0.0, 5.0]]
    return {"area_m": area, "worksite": worksite}, draw(st.lists(victims(), max_size=3))
