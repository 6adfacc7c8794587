"""The benchmark, and its test."""
