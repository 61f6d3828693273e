"""Encryption where no public authority reaches: an own one for the field's network."""
