"""Other programs on the same scenes, at equal error."""
