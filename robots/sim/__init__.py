"""The simulator: one world for batch runs and live missions. A source of observations, like a real robot."""
