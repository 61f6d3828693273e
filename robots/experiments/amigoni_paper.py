"""Table 1 of Amigoni 2013, and its text for one robot.

Safe area in m2, mean and deviation of five runs, by map, robots, strategy and coordination. The table prints
673.48.77 for one cell, read here as 673.48.
"""

PAPER_M2: dict[tuple[str, int, str, str], tuple[float, float | None]] = {
    ("office", 2, "aojrf", "original"): (299.77, 53.60),
    ("office", 2, "mcdm", "original"): (341.95, 12.54),
    ("office", 3, "aojrf", "original"): (341.58, 98.62),
    ("office", 3, "mcdm", "original"): (387.41, 66.67),
    ("office", 2, "aojrf", "simplified"): (257.53, 54.65),
    ("office", 2, "mcdm", "simplified"): (262.43, 15.62),
    ("office", 3, "aojrf", "simplified"): (320.40, 63.71),
    ("office", 3, "mcdm", "simplified"): (325.14, 42.21),
    ("office", 2, "aojrf", "none"): (306.36, 65.91),
    ("office", 2, "mcdm", "none"): (330.27, 46.38),
    ("office", 3, "aojrf", "none"): (332.58, 42.03),
    ("office", 3, "mcdm", "none"): (374.28, 40.31),
    ("office", 2, "random", "random"): (211.68, 18.86),
    ("open", 2, "random", "random"): (472.71, 115.48),
    ("office", 1, "aojrf", "none"): (230.0, None),
    ("office", 1, "mcdm", "none"): (250.0, None),
    ("open", 2, "aojrf", "original"): (430.18, 78.86),
    ("open", 2, "mcdm", "original"): (498.45, 51.12),
    ("open", 3, "aojrf", "original"): (483.46, 130.14),
    ("open", 3, "mcdm", "original"): (511.83, 118.35),
    ("open", 2, "aojrf", "simplified"): (586.77, 72.16),
    ("open", 2, "mcdm", "simplified"): (678.27, 48.77),
    ("open", 3, "aojrf", "simplified"): (673.48, 85.61),
    ("open", 3, "mcdm", "simplified"): (690.16, 36.69),
    ("open", 2, "aojrf", "none"): (356.92, 65.97),
    ("open", 2, "mcdm", "none"): (425.05, 99.01),
    ("open", 3, "aojrf", "none"): (458.55, 80.30),
    ("open", 3, "mcdm", "none"): (498.08, 81.03),
}  # fmt: skip
