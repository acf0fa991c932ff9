"""Property tests draw the same examples at every run, so that a failure can be seen again. Ctrl-C works in
tests, though a shell that runs them in the background has it ignored."""

import signal

from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")
signal.signal(signal.SIGINT, signal.default_int_handler)
