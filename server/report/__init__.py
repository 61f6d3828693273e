"""The report of a mission to hand over: one HTML file, read from the mission's past."""
