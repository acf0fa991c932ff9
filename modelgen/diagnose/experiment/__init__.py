"""The recording that would tell apart what the data do not."""
