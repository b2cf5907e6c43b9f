"""Many recordings at once: which hand, which pad, which effect, since when."""
