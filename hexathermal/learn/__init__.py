"""Measurements -> a better model: campaigns, identification, validation."""
