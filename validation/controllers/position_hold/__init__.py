"""Grippers that close on force and then hold position: constants on top against a memory."""
