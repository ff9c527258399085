"""Many recordings: which they are, what each becomes, and who does the work."""
