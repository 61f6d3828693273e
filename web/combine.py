"""Many ES modules as a few scripts: what a page needs first, then what each asks for by ``import()``.

Each module becomes a function with a scope of its own, called at once, in the order in which browsers run
modules. What it exports becomes one object, kept in the page's ``modules$`` under the module's address:
nothing is renamed, and each module is there once.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

# types beside code and where to find sources; comments with lines to themselves are gone already
_ASIDE = re.compile(r"/\*\*[^\n]*?\*/|^//# sourceMappingURL=.*$", re.MULTILINE)
_IMPORT = re.compile(r'^import\b(?:\s*([^"\';(]*?)\s*\bfrom)?\s*"([^"\n]+)";?', re.MULTILINE)
_CLAUSE = re.compile(r"(?:([\w$]+)\s*,?\s*)?(?:\*\s*as\s+([\w$]+)|\{([^{}]*)\})?")
_LATER = re.compile(r'\bimport\("([^"]+)"\)')
_BEGINS = r"(?:^|(?<=[;}]))"  # a line, or behind a statement, as minified libraries have it
_EXPORTS = re.compile(_BEGINS + r"export\s*\{([^{}]*)\}(?!\s*from);?", re.MULTILINE)
_DEFAULT = re.compile(_BEGINS + r"export default (?!(?:async )?(?:function\*?|class)\s+\w)", re.MULTILINE)
_EXPORTED = re.compile(r"^export (?=(?:const|class|(?:async )?function\*?)\s+([\w$]+))", re.MULTILINE)
_AWAITS = re.compile(r"^\S.*\bawait\b|^await\b", re.MULTILINE)  # on a line that is not within a function
_LEFT = re.compile(r"^(?:import\b(?!\()|export\b).*", re.MULTILINE)
_BEGIN = "const modules = (globalThis.modules$ = {});\n"
# a later script does not import the one before, which may be waiting for it
_ASK = """let asked$;
const later$ = () => (asked$ ??= import("LATER").then(({ run }) => run(modules)).catch((error) => {
  asked$ = undefined;
  throw error;
}));
"""


class CombineError(ValueError):
    """Modules that cannot be combined; the message names the file and says what is wrong with it."""


@dataclass(frozen=True, slots=True)
class Step:
    """One of the scripts: its modules' text, and their addresses in the order in which they run."""

    body: str
    modules: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Combined:
    """The scripts of a page: the first, what it imports later, what that imports later, and so on."""

    steps: tuple[Step, ...]

    def script(self, number: int, next_address: str = "") -> str:
        """Return a script, which finds the one behind it, if there is one, at an address."""
        ask = _ASK.replace("LATER", next_address) if number + 1 < len(self.steps) else ""
        body = ask + self.steps[number].body
        return f"export async function run(modules) {{\n{body}}}\n" if number else _BEGIN + body


@dataclass(frozen=True, slots=True)
class _Module:
    imports: tuple[tuple[str, str], ...]  # what is bound, from which address
    later: tuple[str, ...]
    exports: Mapping[str, str]  # the name outside -> the name inside
    body: str


def combine(entries: Sequence[str], read: Callable[[str], str]) -> Combined:
    """Return all that ``entries`` import as scripts.

    ``read`` returns a module's text by its address, or raises OSError. What a script imports later runs,
    all of it together, when the first of it is asked for.

    Raises:
        CombineError: a module is not there, imports in a circle or what another does not export, exports what
            may change, or imports or exports in a form that is not known here.
    """
    known: dict[str, _Module] = {}
    steps: list[Step] = []
    while entries:
        before = set(known)
        _read_in_order(entries, read, known)
        modules = tuple(address for address in known if address not in before)
        here = frozenset(known)
        steps.append(Step("".join(_block(address, known, here) for address in modules), modules))
        entries = sorted({to for address in modules for to in known[address].later} - here)
    return Combined(tuple(steps))


