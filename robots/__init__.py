"""The mind of a robot: pure, deterministic, and free of any server, database or browser."""
