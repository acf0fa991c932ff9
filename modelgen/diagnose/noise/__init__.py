"""Noise: level, colour, an instrument's smooth error, and what sampling and smoothing do."""
