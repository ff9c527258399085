"""Who is in view: floor, users, their points, heights and lasting identities."""
