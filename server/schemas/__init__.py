"""What goes over the wire: pydantic models with units in the names, descriptions and examples."""
