"""Passwords and random secrets: made, hashed, compared."""

from __future__ import annotations

import base64
import hashlib
import hmac
import secrets

_COST, _BLOCK, _LANES = 2**14, 8, 1  # scrypt: 16 MB and some 50 ms a try
_SALT_BYTES = 16


def new_secret() -> str:
    """Return a secret that nobody guesses (256 bits), fit for an address or a header."""
    return secrets.token_urlsafe(32)


def digest(secret: str) -> str:
    """Return what is kept of a random secret: whoever reads the database cannot log in with it."""
    return hashlib.sha256(secret.encode()).hexdigest()


def hash_password(password: str) -> str:
    """Return what is kept of a password: slow to guess, with a salt of its own."""
    salt = secrets.token_bytes(_SALT_BYTES)
    return f"scrypt${_COST}${_text(salt)}${_text(_scrypt(password, salt, _COST))}"


def is_password(password: str, kept: str) -> bool:
    """Say whether it is the password of which ``kept`` was made."""
    _, cost, salt, expected = kept.split("$")
    found = _scrypt(password, base64.b64decode(salt), int(cost))
    return hmac.compare_digest(found, base64.b64decode(expected))


def _scrypt(password: str, salt: bytes, cost: int) -> bytes:
    limit = 256 * cost * _BLOCK
    return hashlib.scrypt(password.encode(), salt=salt, n=cost, r=_BLOCK, p=_LANES, maxmem=limit, dklen=32)


def _text(data: bytes) -> str:
    return base64.b64encode(data).decode()
