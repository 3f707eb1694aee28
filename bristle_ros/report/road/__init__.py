"""Error against run time where the road is not level, or the wire lies down on it."""
