"""What robots of a team tell each other, and what each makes of it."""
