"""Shaders that hurt: loops without end, wrong indices, what compilers do not like."""

import os
import pathlib
import time

from support.pictures import Exr
from support.rights import say_not_possible
from support.session import MAIN, SHADE, Session

# lavapipe ends the loops of an invocation after 65,535 turns in all: each of them must be long.
HANG = f"""
  float hang = float(frame.canaryLength);
  for (uint a = 0u; a < 60000u; ++a)
    for (uint b = 0u; b < 60000u; ++b) {{
      {"hang = fract(sin(hang) * 43758.5); " * 256}
    }}
  if (hang == 2.0) return;
"""
HANGING = ["--width", "256", "--height", "192"]


class Harm(Session):
    def check_survives(self, w, name, old, new, **expected):
        """An edit that hurts; then the picture is what it was before, and comes again with the old text."""
        before = self.exr()
        text = self.source(name).read_bytes()
        line = self.edit(name, old, new)
        event = w.outcome()
        after = self.exr()
        self.save(name, text)
        w.picture()
        self.assertEqual(self.exr(), before, w)
        for key, value in expected.items():
            self.assertEqual(event.get(key), value, w)
        if event["event"] == "refused":
            self.assertEqual(after, before, w)
            self.assertTrue(event["diagnoses"] and all(d["message"] for d in event["diagnoses"]), w)
        return event, line

    def test_an_endless_loop(self):
        with self.watch() as w:
            w.picture()
            for name, old, new in (
                ("shade.glsl", SHADE, f"while (E.x != 2e9) {{ E.y += 1.0; }}\n  {SHADE}"),
                ("whitted.comp", MAIN, f"{MAIN} for (uint i = 1u; i != 0u; i |= 1u) atomicAdd(status.unfinished, 0u);"),
                ("whitted.comp", "} while (LOOPS_AT_HEAD || (phase != kDone && budget > 0));", "} while (true);"),
            ):
                with self.subTest(new):
                    event, line = self.check_survives(w, name, old, new, event="refused", endless=True)
                    (found,) = event["diagnoses"]
                    self.assertEqual(pathlib.Path(found["file"]).name, name, w)
                    self.assertRegex(found["message"], "endless loop", w)
                    self.assertAlmostEqual(found["line"], line, delta=3)
                    self.assert_gcc(w, name, found["line"], "endless loop")

    def test_a_kernel_that_writes_nothing(self):
        """Whatever is said of it: what lay in memory is no picture."""
        with self.watch() as w:
            w.picture()
            before = self.exr()
            for new in (f"{MAIN} return;", f"{MAIN} if (gl_WorkGroupID.x % 2u == 1u) return;"):
                with self.subTest(new):
                    self.edit("whitted.comp", MAIN, new)
                    event = w.outcome()
                    after = self.exr()
                    if event["event"] == "picture":
                        black = Exr(self.path("out.exr"))
                        known = {(0, 0, 0)} | {black.pixel(0, 0)}
                        self.assertTrue({black.pixel(x, 0) for x in range(64)} <= known, w)
                    else:
                        self.assertEqual(after, before)
                    self.edit("whitted.comp", new, MAIN)
                    w.picture()
                    self.assertEqual(self.exr(), before)

    def test_a_kernel_that_hangs_is_killed_after_the_timeout(self):
        with self.watch("--timeout", "1", *HANGING) as w:
            w.picture()
            w.figures()
            started = time.monotonic()
            before = self.exr()
            line = self.edit("whitted.comp", MAIN, MAIN + HANG)
            event = w.refused()
            self.assertLessEqual(1, event["at"] - started)
            self.check_takes(event["at"] - started, 20, w)
            self.assertTrue(event["endless"], w)
            (found,) = event["diagnoses"]
            self.assertEqual(pathlib.Path(found["file"]).name, "whitted.comp")
            self.assertTrue(line <= found["line"] <= line + 6, w)
            self.assertIn("1 s", found["message"], w)
            self.assertEqual(self.exr(), before)
            self.edit("whitted.comp", MAIN + HANG, MAIN)
            w.picture()
            self.assertEqual(self.exr(), before)

    def test_a_newer_save_and_ctrl_c_do_not_wait_for_a_kernel_that_hangs(self):
        def hang():
            # Two threads: one of them may be the driver's compiler.
            w.wait_for_work(lambda: self.edit("whitted.comp", MAIN, MAIN + HANG), threads=min(2, os.cpu_count()))

        # Without the newer save the version would be refused, much later.
        with self.watch("--timeout", "100", *HANGING) as w:
            w.picture()
            w.figures()
            w.wait("reference")
            before = self.exr()
            hang()
            started = time.monotonic()
            self.edit("whitted.comp", MAIN + HANG, MAIN)
            self.check_takes(w.picture()["at"] - started, 5, w)
            w.figures()
            hang()
            w.interrupt(most=2)
            self.assertEqual(self.exr(), before)

    def test_indices_out_of_range(self):
        with self.watch() as w:
            w.picture()
            table = "float table[3] = float[3](1.0, 1.0, 1.0);"
            for name, old, new in (
                # Known to the compiler.
                ("shade.glsl", SHADE, f"{table} return table[3] * E;"),
                # A local array; how far is known only when it runs.
                ("shade.glsl", SHADE, f"{table} return table[frame.canaryLength * 1000000u] * E;"),
                ("shade.glsl", SHADE, f"{table} table[frame.canaryLength * 100000u] = 2.0; return table[1] * E;"),
                # Buffers: read, written.
                ("shade.glsl", SHADE, "return E * xyz(ROW(materials, 0x0fffffffu));"),
                ("whitted.comp", "pixels[pixelAt] = packWord", "pixels[pixelAt + 0x03ffffffu] = packWord"),
                ("whitted.comp", "pixels[pixelAt] = packWord", "pixels[pixelAt * 4096u] = packWord"),
            ):
                with self.subTest(new):
                    self.check_survives(w, name, old, new)

    def test_what_compilers_do_not_like(self):
        laughs = "#define L0 (1.0 + 1.0)\n" + "".join(f"#define L{i} (L{i - 1} + L{i - 1})\n" for i in range(1, 40))
        with self.watch() as w:
            w.picture()
            for what, new in (
                ("deep brackets", "return E * " + "(" * 100_000 + "1.0" + ")" * 100_000 + ";"),
                ("deep blocks", "{" * 20_000 + "}" * 20_000 + SHADE),
                ("recursion", "return lightReflected(surface, V, lightPosition, E, material);"),
                ("a very long line", "return E * (" + " + ".join(["0.001"] * 20_000) + ");"),
            ):
                with self.subTest(what):
                    self.check_survives(w, "shade.glsl", SHADE, new)
            with self.subTest("macros without end"):
                w.figures()
                before = self.exr()
                text = self.source("shade.glsl").read_text()
                w.wait("reference")
                endless = laughs + text.replace(SHADE, "return E * L39;")
                w.wait_for_work(lambda: self.save("shade.glsl", endless), seconds=0.5)
                started = time.monotonic()
                self.save("shade.glsl", text)
                self.check_takes(w.picture()["at"] - started, 10, w)
                self.assertEqual(self.exr(), before)

    def test_a_compiler_that_crashes(self):
        """lavapipe 22.3 dies of it."""
        with self.watch() as w:
            w.picture()
            new = "shared uint far[64];\nvoid main() { far[frameInMemory.canaryLength * 0x1000000u] = 1u;"
            event, _ = self.check_survives(w, "whitted.comp", MAIN, new)
            if event["event"] == "picture":
                return say_not_possible("to make the driver crash")
            self.assertIn("signal", event["diagnoses"][0]["message"], w)

    def test_an_endless_loop_that_does_nothing(self):
        """A compiler may drop it; then the picture is that without it."""
        with self.watch() as w:
            w.picture()
            before = self.exr()
            self.edit("whitted.comp", MAIN, f"{MAIN} while (true) {{}}")
            w.outcome()
            self.assertEqual(self.exr(), before, w)

    def test_what_only_the_driver_sees(self):
        with self.watch() as w:
            w.picture()
            for what, new in (
                ("barriers that not all reach", f"if (E.x > 0.5) barrier();\n  {SHADE}"),
                ("too much shared memory", "return E;\n}\nshared float big[100000000];\nvoid useBig() { big[3] = 1.0;"),
                ("doubles", "return vec3(dvec3(E) * 2.0LF);"),
                ("NaN", "return E * sqrt(-E.x) * 0.0 / 0.0;"),
            ):
                with self.subTest(what):
                    self.check_survives(w, "shade.glsl", SHADE, new)
