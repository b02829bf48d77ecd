"""What is not of the field: errors, whole files, progress, compiled loops, videos, versions."""
