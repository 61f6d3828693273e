"""Pose graphs of poses and points: solved whole, or as they grow."""
