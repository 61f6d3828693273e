"""Recordings of real robots, one module per format."""
