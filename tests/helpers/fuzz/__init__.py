"""A corpus of broken input, made by seeded code, and what runs it against the command line.

A case is a family, such as "truth.npz | a key's type", and a seed; both together say all. `bases`
writes files that are whole, `spoiling` breaks them, `cases` says which and how, `running` runs
them, in a process of their own, and tells how each ended.
"""
