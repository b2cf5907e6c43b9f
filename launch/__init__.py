"""Launch files, one per situation."""
