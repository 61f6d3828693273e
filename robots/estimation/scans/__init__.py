"""Matching laser scans and clouds of them."""
