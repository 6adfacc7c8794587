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
        self.check_refused("whitted.comp", "binding = kBindPixels)", "binding = 12)", "whitted.comp", "12")

    def test_two_bindings_in_each_others_place(self):
        text = self.source("whitted.comp").read_text()
        text = text.replace("binding = kBindPixels", "binding = X").replace("binding = kBindState", "binding = kBindPixels")
        with self.watch() as w:
            w.picture()
            before = self.exr()
            self.save("whitted.comp", text.replace("binding = X", "binding = kBindState"))
            event = w.refused()
            self.assertEqual(event["step"], "check", w)
            self.assert_diagnosis(w, event, "whitted.comp")
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
        self.check_refused("layout.h", "kBindMaterials = 7u;", "kBindMaterials = 8u;", "layout.h", "kBindMaterials")

    def test_what_the_host_can_follow(self):
        with self.watch() as w:
            w.picture()
            before = self.exr()
            self.edit("layout.h", "kLightBufferRows = 6u;", "kLightBufferRows = 6u;  // one for each face")
            w.picture()
            self.assertEqual(self.exr(), before)
            text = self.source("layout.h").read_text()
            self.save("layout.h", text.replace("TURNER_CONST kLightBufferRows", "TURNER_CONST kMine = 2u;\nTURNER_CONST kLightBufferRows"))
            w.picture()
            self.assertEqual(self.exr(), before)
            self.edit("shade.glsl", SHADE, SHADE.replace("E", "float(kMine) * E", 1))
            w.picture()
            self.assertNotEqual(self.exr(), before)
            self.assert_shows_the_sources(w)
