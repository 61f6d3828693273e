"""Tours through free ground: a lattice of stations, and the way through them that makes most ground safe."""
