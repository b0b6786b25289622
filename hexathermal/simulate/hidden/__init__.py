"""Campaigns with something hidden in them: benches of different physics, effects, and the answers, for testing a diagnosis."""
