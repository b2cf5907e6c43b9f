"""Measured grasps with outcomes, replayed through the controller: whether bound and force fit them."""
