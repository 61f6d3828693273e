"""Batch smoothing of what was seen by range."""
