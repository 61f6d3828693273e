"""EKF-SLAM over tags known by their ids (Ziparo 2007)."""
