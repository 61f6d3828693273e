"""Writing HTML in which nothing that comes from outside can be anything but text."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from datetime import datetime
from html import escape


class Html(str):
    """Text that is HTML already."""


def text(value: object) -> Html:
    """Return a value as HTML: escaped, unless it was made by this module; nothing for None."""
    if isinstance(value, Html):
        return value
    return Html("" if value is None else escape(str(value), quote=True))


def join(parts: Iterable[object], between: str = "") -> Html:
    """Return parts one after the other."""
    return Html(between.join(text(part) for part in parts))


def tag(name: str, *parts: object, **attributes: object) -> Html:
    """Return an element; a trailing underscore of an attribute is left out, others become dashes."""
    words = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{text(value)}"'
        for key, value in attributes.items()
        if value is not None
    )
    return Html(f"<{name}{words}>{join(parts)}</{name}>")


def table(heads: Sequence[str], rows: Iterable[Sequence[object]], **attributes: object) -> Html:
    """Return a table whose head is repeated on every printed page."""
    head = tag("thead", tag("tr", *(tag("th", each, scope="col") for each in heads)))
    body = tag("tbody", *(tag("tr", *(tag("td", cell) for cell in row)) for row in rows))
    return tag("table", head, body, **attributes)


def facts(pairs: Iterable[tuple[str, object]]) -> Html:
    """Return a list of names and values; pairs without a value are left out."""
    return tag(
        "dl",
        *(tag("div", tag("dt", name), tag("dd", value)) for name, value in pairs if value not in (None, "")),
    )


def clock(unix_s: float | None) -> str:
    """Return the time of day where the server is; empty for None."""
    return "" if unix_s is None else datetime.fromtimestamp(unix_s).astimezone().strftime("%H:%M:%S")


def day_and_time(unix_s: float) -> str:
    """Return day, time and the difference from UTC."""
    moment = datetime.fromtimestamp(unix_s).astimezone()
    return moment.strftime("%Y-%m-%d %H:%M:%S UTC%z")


def duration(seconds: float | None) -> str:
    """Return a duration in words; empty for None."""
    if seconds is None:
        return ""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    minutes, rest = divmod(whole, 60)
    return f"{minutes} min {rest:02d} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02d} min"
