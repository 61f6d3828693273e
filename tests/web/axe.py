"""What axe-core finds on a page: violations of WCAG 2.2, levels A and AA."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import Page

AXE = Path(__file__).parents[2] / "web" / "node_modules" / "axe-core" / "axe.min.js"

# The 3D view is viser's own page in a frame; what it shows the plan and the lists have as well.
_RUN = """async () => {
  const { violations } = await axe.run({ exclude: [["iframe"]] }, {
    iframes: false, resultTypes: ["violations"],
    runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"],
  });
  return violations.flatMap(({ id, nodes }) => nodes.map((node) =>
    `${id}: ${node.target}: ${node.failureSummary.replaceAll("\\n", " ")} ${node.html.slice(0, 99)}`));
}"""

# What gloves cannot hit or masks not read: targets under 64 px, text under 20 px, what is cut off aside.
SMALL = """() => {
  const all = [...document.querySelectorAll("body *")];
  const shown = all.filter((e) => e.checkVisibility() && !e.closest(".unseen"));
  const named = (found) => found.map((e) => e.outerHTML.slice(0, 80));
  const low = shown.filter((e) => e.matches("button, .button, input:not(.unseen), select"));
  const text = shown.filter((e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim()));
  return {
    low: named(low.filter((e) => e.getBoundingClientRect().height < 64)),
    small: named(text.filter((e) => parseFloat(getComputedStyle(e).fontSize) < 20)),
    wide: document.documentElement.scrollWidth - innerWidth,
  };
}"""


class Audit:
    """Gathers the violations of a page's states, so that one run tells them all."""

    def __init__(self, page: Page) -> None:
        if not AXE.is_file():
            pytest.fail("axe-core is not installed: run `make setup`, or `npm ci` in web/")
        self._page = page
        self.found: list[str] = []

    def look(self, state: str) -> None:
        """Look at the page as it stands, in the dark theme and in the daylight one."""
        page = self._page
        if not page.evaluate("typeof axe === 'object'"):
            page.evaluate(AXE.read_text())
        for theme in ("dark", "daylight"):
            choose = f"(look) => look.chooseLook({{ theme: '{theme}' }})"
            page.evaluate(f"import('/static/theme.js').then({choose})")
            self.found += [f"{state}, {theme}: {violation}" for violation in page.evaluate(_RUN)]

    def look_in_gloves(self, state: str) -> None:
        """Look at a page of the phone, also for what is too small there."""
        self.look(state)
        for fault, seen in self._page.evaluate(SMALL).items():
            self.found += [f"{state}, {fault}: {seen}"] if seen else []
