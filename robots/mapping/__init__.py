"""Occupancy grids: submaps anchored to poses, and their fusion into one map."""
