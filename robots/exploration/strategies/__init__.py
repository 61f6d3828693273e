"""One file for each way of choosing where to go; ``STRATEGIES`` names them."""

from robots.exploration.strategies.aojrf import Aojrf
from robots.exploration.strategies.information_gain import InformationGain
from robots.exploration.strategies.kleiner import Kleiner
from robots.exploration.strategies.kleiner_printed import KleinerPrinted
from robots.exploration.strategies.mcdm import Mcdm
from robots.exploration.strategies.nearest import Nearest
from robots.exploration.strategies.waymark import Waymark
from robots.exploration.strategies.ziparo import Ziparo
from robots.exploration.strategy import Strategy

STRATEGIES: dict[str, type[Strategy]] = {
    "nearest": Nearest,
    "information-gain": InformationGain,
    "kleiner-printed": KleinerPrinted,
    "kleiner": Kleiner,
    "ziparo": Ziparo,
    "aojrf": Aojrf,
    "mcdm": Mcdm,
    "waymark": Waymark,
}
