"""`waymark tag`: the bytes of a tag's chip, made and read."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from server.cli.console import CommandError, print_json, print_table
from server.cli.options import JsonOption

if TYPE_CHECKING:
    from robots.tags.chip import Chip

tag = typer.Typer(
    name="tag", no_args_is_help=True, help="The bytes of a tag: what robots and people stored in it."
)
_MOST_BYTES = 1 << 16
IdOption = Annotated[str, typer.Option("--id", metavar="ID", help="The tag's id.")]
KeyOption = Annotated[str, typer.Option(metavar="HEX", help="The mission's key, as in tag_memory.key.")]
BitsOption = Annotated[int, typer.Option("--tag-bits", metavar="N", help="The chip's capacity in bits.")]
FileArgument = Annotated[
    Path, typer.Argument(metavar="FILE", help="The chip's user memory: bytes, or hexadecimal digits.")
]


@tag.command()
def encode(
    memory: Annotated[
        Path,
        typer.Argument(
            metavar="MEMORY.json", help="What to store, as `waymark tag decode --json` prints it."
        ),
    ],
    tag_id: IdOption,
    link: Annotated[str, typer.Option(metavar="URL", help="What a phone opens on touch.")],
    out: Annotated[Path, typer.Option(metavar="FILE", help="Write the chip's user memory there.")],
    tag_bits: BitsOption = 2048,
    key: KeyOption = "",
    revision: Annotated[int, typer.Option(min=0, help="Number of this version of the memory.")] = 0,
    json: JsonOption = False,
) -> None:
    """Write the user memory of a chip with a link and a memory; what has no room is let go, as on a robot."""
    import json as json_module

    from robots.tags.chip import ChipError
    from robots.tags.content import encode_memory
    from robots.tags.describe import understand
    from robots.tags.memory import TagMemoryError
    from robots.tags.reader import SimulatedTag, read_tag, write_tag
    from robots.tags.record import seal

    try:
        told = understand(json_module.loads(memory.read_text()).get("memory"))
        chip = SimulatedTag.formatted(_chip(tag_bits), link)
        room = read_tag(chip).room_bytes
        fitted = told.fit(room)
        content = encode_memory(fitted)
        write_tag(chip, seal(content, revision, tag_id, _key(key)))
        out.write_bytes(chip.read())
    except OSError as error:
        raise CommandError(f"{error.filename}: {error.strerror}") from error
    except (AttributeError, UnicodeDecodeError, json_module.JSONDecodeError) as error:
        raise CommandError(f"{memory} has to hold a JSON object with a memory in it") from error
    except (ChipError, TagMemoryError, ValueError) as error:
        raise CommandError(str(error)) from error
    result = {
        "tag_bits": tag_bits,
        "content_bytes": len(content),
        "room_bytes": room,
        "complete": fitted == told,
        "out": str(out),
    }
    _print(f"tag {tag_id}", result, json)


@tag.command()
def decode(
    file: FileArgument,
    tag_id: IdOption,
    key: KeyOption = "",
    json: JsonOption = False,
) -> None:
    """Say what a chip holds, and whether the mission's seal is on it."""
    result = _read(file, tag_id, key)
    if json:
        print_json(result)
        return
    memory = result.pop("memory")
    covered = "".join(memory["window"])
    each_m2 = memory["cell_m"] ** 2
    counts: dict[str, Any] = {
        "cell_m": memory["cell_m"],
        "covered_m2": (len(covered) - covered.count(".")) * each_m2,
        "open_m2": covered.count("o") * each_m2,
    }
    counts |= {kind: len(memory[kind]) for kind in ("victims", "notes", "passes")}
    maps = {each["robot_id"]: f"{len(each['tags'])} tags" for each in memory["maps"]}
    print_table(f"tag {tag_id}", {**result, **counts, "maps": maps or None})


@tag.command()
def show(file: FileArgument, tag_id: IdOption, key: KeyOption = "") -> None:
    """Draw the ground round a tag as its memory has it, north up, a cell a character; then all else."""
    from robots.tags.describe import sentences

    result = _read(file, tag_id, key)
    window = result["memory"]["window"]
    middle = len(window) // 2
    print("\n".join(window[:middle]), end="\n" if middle else "")
    print(window[middle][:middle] + "T" + window[middle][middle + 1 :])
    print("\n".join(window[middle + 1 :]), end="\n" if middle else "")
    seal = "the mission's seal" if result["trusted"] else "no seal of this mission: do not believe it"
    print(
        f"T tag {tag_id}  . unseen  o covered, with an open edge  # covered  "
        f"a cell: {result['memory']['cell_m']:g} m  ({seal})"
    )
    print(*sentences(result["memory"]), sep="\n")


def _read(file: Path, tag_id: str, key: str) -> dict[str, Any]:
    from robots.tags.chip import ChipError, chip_of
    from robots.tags.describe import describe
    from robots.tags.memory import TagMemoryError
    from robots.tags.reader import SimulatedTag, read_tag
    from robots.tags.sealed import open_memory

    data = _bytes_of(file)
    try:
        image = read_tag(SimulatedTag(chip_of(8 * len(data)), data))
        if image.damaged:
            raise TagMemoryError("its record is damaged or half written")
        says = open_memory(b"".join(image.records), tag_id, _key(key))
    except (ChipError, TagMemoryError) as error:
        raise CommandError(f"{file}: {error}") from error
    return {
        "link": image.link,
        "records": len(image.records),
        "revision": says.next_revision - 1 if image.records else None,
        "trusted": says.trusted,
        "memory": describe(says.memory),
    }


def _bytes_of(file: Path) -> bytes:
    try:
        with file.open("rb") as opened:
            data = opened.read(2 * _MOST_BYTES + 1)
    except OSError as error:
        raise CommandError(f"{file}: {error.strerror}") from error
    with suppress(ValueError):  # no digits: the bytes themselves
        data = bytes.fromhex(data.decode("ascii"))
    if len(data) > _MOST_BYTES:
        raise CommandError(f"{file} is larger than any tag ({_MOST_BYTES} bytes)")
    return data


def _key(text: str) -> bytes:
    from robots.config import ConfigError, TagMemoryConfig

    try:
        return TagMemoryConfig(key=text).key_bytes
    except ConfigError as error:
        raise CommandError(f"--key: {error}") from error


def _chip(bits: int) -> Chip:
    from robots.tags.chip import ChipError, chip_of

    try:
        return chip_of(bits)
    except ChipError as error:
        raise CommandError(f"--tag-bits: {error}") from error


def _print(title: str, result: dict[str, Any], json: bool) -> None:
    if json:
        print_json(result)
    else:
        print_table(title, result)
