"""What goes wrong with a database, in one sentence that says which file and what to do."""

from __future__ import annotations


class DatabaseError(Exception):
    """The database cannot be used as asked; the message names the file and the way out."""


_CAUSES = (
    (
        ("not a database", "file is encrypted"),
        "{where} is not a Waymark database; choose another file with WAYMARK_DATABASE.",
    ),
    (
        ("malformed", "corrupt"),
        "{where} is damaged; restore it from a backup, or choose another file with WAYMARK_DATABASE.",
    ),
    (
        ("readonly", "read-only", "attempt to write"),
        "{where} cannot be written; make the file and its folder writable for this user.",
    ),
    (
        ("locked", "busy"),
        "{where} is locked by another program; close that program and try again.",
    ),
    (
        ("unable to open", "permission denied", "is a directory"),
        "{where} cannot be opened; check that its folder exists and belongs to this user.",
    ),
    (
        ("disk is full", "no space left", "disk i/o error"),
        "{where} cannot grow or be read, the disk is full or failing; free space or move the file.",
    ),
)


def explain(error: BaseException, where: str) -> DatabaseError:
    """Return the one sentence for an error of the database driver; ``where`` is the file or the URL."""
    if isinstance(error, DatabaseError):
        return error
    said = str(getattr(error, "orig", None) or error)
    for signs, sentence in _CAUSES:
        if any(sign in said.lower() for sign in signs):
            return DatabaseError(sentence.format(where=where))
    return DatabaseError(f"{where} failed: {said}.")
