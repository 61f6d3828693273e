"""How to get somewhere: the plan grid, travel costs, A* and path following."""
