"""Data: a real body, and the names of the muscles of a measured body."""
