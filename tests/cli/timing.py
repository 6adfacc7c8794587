"""Times of the commands, on a machine that does nothing else: tests of other modules, with bars for what they take."""

from cli import cache, interruption, options
from support.command import Command


class Interruption(interruption.Interruption):
    holds_times = True


class ShaderCache(cache.ShaderCache):
    holds_times = True


class CommandLine(Command):
    holds_times = True
    test_pictures_too_large_are_refused_at_once = options.CommandLine.test_pictures_too_large_are_refused_at_once
