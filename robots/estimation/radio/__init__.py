"""What the signals of tags tell: path loss, means, ranges."""
