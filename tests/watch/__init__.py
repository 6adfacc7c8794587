"""Tests of turner watch."""
