"""The virtual machine and bench: what would be measured."""
