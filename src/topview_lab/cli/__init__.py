"""The laboratory's subcommands, one thin file each."""
