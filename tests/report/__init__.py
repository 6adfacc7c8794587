"""Tests of turner report."""
