"""Running tests, and reading imports and prose in the sources."""
