"""The team's map: what several robots know together."""

from robots.team.team_map import TeamMap
from robots.team.types import StartPose, TeamGrid, TeamNotice, TeamRobot, TeamTag, TeamUpdate, TeamVictim

__all__ = [
    "StartPose",
    "TeamGrid",
    "TeamMap",
    "TeamNotice",
    "TeamRobot",
    "TeamTag",
    "TeamUpdate",
    "TeamVictim",
]
