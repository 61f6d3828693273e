"""Where viser keeps the one page that is its browser side."""

from __future__ import annotations

from pathlib import Path

import viser

CLIENT_PAGE = Path(viser.__file__).parent / "client" / "build" / "index.html"
