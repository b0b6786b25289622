"""The virtual bench: a leg that warms up, its thermometers, its interferometers, its room."""
