"""Figures, tables and what the command line teaches."""
