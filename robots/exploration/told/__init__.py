"""What tags tell of ground that others have covered, and what is left in them."""
