"""What the hexapod is: frozen data, its files, the bundled machines, the closed-loop mechanism."""
