"""Exit statuses of the command line; 0 is all well."""

BUG = 1
UNUSABLE_INPUT = 2
INTERRUPTED = 130  # 128 + SIGINT, as shells say it; of another signal `main` makes its own
