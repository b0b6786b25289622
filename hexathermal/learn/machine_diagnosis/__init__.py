"""What is wrong with a whole machine's model, told from 6-D measurements: which leg, which plate, which frame."""
