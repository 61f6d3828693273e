"""Processes that hold the agents and the team map, and what keeps them alive."""
