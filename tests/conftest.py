"""What all tests need."""

import signal

# A shell that runs its jobs in the background has them ignore interrupts, and so would the processes of the tests.
signal.signal(signal.SIGINT, signal.default_int_handler)
