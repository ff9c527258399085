"""topview: 3D body tracking of several people from one depth camera, without training data."""
