"""What a robot does besides exploring: orders, going back, making way, getting free, looking into warmth."""
