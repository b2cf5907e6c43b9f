"""What a model lacks: which effect of the catalogue explains what it leaves."""
