"""A physical 4WD robot (MuJoCo, extra ``physics``): it teaches the slip detector what slip looks like."""
