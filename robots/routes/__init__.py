"""Ways for people: from tag to tag along where robots really drove, in words that need no map."""
