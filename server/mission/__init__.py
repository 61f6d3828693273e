"""A mission while it runs: ``mission.py`` is the one way through, each other module one room beside it."""
