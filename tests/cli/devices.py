"""turner devices, and the choice of one."""

import json

from support.command import FAILED, NO_DRIVER, TINY, Command
from support.scene_texts import SPHERE


class Devices(Command):
    def devices(self):
        return json.loads(self.do("devices", "--json").out)

    def test_devices_are_listed_for_people_and_for_programs(self):
        devices = self.devices()
        self.assertGreaterEqual(len(devices), 1)
        text = self.do("devices").out
        self.assertEqual(len(text.splitlines()), len(devices))
        for i, device in enumerate(devices):
            self.assertEqual(device["index"], i)
            for key in ("name", "type", "driver"):
                self.assertIsInstance(device[key], str)
                self.assertIn(device[key], text)

    def test_a_device_is_chosen_by_index_and_by_a_part_of_its_name(self):
        scene = self.write("scene.json", SPHERE)
        devices = self.devices()
        last = devices[-1]
        for wanted in (str(last["index"]), last["name"], last["name"].upper()):
            run = self.do("render", scene, *TINY, "--device", wanted, "--stats", "stats.json")
            self.assertIn(last["name"], run.out)
            self.assertEqual(json.loads(self.path("stats.json").read_text())["device"]["name"], last["name"])
        part = last["name"][:5]
        if sum(part.lower() in device["name"].lower() for device in devices) == 1:
            self.assertIn(last["name"], self.do("render", scene, *TINY, "--device", part).out)
        self.do("compare", scene, *TINY, "--device", str(last["index"]), "--json")

    def test_an_unknown_device_is_refused_with_a_list_of_the_devices(self):
        scene = self.write("scene.json", SPHERE)
        devices = self.devices()
        for wanted in ("no such device", str(len(devices)), "-1", "99999999999999999999"):
            for command in ("render", "compare"):
                with self.subTest(f"{command} --device {wanted}"):
                    # The fault's line, then a line for each device.
                    run = self.refuse(command, scene, "--device", wanted, says=wanted, faults=None)
                    self.assertEqual(len(run.err.splitlines()), 1 + len(devices), run)
                    for device in devices:
                        self.assertIn(f"{device['index']}: {device['name']}", run.err)

    def test_the_environment_names_a_device_and_the_option_overrides_it(self):
        scene = self.write("scene.json", SPHERE)
        device = self.devices()[-1]
        named = {"TURNER_DEVICE": device["name"]}
        wrong = {"TURNER_DEVICE": "no such device"}
        self.assertIn(device["name"], self.do("render", scene, *TINY, env=named).out)
        self.path("scene.exr").unlink()
        self.refuse("render", scene, *TINY, env=wrong, says=["no such device", device["name"]], faults=None)
        self.refuse("compare", scene, *TINY, env=wrong, says=["no such device", device["name"]], faults=None)
        self.do("render", scene, *TINY, "--device", str(device["index"]), env=wrong)
        self.do("render", scene, *TINY, env={"TURNER_DEVICE": ""})

    def test_without_any_device_a_run_fails_and_says_what_to_install(self):
        scene = self.write("scene.json", SPHERE)
        for validation in ("1", "0"):
            environment = dict(NO_DRIVER, TURNER_VALIDATION=validation)
            for command in (["devices"], ["devices", "--json"], ["render", scene], ["compare", scene]):
                with self.subTest(f"{command} TURNER_VALIDATION={validation}"):
                    run = self.refuse(*command, code=FAILED, env=environment, says="mesa-vulkan-drivers")
                    self.assertNotIn("[", run.out)

    def test_the_reference_needs_no_device(self):
        scene = self.write("scene.json", SPHERE)
        self.do("render", scene, "--backend", "reference", "--stats", "stats.json", env=NO_DRIVER)
        self.write("a.exr", self.path("scene.exr").read_bytes())
        self.do("compare", "a.exr", "scene.exr", env=NO_DRIVER)

    def test_missing_validation_layers_fail_and_are_named(self):
        scene = self.write("scene.json", SPHERE)
        nowhere = {"VK_LAYER_PATH": "/nonexistent", "VK_ADD_LAYER_PATH": "/nonexistent"}
        self.refuse("render", scene, code=FAILED, env=nowhere, says="vulkan-validationlayers")
