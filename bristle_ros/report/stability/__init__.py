"""Stiff and extreme scenes by the hundred: which finish, and whether they make sense."""
