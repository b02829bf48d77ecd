"""From a prescription to a lens."""
