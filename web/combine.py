"""Many ES modules as two scripts: what a page needs first, and what it asks for by ``import()`` later.

Each module becomes a function with a scope of its own, called at once, in the order in which browsers run
modules. What it exports becomes one object, kept in the page's ``modules$`` under the module's address:
nothing is renamed, and each module is there once.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import chain

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
# the later script does not import the first, which may be waiting for it
_BEGIN_LATER = """let asked$;
const later$ = () => (asked$ ??= import("LATER").then(({ run }) => run(modules, later$)).catch((error) => {
  asked$ = undefined;
  throw error;
}));
"""


class CombineError(ValueError):
    """Modules that cannot be combined; the message names the file and says what is wrong with it."""


@dataclass(frozen=True, slots=True)
class Combined:
    """The two scripts (``later`` is empty where nothing is imported later), and their modules as they run."""

    body: str
    later: str
    first_modules: tuple[str, ...]
    later_modules: tuple[str, ...]

    def first(self, later: str) -> str:
        """Return the first script, which finds the other at the address ``later``."""
        return _BEGIN + (_BEGIN_LATER.replace("LATER", later) if self.later else "") + self.body


@dataclass(frozen=True, slots=True)
class _Module:
    imports: tuple[tuple[str, str], ...]  # what is bound, from which address
    later: tuple[str, ...]
    exports: Mapping[str, str]  # the name outside -> the name inside
    body: str


def combine(entries: Iterable[str], read: Callable[[str], str]) -> Combined:
    """Return all that ``entries`` import as two scripts.

    ``read`` returns a module's text by its address, or raises OSError. What is imported later runs, all of it
    together, when the first of it is asked for.

    Raises:
        CombineError: a module is not there, imports in a circle or what another does not export, exports what
            may change, or imports or exports in a form that is not known here.
    """
    known: dict[str, _Module] = {}
    first_modules = _in_order(entries, read, known)
    asked = _asked_for(known)
    while not asked <= known.keys():
        _in_order(sorted(asked), read, known)
        asked = _asked_for(known)
    later_modules = tuple(address for address in known if address not in first_modules)
    blocks = {address: _block(address, known, frozenset(later_modules)) for address in known}
    first = "".join(map(blocks.__getitem__, first_modules))
    rest = "".join(map(blocks.__getitem__, later_modules))
    run = f"export async function run(modules, later$) {{\n{rest}}}\n" if rest else ""
    return Combined(first, run, first_modules, later_modules)


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


def _asked_for(known: Mapping[str, _Module]) -> set[str]:
    return set(chain.from_iterable(module.later for module in known.values()))


def _in_order(
    entries: Iterable[str], read: Callable[[str], str], known: dict[str, _Module]
) -> tuple[str, ...]:
    """Read modules into ``known``, each behind those that it imports; return all addresses in it."""

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
    return tuple(known)


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


def _block(address: str, known: Mapping[str, _Module], later: frozenset[str]) -> str:
    module = known[address]
    bound = "".join(_bound(address, clause, of, known[of].exports) for clause, of in module.imports)

    def at_once_or_later(found: re.Match[str]) -> str:
        to = resolved(address, found[1])
        return f'{"later$()" if to in later else "Promise.resolve()"}.then(() => modules["{to}"])'

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
