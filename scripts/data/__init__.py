"""The real body, and the names of the measured muscles."""
