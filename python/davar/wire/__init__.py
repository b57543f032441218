"""The stream of a device: frames, sources, the receiver, its recording."""
