"""The instrument: from recordings to a model that explains them."""
