"""What an operator has told a robot to do, and what became of it."""

from __future__ import annotations

from dataclasses import replace
from math import hypot, isfinite

from robots.exploration.aim import Aim
from robots.exploration.area import holds
from robots.exploration.frontiers import Frontier
from robots.exploration.ground import Ground
from robots.exploration.methods import hears_nobody, unknown_method
from robots.orders import PLACED, Methods, OrderReport, OrderState, RobotOrder
from robots.planning.plan_grid import UNKNOWN

HERE_M = 8.0  # round the place of "explore here"
RIM_M = 1.0  # round its area: walls stand there, and people draw roughly
_THERE_M = 0.4  # as good as at the place
_BESIDE_M = 1.0  # where the place itself cannot be driven on
_PATIENCE_S = 30.0  # a place that cannot be reached for so long has failed


class Errands:
    """At most one standing order; a later one takes its place. ``methods`` are those in force."""

    def __init__(self, methods: Methods) -> None:
        self.methods = methods
        self.changed = Methods()  # to be taken up by whoever explores
        self.standing: RobotOrder | None = None
        self.tag_wanted = False
        self._arrived = self._settled = False
        self._shut_since_s: float | None = None
        self._tag_order: RobotOrder | None = None
        self._reports: list[OrderReport] = []

    @property
    def holds(self) -> bool:
        """Whether it is told to stand still."""
        return self.standing is not None and self.standing.kind == "hold"

    @property
    def returns(self) -> bool:
        """Whether it is told to go back."""
        return self.standing is not None and self.standing.kind == "return"

    @property
    def by(self) -> str:
        """Who gave the standing order, in words."""
        by = "" if self.standing is None else self.standing.by
        return f"ordered by {by}" if by else "as ordered"

    def take_reports(self) -> tuple[OrderReport, ...]:
        """Return what became of orders since this was last asked."""
        reports, self._reports = tuple(self._reports), []
        return reports

    def take(self, order: RobotOrder, tags_left: int) -> None:
        """Take an order; what cannot be done is reported as failed and changes nothing."""
        if order.kind == "methods":
            self._change_methods(order)
        elif order.kind == "drop_tag":
            self._want_tag(order, tags_left)
        elif order.kind in PLACED and (order.place_m is None or not all(map(isfinite, order.place_m))):
            self._report(order, "failed", "it names no place on the map")
        else:
            if self.standing is not None:
                self._settle("failed", f"given up for a later order: {order.kind.replace('_', ' ')}")
            self.standing, self._shut_since_s = order, None
            self._arrived = self._settled = False
            if order.kind == "hold":
                self._settle("done", "standing still")
            elif order.kind == "resume":
                self._settle("done", "exploring")
                self.standing = None

    def tag_dropped(self) -> None:
        """Note that the tag that was ordered has been dropped."""
        if self._tag_order is not None:
            self._report(self._tag_order, "done", "dropped a tag")
        self._tag_order, self.tag_wanted = None, False

    def tag_stuck(self) -> None:
        """Note that the magazine let no tag fall."""
        if self._tag_order is not None:
            self._report(self._tag_order, "failed", "no tag fell out of the magazine: look at its slider")
        self._tag_order, self.tag_wanted = None, False

    def overruled(self, why: str) -> None:
        """Give up going to a place: the robot has to go back."""
        if self.standing is not None and self.standing.kind in PLACED:
            self._settle("failed", f"going back instead: {why}")
            self.standing = None

    def home(self, text: str) -> None:
        """Note that the robot is back, as it was told."""
        if self.returns:
            self._settle("done", text)

    def aim(self, now_s: float, ground: Ground, edges: tuple[Frontier, ...]) -> Aim | None:
        """Return the way to the place it was told to go to; None where it is free to explore."""
        order = self.standing
        if order is None or order.kind not in PLACED or order.place_m is None:
            return None
        if order.area_m and holds(order.area_m, ground.pose.x, ground.pose.y):
            self._arrived = True
        if order.kind == "explore_here" and self._arrived:
            return None
        x, y = order.place_m
        if ground.distance_m(x, y) < _THERE_M:
            return self._rest(order, "at the place")
        cell = ground.nearest(x, y, _BESIDE_M)
        if cell is not None and ground.distance_m(*ground.grid.centre_of(*cell)) < _THERE_M:
            return self._rest(order, "beside the place, which cannot be driven on")
        path = None if cell is None else ground.path_to(cell)
        if cell is not None and path is not None:
            self._shut_since_s = None
            reason = f"driving {ground.cost_m(cell):.0f} m to the place {self._told(order)}"
            return Aim("place", "exploring", reason, order.place_m, path)
        return self._towards(now_s, order, ground, edges)

    def near(self, edges: tuple[Frontier, ...]) -> tuple[Frontier, ...]:
        """Return the edges near the place it was told to explore, all of them where it was told of none.

        The order is done when none is left near it.
        """
        order = self.standing
        if order is None or order.kind != "explore_here" or order.place_m is None or not self._arrived:
            return edges
        x, y = order.place_m
        if order.area_m:
            near = tuple(f for f in edges if holds(order.area_m, *f.goal_m, RIM_M))
        else:
            near = tuple(f for f in edges if hypot(f.goal_m[0] - x, f.goal_m[1] - y) < HERE_M)
        if near:
            return near
        where = "in the area" if order.area_m else "near the place"
        self._settle("done", f"no edge of the unknown is left {where}")
        self.standing = None
        return edges

    def _towards(
        self, now_s: float, order: RobotOrder, ground: Ground, edges: tuple[Frontier, ...]
    ) -> Aim | None:
        """Head for the edge of the unknown that leads there; give up where none has for long enough."""
        assert order.place_m is not None
        x, y = order.place_m
        grid = ground.grid
        at = grid.cell_of(x, y)
        unknown = not grid.holds(*at) or grid.cells[at] == UNKNOWN
        if unknown and edges:
            best = min(edges, key=lambda f: f.cost_m + hypot(f.goal_m[0] - x, f.goal_m[1] - y))
            path = ground.path_to(best.goal)
            if path is not None:
                self._shut_since_s = None
                reason = f"driving {best.cost_m:.0f} m towards the place {self._told(order)}: not seen yet"
                return Aim("edge", "exploring", reason, best.goal_m, path)
        if self._shut_since_s is None:
            self._shut_since_s = now_s
        if now_s - self._shut_since_s > _PATIENCE_S:
            self._settle("failed", "there is no way to the place")
            self.standing = None
            return None
        return Aim("rest", "holding", "waiting for the way to open to the place I am told to go to")

    def _rest(self, order: RobotOrder, where: str) -> Aim | None:
        if order.kind == "explore_here":
            self._arrived = True
            return None
        self._settle("done", f"{where}; it waits there")
        return Aim("rest", "holding", f"waiting {where}, {self.by}")

    def _told(self, order: RobotOrder) -> str:
        return f"I am told to explore, {self.by}" if order.kind == "explore_here" else self.by

    def _change_methods(self, order: RobotOrder) -> None:
        told, now = order.methods, self.methods
        names = {name: value for name in Methods.__slots__ if (value := getattr(told, name))}
        wrong = [text for name, value in names.items() if (text := unknown_method(name, value))]
        if wrong:
            self._report(order, "failed", wrong[0])
            return
        self.methods = replace(now, **names)
        self.changed = replace(self.changed, **names)
        words = ", ".join(f"{name} by {value}" for name, value in names.items())
        text = words.replace("communication by", "communication:") or "nothing to change"
        deaf = hears_nobody(self.methods.coordinate, self.methods.communication)
        self._report(order, "done", f"{text}; but {deaf}" if deaf else text)

    def _want_tag(self, order: RobotOrder, tags_left: int) -> None:
        if tags_left <= 0:
            self._report(order, "failed", "the magazine is empty")
            return
        self._tag_order, self.tag_wanted = order, True

    def _settle(self, state: OrderState, text: str) -> None:
        if self.standing is not None and not self._settled:
            self._report(self.standing, state, text)
        self._settled = True

    def _report(self, order: RobotOrder, state: OrderState, text: str) -> None:
        self._reports.append(OrderReport(order.order_id, state, text))
