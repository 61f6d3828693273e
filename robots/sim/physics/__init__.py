"""A physical 4WD robot (MuJoCo, extra ``physics``): drives that teach the slip detector what slip looks like."""
