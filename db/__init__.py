"""What survives a restart: missions, robots, the observation log and everything people and robots found."""
