"""The live page: fingers and nodes as they are now, their last half minute, and what to notice."""
