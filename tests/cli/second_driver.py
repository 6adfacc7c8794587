"""A second Vulkan driver: SwiftShader, of Debian's chromium-common. It masks lanes otherwise than lavapipe, has other
limits and rounds otherwise what Vulkan leaves open; the pictures are held to the reference like lavapipe's.
"""

import json
import pathlib

from support.command import TINY, Command
from support.settings import SCENES

ICDS = sorted(pathlib.Path("/usr/lib").glob("**/vk_swiftshader_icd.json"))


class SwiftShader(Command):
    def setUp(self):
        super().setUp()
        self.assertTrue(ICDS, "no SwiftShader: apt-get install chromium-common")
        self.driver = {"VK_DRIVER_FILES": str(ICDS[0]), "VK_ICD_FILENAMES": str(ICDS[0]), "TURNER_DEVICE": ""}

    def check(self, scene, size):
        """Against the reference, by a device that passes the self-test."""
        size = ["--width", str(size), "--height", str(size)]
        figures = json.loads(self.do("compare", SCENES / scene, *size, "--json", env=self.driver).out)
        self.assertEqual((figures["nan"], figures["inf"]), (0, 0))
        self.assertLess(figures["p99"], 1e-5, figures)
        self.assertLess(figures["bad_pixels"], 0.002, figures)

    def test_it_is_there(self):
        devices = json.loads(self.do("devices", "--json", env=self.driver).out)
        self.assertEqual([device["type"] for device in devices], ["CPU"])
        self.assertIn("SwiftShader", devices[0]["name"])

    def test_spheres(self):
        self.check("spheres.json", 128)

    def test_nested_glass(self):
        self.check("nested_glass.json", 48)

    def test_a_mesh_that_is_too_large_for_texels(self):
        """Vulkan's least, 65,536 texels, is SwiftShader's most: the scene is fetched from storage buffers."""
        gears = ["render", SCENES / "spd/gears.nff", *TINY, "-o", "a.exr"]
        self.assertIn("fetching buffers", self.do(*gears, env=self.driver).out)
        self.check("spd/gears.nff", 48)
        # Whoever asks for texels is told what to ask for instead.
        self.path("a.exr").unlink()
        self.refuse(*gears, "--fetch", "texels", says=["texels", "--fetch"], env=self.driver)
