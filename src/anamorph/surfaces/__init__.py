"""Exact surfaces: what a mesh only approximates."""
