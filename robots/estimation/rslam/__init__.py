"""RSLAM (Sun 2009): range-only SLAM by particles that each carry Kalman filters of the nodes."""
