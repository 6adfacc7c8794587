"""The command line: help, wrong commands, options and values."""

import re

from support.command import FAILED, PROMPT, TINY, Command
from support.pictures import write_exr
from support.scene_texts import SPHERE
from support.settings import SCENES


class CommandLine(Command):
    def test_version_and_help_are_no_errors(self):
        run = self.do("--version")
        self.assertRegex(run.out, r"^turner \d+\.\d+\.\d+\n$")
        for command in ([], ["render"], ["compare"], ["devices"]):
            texts = [self.do(*command, flag).out for flag in ("--help", "-h")]
            self.assertEqual(texts[0], texts[1])
            self.assertIn("Usage: " + " ".join(["turner", *command]), texts[0])
        self.assertEqual(self.files(), [])

    def test_every_command_is_there(self):
        overview = self.do("--help").out
        for command in ("render", "compare", "devices"):
            with self.subTest(command):
                self.assertRegex(overview, rf"(?m)^  {command} ")
                self.assertIn(f"turner {command}", self.do(command, "--help").out)

    def test_help_names_every_option_of_the_contract(self):
        options = "--width --height --samples --depth --sampler --seed --min-weight --geometry --device --crop"
        own = {
            "render": "-o --backend --stats",
            "compare": "--max-rmse --max-error --max-bad-pixels --threshold --error-image --json --decompose --envelope",
        }
        for command, names in own.items():
            text = self.do(command, "--help").out
            for name in f"{options} --shaders --quiet {names}".split():
                self.assertRegex(text, rf"(?m)(^|[ ,]){re.escape(name)}\b", f"{command} {name}")

    def test_unknown_commands_are_refused_with_the_nearest_one(self):
        self.refuse("rendr", "scene.json", says=["rendr", "did you mean", "render"])
        self.refuse("device", says=["device", "did you mean", "devices"])
        self.refuse("xyzzyxyzzy", says="xyzzyxyzzy")
        self.refuse("")

    def test_no_command_is_refused_with_the_commands(self):
        self.refuse(says=["render", "compare", "devices"])

    def test_unknown_options_are_refused_with_the_nearest_one(self):
        scene = self.write("scene.json", SPHERE)
        for args, wrong, right in (
            (["render", scene, "--widht", "64"], "--widht", "--width"),
            (["render", scene, "--sample=2"], "--sample", "--samples"),
            (["render", scene, "--max-rmse", "1"], "--max-rmse", None),
            (["compare", scene, "--max-rms", "1"], "--max-rms", "--max-rmse"),
            (["compare", scene, "--backend", "shader"], "--backend", None),
            (["devices", "--jsn"], "--jsn", "--json"),
            (["--versoin"], "--versoin", "--version"),
            (["render", scene, "-x"], "-x", None),
            (["render", scene, "another.json"], "another.json", None),
            (["devices", "extra"], "extra", None),
        ):
            with self.subTest(args):
                self.refuse(*args, says=[wrong, f"did you mean {right}"] if right else [wrong])

    def test_missing_values_are_refused(self):
        scene = self.write("scene.json", SPHERE)
        valued = "--width --height --samples --depth --sampler --seed --min-weight --geometry --device --crop --shaders"
        for option in (valued + " --output --backend --stats --tile --work-group").split():
            with self.subTest(option):
                self.refuse("render", scene, option, says=option)
        self.refuse("render", scene, "-o", says="-o")
        for option in ("--max-rmse", "--max-error", "--max-bad-pixels", "--threshold", "--error-image"):
            with self.subTest(option):
                self.refuse("compare", scene, option, says=option)
        self.refuse("render", says="SCENE")

    def test_empty_values_are_refused(self):
        scene = self.write("scene.json", SPHERE)
        for option in "--output --crop --shaders --stats --width --sampler --min-weight".split():
            with self.subTest(option):
                self.refuse("render", scene, *TINY, option, "")
        self.refuse("compare", scene, *TINY, "--error-image", "")
        self.refuse("render", "")

    def test_numbers_out_of_range_are_refused_with_the_range(self):
        scene = self.write("scene.json", SPHERE)
        for option, most in (("--width", "65536"), ("--height", "65536"), ("--samples", "256"), ("--depth", "64")):
            for value in ("0", "-1", "1000000", "99999999999999999999", "2.5", "1e2", "x", "nan", " ", "0x"):
                with self.subTest(f"{option} {value}"):
                    self.refuse("render", scene, option, value, says=[option, value, f"1 to {most}"])

    def test_whole_numbers_are_decimal(self):
        # A leading zero is not C's octal.
        scene = self.write("scene.json", SPHERE)
        picture = self.picture(scene, "--width", "010", "--height", "8", "--backend", "reference")
        self.assertEqual(picture.width, 10)

    def test_wrong_seeds_are_refused_with_the_range(self):
        scene = self.write("scene.json", SPHERE)
        for value in ("-1", "4294967296", "1.5", "x", "1e400"):
            with self.subTest(value):
                self.refuse("render", scene, *TINY, "--seed", value, says=["--seed", value, "4294967295"])

    def test_wrong_weights_are_refused_with_the_range(self):
        scene = self.write("scene.json", SPHERE)
        for value in ("-0.1", "1.1", "nan", "-nan", "inf", "1e400", "x", "0.5x"):
            with self.subTest(value):
                self.refuse("render", scene, *TINY, "--min-weight", value, says=["--min-weight", value, "0 to 1"])

    def test_wrong_choices_are_refused_with_the_choices(self):
        scene = self.write("scene.json", SPHERE)
        for option, choices in (
            ("--sampler", ("grid", "jitter", "sobol")),
            ("--backend", ("shader", "reference")),
            ("--geometry", ("exact", "rounded")),
        ):
            for value in ("middle", "0", "1"):
                with self.subTest(f"{option} {value}"):
                    run = self.refuse("render", scene, *TINY, option, value, says=[option, value, *choices])
                    self.assertNotRegex(run.err, r"->|FAILED|Check ", "a message for people")

    def test_wrong_crops_are_refused(self):
        scene = self.write("scene.json", SPHERE)
        for crop in (
            *("1,2,3", "1,2,3,4,5", "0;0;8;8", "0,0,8,", "0, 0, 8, 8", "a,b,c,d", "0,0,nan,8", "0,0,8.5,8"),
            *("0,0,0,0", "10,10,10,20", "20,10,10,20", "0,0,65,48", "0,0,64,49", "-1,0,8,8"),
            "0,0,99999999999999999999,8",
        ):
            with self.subTest(crop):
                self.refuse("render", scene, f"--crop={crop}", says=["--crop", crop])

    def test_wrong_tiles_and_work_groups_are_refused(self):
        scene = self.write("scene.json", SPHERE)
        for value in ("0", "7", "-8", "1000000", "x"):
            with self.subTest(f"--tile {value}"):
                self.refuse("render", scene, "--tile", value, says=["--tile", value])
        for value in ("0", "-1", "1000000", "x", "1.5"):
            with self.subTest(f"--work-group {value}"):
                self.refuse("render", scene, "--work-group", value, says=value)

    def test_pictures_too_large_are_refused_at_once(self):
        for size in (["--width", "65536", "--height", "65536"], ["--width", "65536", "--height", "4097"]):
            for backend in ("shader", "reference"):
                args = ["render", SCENES / "spheres.json", *size, "--backend", backend]
                run = self.refuse(*args, says=["65536", "--crop"])
                self.check_takes(run.seconds, PROMPT, run)
        whole = ["--width", "65536", "--height", "65536", "--crop", "0,0,65536,65536"]
        self.refuse("compare", SCENES / "spheres.json", *whole)
        self.refuse("render", self.write("huge.json", '{ "width": 65536, "height": 65536 }'))

    def test_figures_that_cannot_be_printed_are_a_failure(self):
        write_exr(self.path("a.exr"), 2, 2, [(0, 0, 0)] * 4)
        with open("/dev/full", "w") as full:
            compare = ["compare", "a.exr", "a.exr"]
            for command in (compare, [*compare, "--json"], ["devices", "--json"]):
                with self.subTest(command):
                    self.refuse(*command, code=FAILED, stdout=full, says="No space left on device")
