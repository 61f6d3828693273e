"""What `waymark bench` measures, one module each; every one returns a flat dict with units in the names."""
