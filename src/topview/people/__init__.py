"""Who is in view: whose each point is, how tall they are, and identities that last."""
