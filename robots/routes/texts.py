"""What is said of places and ways, in all languages; the phone's tables say the same, word by word."""

from __future__ import annotations

from typing import Literal

Language = Literal["en", "de"]

TEXTS: dict[Language, dict[str, str]] = {
    "en": {
        "north": "north", "north_east": "north-east", "east": "east", "south_east": "south-east",
        "south": "south", "south_west": "south-west", "west": "west", "north_west": "north-west",
        "of_plan": "plan {way}",
        "metres": "{n} m",
        "about": "about {far}",
        "go": "go {far} {way}",
        "turn_left": "turn left and go {far}",
        "turn_right": "turn right and go {far}",
        "turn_round": "turn round and go {far}",
        "leg": "{pieces} to tag {tag}.",
        "narrow": "Narrow: about {width} cm.",
        "take_care": "Take care: {hazard}.",
        "a_hazard": "hazard",
        "walked": "Somebody walked it; just where is not known.",
        "last_leg": "From tag {tag} go {far} {way}: there is {goal}.",
        "last_leg_unsure": "From tag {tag} go about {far} {way} and search there:"
        " {goal} is within about {doubt}.",
        "goal_victim": "victim {name}", "goal_tag": "tag {name}", "goal_note": "note {name}",
        "goal_exit": "the exit {name}", "goal_base": "the base",
        "tag": "Tag {tag}",
        "tag_moved": "This tag was moved, and the map has it where it was read last. Go by another tag too.",
        "tag_cloned": "There is more than one tag of this name. Do not go by this place, touch another tag.",
        "tag_doubtful": "It is not sure where this tag lies. Go by another tag too.",
        "place_unsure": "Its place is known to {far} only.",
        "you_are_at": "You are at tag {tag}.",
        "you_are_in": "You are at tag {tag}, {place}.",
        "in_doorway": "in a doorway", "in_corridor": "in a corridor", "in_room": "in a room",
        "in_open_area": "in an open area",
        "next_to_it": "{far} {way} is tag {tag}",
        "victims_near.one": "{count} victim within {far}.",
        "victims_near.other": "{count} victims within {far}.",
        "nearest_victim": "The nearest victim is {far} away.",
        "no_victim": "No victim is known.",
        "count_0": "No", "count_1": "One", "count_2": "Two", "count_3": "Three", "count_4": "Four",
        "count_5": "Five", "count_6": "Six", "count_7": "Seven", "count_8": "Eight", "count_9": "Nine",
        "fix_near": "You are about {far} {way} of tag {tag}, give or take {doubt}.",
        "fix_at": "You are at tag {tag}, give or take {doubt}.",
        "fix_or_near": "Or about {far} {way} of tag {tag}, give or take {doubt}.",
        "fix_or_at": "Or at tag {tag}, give or take {doubt}.",
        "fix_walk": "More than one place fits what is heard: walk a few steps, and it shows which.",
        "fix_ring": "You are about {far} from node {tag}, in any direction, give or take {doubt}."
        " One more node would tell where.",
        "fix_misfit": "What is heard does not agree, so trust this less.",
        "fix_left_out": "Node {tag} contradicts all others and was left out: it may have been moved.",
        "fix_unknown": "Node {tag} is not on the map.",
    },
    "de": {
        "north": "Norden", "north_east": "Nordosten", "east": "Osten", "south_east": "Südosten",
        "south": "Süden", "south_west": "Südwesten", "west": "Westen", "north_west": "Nordwesten",
        "of_plan": "Plan-{way}",
        "metres": "{n} m",
        "about": "etwa {far}",
        "go": "{far} nach {way} gehen",
        "turn_left": "dann links {far}",
        "turn_right": "dann rechts {far}",
        "turn_round": "dann umdrehen und {far} zurück",
        "leg": "{pieces} bis Marke {tag}.",
        "narrow": "Eng: etwa {width} cm.",
        "take_care": "Vorsicht: {hazard}.",
        "a_hazard": "Gefahr",
        "walked": "Da ist jemand gegangen; wo genau, ist nicht bekannt.",
        "last_leg": "Von Marke {tag} {far} nach {way} gehen: Dort ist {goal}.",
        "last_leg_unsure": "Von Marke {tag} etwa {far} nach {way} gehen und dort suchen:"
        " {goal} ist im Umkreis von etwa {doubt}.",
        "goal_victim": "Opfer {name}", "goal_tag": "Marke {name}", "goal_note": "Notiz {name}",
        "goal_exit": "Ausgang {name}", "goal_base": "Basis",
        "tag": "Marke {tag}",
        "tag_moved": "Diese Marke wurde versetzt; der Plan zeigt sie, wo sie zuletzt gelesen wurde."
        " Richten Sie sich auch nach einer anderen.",
        "tag_cloned": "Marken dieses Namens gibt es mehrere. Verlassen Sie sich nicht auf diesen Ort,"
        " lesen Sie eine andere.",
        "tag_doubtful": "Es ist nicht sicher, wo diese Marke liegt."
        " Richten Sie sich auch nach einer anderen.",
        "place_unsure": "Ihr Ort ist nur auf {far} genau bekannt.",
        "you_are_at": "Sie sind an Marke {tag}.",
        "you_are_in": "Sie sind an Marke {tag}, {place}.",
        "in_doorway": "in einer Türöffnung", "in_corridor": "in einem Flur", "in_room": "in einem Raum",
        "in_open_area": "in einem offenen Bereich",
        "next_to_it": "{far} nach {way} ist Marke {tag}",
        "victims_near.one": "{count} Opfer innerhalb von {far}.",
        "victims_near.other": "{count} Opfer innerhalb von {far}.",
        "nearest_victim": "Das nächste Opfer ist {far} entfernt.",
        "no_victim": "Es ist kein Opfer bekannt.",
        "count_0": "Kein", "count_1": "Ein", "count_2": "Zwei", "count_3": "Drei", "count_4": "Vier",
        "count_5": "Fünf", "count_6": "Sechs", "count_7": "Sieben", "count_8": "Acht", "count_9": "Neun",
        "fix_near": "Sie sind etwa {far} nach {way} von Marke {tag}, auf {doubt} genau.",
        "fix_at": "Sie sind an Marke {tag}, auf {doubt} genau.",
        "fix_or_near": "Oder etwa {far} nach {way} von Marke {tag}, auf {doubt} genau.",
        "fix_or_at": "Oder an Marke {tag}, auf {doubt} genau.",
        "fix_walk": "Zu dem, was zu hören ist, passt mehr als ein Ort: Nach einigen Schritten zeigt sich,"
        " welcher.",
        "fix_ring": "Sie sind etwa {far} von Knoten {tag} entfernt, Richtung unbekannt, auf {doubt} genau."
        " Ein weiterer Knoten würde zeigen, wo.",
        "fix_misfit": "Was zu hören ist, passt nicht zusammen: Trauen Sie dem weniger.",
        "fix_left_out": "Knoten {tag} widerspricht allen anderen und zählt nicht mit:"
        " Er wurde vielleicht bewegt.",
        "fix_unknown": "Knoten {tag} ist nicht auf der Karte.",
    },
}  # fmt: skip


def say(language: Language, key: str, **values: object) -> str:
    """Return a text in a language, its {names} filled in. Raises KeyError where there is no such text."""
    return TEXTS[language][key].format(**values)
