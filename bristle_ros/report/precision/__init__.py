"""Error against run time of our own settings, and what their errors are measured against."""
