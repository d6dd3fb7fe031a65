"""The figures of docs/mathematics, drawn from the functions of the core."""
