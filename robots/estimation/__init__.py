"""Where the robot is: odometry, scan matching, their fusion, and the tag graph."""
