"""Exit statuses of the command line; 0 is all well."""

BUG = 1
UNUSABLE_INPUT = 2
BROKEN_PIPE = 141  # 128 + SIGPIPE, as shells say it
INTERRUPTED = 130  # 128 + SIGINT, as shells say it; of another signal `main` makes its own
