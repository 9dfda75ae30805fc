"""What holds for all tests."""

import signal

# A shell that starts the tests in the background has Ctrl-C ignored, and children inherit that; here some are sent it.
signal.signal(signal.SIGINT, signal.default_int_handler)
