"""Tests that drive the program as its users do."""
