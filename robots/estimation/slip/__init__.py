"""Telling whether wheels slip."""
