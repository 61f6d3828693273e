"""Where to go next: frontiers of the known space, and strategies that choose among them."""
