"""`python -m topview`: the command line."""

from topview.cli.main import main

main()
