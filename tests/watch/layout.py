"""Edits of what the host demands of the shaders."""

from support.session import SHADE, Session


class Layout(Session):
    def check_refused(self, name, old, new, file, says, step="check"):
        """Refused for this reason at the edited place; the picture stays, and comes back with the old text."""
        with self.watch() as w:
            w.picture()
            before = self.exr()
            text = self.source(name).read_bytes()
            line = self.edit(name, old, new)
            event = w.refused()
            self.assertEqual(event["step"], step, w)
            self.assert_diagnosis(w, event, file, line if file == name else None, says)
            self.assertEqual(self.exr(), before)
            self.save(name, text)
            w.picture()
            self.assertEqual(self.exr(), before)

    def test_a_binding_that_the_host_lacks(self):
        self.check_refused("interface.h", "TURNER_BLOCK(Pixels, 2,", "TURNER_BLOCK(Pixels, 12,", "interface.h", "12")

    def test_two_bindings_in_each_others_place(self):
        text = self.source("interface.h").read_text()
        text = text.replace("(Pixels, 2,", "(Pixels, 1,").replace("(State, 1,", "(State, 2,")
        with self.watch() as w:
            w.picture()
            before = self.exr()
            self.save("interface.h", text)
            event = w.refused()
            self.assertEqual(event["step"], "check", w)
            self.assert_diagnosis(w, event, "interface.h")
            self.assertEqual(self.exr(), before)

    def test_a_work_group_of_another_size(self):
        self.check_refused("whitted.comp", "local_size_x_id = kSpecWorkGroup", "local_size_x = 7", "whitted.comp", "")

    def test_a_member_more_in_the_push_constants(self):
        old = "uint stride;         //"
        self.check_refused("layout.h", old, "uint more, stride;   //", "layout.h", "")

    def test_a_member_that_moves(self):
        self.check_refused("layout.h", "  uint unfinished;      //", "  uint room;\n  uint unfinished;      //", "layout.h", "")

    def test_a_constant_of_another_value(self):
        self.check_refused("layout.h", "kRefNone = 0xffffffffu;", "kRefNone = 0xfffffffdu;", "layout.h", "kRefNone")

    def test_a_binding_of_another_number(self):
        self.check_refused("interface.h", "TURNER_ARRAY(Materials, 7,", "TURNER_ARRAY(Materials, 8,", "interface.h", "Materials")

    def test_what_the_host_can_follow(self):
        with self.watch() as w:
            w.picture()
            before = self.exr()
            self.edit("layout.h", "kCanaryLength = 4u;", "kCanaryLength = 4u;  // turns,")
            w.picture()
            self.assertEqual(self.exr(), before)
            text = self.source("layout.h").read_text()
            self.save("layout.h", text.replace("TURNER_CONST kCanaryLength", "TURNER_CONST kMine = 2u;\nTURNER_CONST kCanaryLength"))
            w.picture()
            self.assertEqual(self.exr(), before)
            self.edit("shade.glsl", SHADE, SHADE.replace("E", "float(kMine) * E", 1))
            w.picture()
            self.assertNotEqual(self.exr(), before)
            self.assert_shows_the_sources(w)
