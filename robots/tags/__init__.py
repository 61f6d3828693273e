"""Tags: what their memory holds, and where to leave them."""
