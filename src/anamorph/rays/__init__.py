"""Casting rays at a scene."""
