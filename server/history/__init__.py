"""What a mission showed at every moment: how it is recorded, read again, and handed over."""
