"""An agent's state as bytes and back: the crash recovery beside the log.

A snapshot is a pickle that may name nothing but this package's classes, numpy's arrays and generators, and
plain containers, so a damaged or foreign file can fail but not run code. It is good for the very program
that took it: what an object holds changes with its class, and the log is always there. The same state has
the same bytes, so it holds no sets: how one is ordered depends on the process.
"""

from __future__ import annotations

import io
import pickle
import zlib
from functools import cache
from hashlib import blake2b
from pathlib import Path
from typing import Any, TypeVar

T = TypeVar("T")

_BUILTINS = ("list", "dict", "tuple", "bytearray", "complex", "slice", "range", "object")
_PLAIN = {("builtins", name) for name in _BUILTINS} | {
    ("collections", "deque"),
    ("collections", "OrderedDict"),
    ("copyreg", "_reconstructor"),
    ("numpy", "ndarray"),
    ("numpy", "dtype"),
    ("numpy._core.multiarray", "_reconstruct"),
    ("numpy._core.multiarray", "scalar"),
    ("numpy._core.numeric", "_frombuffer"),
    ("numpy.random._pickle", "__generator_ctor"),
    ("numpy.random._pickle", "__bit_generator_ctor"),
    ("numpy.random._pcg64", "PCG64"),
    ("numpy.random.bit_generator", "__pyx_unpickle_SeedSequence"),
    ("numpy.random.bit_generator", "SeedSequence"),
}


class SnapshotError(ValueError):
    """The bytes are damaged, of another version, or name something a snapshot may not hold."""


class _Unpickler(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> Any:
        known = module.startswith("robots.") and "." not in name
        if not known and (module, name) not in _PLAIN:
            raise SnapshotError(f"a snapshot may not hold {module}.{name}")
        found = super().find_class(module, name)
        # a class that a module merely imported is not one of ours
        if known and not (isinstance(found, type) and found.__module__ == module):
            raise SnapshotError(f"a snapshot may not call {module}.{name}")
        return found


@cache
def header() -> bytes:
    """Return what snapshots of this program begin with: a digest of the package's sources."""
    digest = blake2b(digest_size=8)
    package = Path(__file__).parent
    for source in sorted(package.rglob("*.py")):
        digest.update(str(source.relative_to(package)).encode() + source.read_bytes())
    return b"waymark-" + digest.digest()


def freeze(state: object) -> bytes:
    """Return the state as bytes with a checksum."""
    body = zlib.compress(pickle.dumps(state, protocol=5), 1)
    return header() + zlib.crc32(body).to_bytes(4, "big") + body


def thaw(data: bytes, expected: type[T]) -> T:
    """Return the state that ``freeze`` was given.

    Raises:
        SnapshotError: as its docstring says.
    """
    begins = len(header())
    if data[:begins] != header():
        raise SnapshotError("not a snapshot of this version; replay the log instead")
    body = data[begins + 4 :]
    if zlib.crc32(body) != int.from_bytes(data[begins : begins + 4], "big"):
        raise SnapshotError("the snapshot is damaged; replay the log instead")
    try:
        state = _Unpickler(io.BytesIO(zlib.decompress(body))).load()
    except SnapshotError:
        raise
    except Exception as error:
        raise SnapshotError(f"the snapshot cannot be read ({error}); replay the log instead") from error
    if not isinstance(state, expected):
        raise SnapshotError(f"a snapshot of {type(state).__name__}, expected {expected.__name__}")
    return state