def resolved(of: str, to: str) -> str:
    """Return the address that an import in a module means; both begin with a slash."""
    if to.startswith("/"):
        return to
    parts = of.split("/")[:-1]
    for part in to.split("/"):
        if part == "..":
            parts.pop()
        elif part != ".":
            parts.append(part)
    return "/".join(parts)


def _read_in_order(entries: Iterable[str], read: Callable[[str], str], known: dict[str, _Module]) -> None:
    """Read modules into ``known``, each behind those that it imports."""

    def visit(address: str, above: tuple[str, ...]) -> None:
        if address in known:
            return
        if address in above:
            circle = " imports ".join((*above[above.index(address) :], address))
            raise CombineError(f"{circle}: a circle. Move what both need into a module of its own.")
        try:
            text = read(address)
        except OSError:
            asker = f"{above[-1]} imports" if above else "A page or an import() names"
            raise CombineError(f"{asker} {address}, which is not there.") from None
        module = _parsed(address, text)
        for _, needed in module.imports:
            visit(needed, (*above, address))
        known[address] = module

    for entry in entries:
        visit(entry, ())


def _parsed(address: str, text: str) -> _Module:
    text = _ASIDE.sub("", text)
    imports = tuple((clause or "", resolved(address, to)) for clause, to in _IMPORT.findall(text))
    exports = {name: name for name in _EXPORTED.findall(text)}
    for names in _EXPORTS.findall(text):
        exports |= {outer: inner for inner, outer in _pairs(names)}
    if _DEFAULT.search(text):
        exports["default"] = "default$"
    body = _IMPORT.sub(_lines, text)
    body = _DEFAULT.sub("const default$ = ", _EXPORTS.sub(_lines, _EXPORTED.sub("", body)))
    if left := _LEFT.search(body):
        raise CombineError(
            f"{address} has `{left.group()[:80]}`, which cannot be combined: "
            "import and export by names that never change."
        )
    later = tuple(resolved(address, to) for to in _LATER.findall(body))
    return _Module(imports, later, exports, body)


def _lines(found: re.Match[str]) -> str:
    return "\n" * found.group().count("\n")


def _pairs(names: str) -> list[tuple[str, str]]:
    """Return (first, second name) of each of ``a, b as c``; one without ``as`` is both."""
    words = [name.split() for name in names.split(",") if name.strip()]
    return [(word[0], word[-1]) for word in words]


def _block(address: str, known: Mapping[str, _Module], here: frozenset[str]) -> str:
    module = known[address]
    bound = "".join(_bound(address, clause, of, known[of].exports) for clause, of in module.imports)

    def at_once_or_later(found: re.Match[str]) -> str:
        to = resolved(address, found[1])
        return f'{"Promise.resolve()" if to in here else "later$()"}.then(() => modules["{to}"])'

    body = _LATER.sub(at_once_or_later, module.body)
    exports = ", ".join(f"{json.dumps(outer)}: {inner}" for outer, inner in module.exports.items())
    call = "await (async () => {" if _AWAITS.search(body) else "(() => {"
    return f'// {address}\n{call}{bound}\n{body}\nmodules["{address}"] = {{ {exports} }};\n}})();\n'


def _bound(address: str, clause: str, of: str, exports: Mapping[str, str]) -> str:
    """Return the statements that bind what one import names."""
    form = _CLAUSE.fullmatch(clause)
    if form is None:
        raise CombineError(f"{address} imports `{clause}` from {of}: a form that cannot be combined.")
    default, whole, names = form.groups()
    pairs = _pairs(names or "") + ([("default", default)] if default else [])
    for outer, _ in pairs:
        if outer not in exports:
            raise CombineError(f"{address} imports {outer} from {of}, which does not export it.")
    if whole:
        return f' const {whole} = modules["{of}"];'
    inner = ", ".join(f"{outer}: {name}" for outer, name in pairs)
    return f' const {{ {inner} }} = modules["{of}"];' if pairs else ""
