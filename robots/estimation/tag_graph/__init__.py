"""SLAM over tags under the antenna: the tag graph (Kleiner 2006)."""
