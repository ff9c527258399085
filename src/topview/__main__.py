"""`python -m topview`: the command line."""

from topview.cli.app import main

main()
