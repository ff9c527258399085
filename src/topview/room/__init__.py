"""What a frame shows of the room: floor, walls, what stands out, and whether the camera moves."""
