"""Examples; each runs on its own and in the tests."""
