"""Is the best hypothesis good enough? What is left, described; and what is no physics at all."""
