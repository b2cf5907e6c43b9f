"""What input is believed, what happens without, and the limits that every command passes."""
