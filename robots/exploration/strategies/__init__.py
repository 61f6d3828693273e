"""One file for each way of choosing where to go; ``STRATEGIES`` names them."""

from robots.exploration.strategies.nearest import Nearest
from robots.exploration.strategy import Strategy

STRATEGIES: dict[str, type[Strategy]] = {"nearest": Nearest}
