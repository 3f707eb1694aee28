"""What it costs to leave a feature in, and how it is left out."""
