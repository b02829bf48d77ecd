"""Measurements that take minutes: tables of papers made again, and our own."""
