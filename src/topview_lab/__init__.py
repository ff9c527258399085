"""The laboratory of topview: what makes, measures and compares; nothing that tracking needs."""
