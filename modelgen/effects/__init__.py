"""The catalogue: physics that models leave out. A tuple of values, a file a subject."""
