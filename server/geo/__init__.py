"""Where a mission lies on the Earth: WGS 84, UTM, MGRS, and the frame that joins them to the map."""
