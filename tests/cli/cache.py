"""The cache of compiled shaders."""

import json
import os

from support.command import TINY, Command
from support.scene_texts import SPHERE


class ShaderCache(Command):
    def setUp(self):
        super().setUp()
        self.write("scene.json", SPHERE)
        # The driver's cache is empty too.
        self.caches = {"XDG_CACHE_HOME": str(self.path("cache")), "MESA_SHADER_CACHE_DIR": str(self.path("mesa"))}

    def render(self, **changes):
        """The picture's bytes and the seconds of compiling."""
        args = ["scene.json", *TINY, "--quiet", "-o", "a.exr", "--stats", "stats.json"]
        self.do("render", *args, env=self.caches | changes)
        return self.path("a.exr").read_bytes(), json.loads(self.path("stats.json").read_text())["seconds"]["compile"]

    def kept_shader(self):
        """The kernel: the self-test's shader is smaller by far."""
        return max(self.path("cache/turner").glob("*.spirv"), key=lambda path: path.stat().st_size)

    def test_a_second_start_uses_what_the_first_has_compiled(self):
        picture, cold = self.render()
        kept = self.kept_shader()
        files = sorted(self.path("cache/turner").iterdir())
        # And that the device has passed its self-test.
        self.assertEqual([path.suffix for path in files if path != kept and path.suffix != ".spirv"], [".self-test"])
        number = kept.stat().st_ino
        os.utime(kept, (0, 0))
        again, warm = self.render()
        self.assertEqual(again, picture)
        self.check_takes(warm, cold)
        self.assertEqual(sorted(self.path("cache/turner").iterdir()), files)
        self.assertGreater(kept.stat().st_mtime, 0, "marked as used")
        self.assertEqual(kept.stat().st_ino, number, "not written again")

    def test_a_damaged_or_unusable_cache_is_not_noticed(self):
        picture, _ = self.render()
        kept = self.kept_shader()
        whole = kept.read_bytes()
        kept.write_bytes(whole[: len(whole) // 2])
        self.assertEqual(self.render()[0], picture)
        self.assertEqual(kept.read_bytes(), whole)
        self.write("file", "not a folder")
        for nowhere in ("file", "no/such/folder"):
            self.assertEqual(self.render(XDG_CACHE_HOME=str(self.path(nowhere)))[0], picture, nowhere)
        self.assertEqual(self.render(XDG_CACHE_HOME="", HOME="")[0], picture)
