"""Exploration by the thousand: scouts with true poses that move in steps; nothing else is made simpler."""
