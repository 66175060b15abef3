"""Sweeps: worlds x controllers x parameters x seeds, run in processes or on Ray."""
