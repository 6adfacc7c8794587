"""Standard input and output under the name "-", pipes and FIFOs; signals while one waits for them."""

import json
import math
import os
import pty
import signal
import socket
import subprocess
import time

from support.command import DONE, INTERRUPTED, PROMPT, TERMINATED, TIMEOUT, TINY, WRONG_INPUT, Command, Run
from support.pictures import Exr, write_exr
from support.scene_texts import MESH_SCENE, NFF, OBJ, SPHERE
from support.settings import PROGRAM

QUICK = [*TINY, "--backend", "reference"]
RENDER = '"$T" render scene.json ' + " ".join(QUICK)


class Streams(Command):
    def setUp(self):
        super().setUp()
        self.write("scene.json", SPHERE)

    def shell(self, script, code=DONE):
        """A run by bash; stdout as bytes, stderr as text. turner is $T."""
        command = ["bash", "-o", "pipefail", "-c", script]
        environment = self.environment({"T": str(PROGRAM)})
        run = subprocess.run(command, cwd=self.folder, env=environment, timeout=TIMEOUT, capture_output=True)
        self.assertEqual(run.returncode, code, run)
        return run.stdout, run.stderr.decode()

    def feed(self, text, *args, code=DONE, says=()):
        """A run that reads this."""
        command = [str(PROGRAM), *map(str, args)]
        run = subprocess.run(command, cwd=self.folder, env=self.environment(None), input=text.encode(),
                             capture_output=True, timeout=TIMEOUT)
        self.assertEqual(run.returncode, code, run)
        for word in [says] if isinstance(says, str) else says:
            self.assertIn(word, run.stderr.decode(), run)
        return run

    def rendered(self, *args, output="witness.exr"):
        self.do("render", "scene.json", *QUICK, "--quiet", "-o", output, *args)
        return self.path(output).read_bytes()

    # --- outputs ---

    def test_a_picture_on_stdout_is_that_of_a_file_and_what_is_told_goes_to_stderr(self):
        for name, output in (("-", "witness.exr"), ("exr:-", "witness.exr"), ("png:-", "witness.png"),
                             ("/dev/stdout", "witness.exr"), ("png:/dev/fd/1", "witness.png")):
            with self.subTest(name):
                out, err = self.shell(f"{RENDER} -o {name} | cat")
                self.assertEqual(out, self.rendered(output=output))
                self.assertIn("scene: ", err)
                self.assertIn("traced in", err)
                self.assertEqual(self.shell(f"{RENDER} -o {name} --quiet | cat")[1], "")

    def test_a_picture_on_stdout_goes_into_a_file_of_the_shell(self):
        witness = self.rendered()
        self.shell(f"{RENDER} -o - --quiet > out.exr")
        self.assertEqual(self.path("out.exr").read_bytes(), witness)
        self.shell(f"echo before > out.exr; {RENDER} -o - --quiet >> out.exr")
        self.assertEqual(self.path("out.exr").read_bytes(), b"before\n" + witness)

    def test_figures_on_stdout_are_json_and_nothing_else(self):
        for name in ("-", "/dev/stdout"):
            with self.subTest(name):
                out, err = self.shell(f"{RENDER} -o out.exr --stats {name} | cat")
                self.assertEqual(json.loads(out)["options"]["width"], 8)
                self.assertIn("wrote out.exr", err)

    def test_an_error_image_on_stdout(self):
        self.rendered()
        out, err = self.shell('"$T" compare witness.exr witness.exr --error-image - > error.exr')
        self.assertEqual(set(Exr(self.path("error.exr")).values()), {0})
        self.assertIn("rmse", err)
        self.refuse("compare", "witness.exr", "witness.exr", "--error-image", "-", "--json", says=["--json", "standard"])

    def test_two_outputs_on_stdout_are_refused(self):
        for names in (("-", "--stats -"), ("-", "-o -"), ("-", "--stats /dev/stdout"), ("png:-", "-o /dev/fd/1")):
            with self.subTest(names):
                self.refuse("render", "scene.json", *QUICK, "-o", names[0], *names[1].split(), says="<stdout>")

    def test_a_picture_on_a_terminal_is_refused(self):
        ours, theirs = pty.openpty()
        self.addCleanup(os.close, ours)
        self.addCleanup(os.close, theirs)
        for name in ("-", "png:-", "/dev/stdout", f"exr:{os.ttyname(theirs)}"):
            with self.subTest(name):
                run = self.run_turner("render", "scene.json", *QUICK, "-o", name, stdout=theirs)
                self.assertEqual(run.code, WRONG_INPUT, run)
                self.check_message(run, says="terminal")

    def test_a_process_that_the_shell_runs_is_an_output(self):
        witness = self.rendered()
        self.shell(f"{RENDER} --quiet -o >(cat > out.exr); while ! cmp -s out.exr witness.exr; do sleep 0.05; done")
        self.shell(f"{RENDER} --quiet -o other.exr --stats >(cat > s.json); while ! grep -q tree s.json; do sleep 0.05; done")
        self.assertEqual(self.path("other.exr").read_bytes(), witness)

    def test_a_fifo_is_an_output_and_stays_one(self):
        witness = self.rendered()
        os.mkfifo(self.path("fifo.exr"))
        self.assertEqual(self.shell(f"{RENDER} --quiet -o fifo.exr & cat fifo.exr; wait $!")[0], witness)
        self.assertTrue(self.path("fifo.exr").is_fifo())

    def test_a_file_of_the_name_dash_and_names_with_a_colon(self):
        witness = self.rendered()
        self.do("render", "scene.json", *QUICK, "-o", "exr:./-", "-o", "./png:x.exr", "-o", "exr:no ending")
        for name in ("-", "png:x.exr", "no ending"):
            self.assertEqual(self.path(name).read_bytes(), witness, name)

    def test_where_a_stream_makes_no_sense_it_is_refused(self):
        self.refuse("watch", "-", "-o", "out.exr", says="standard input")
        self.refuse("watch", "scene.json", "-o", "-", says="<stdout>")
        self.refuse("watch", "scene.json", "-o", "/dev/stdout", says="/dev/stdout")
        self.refuse("watch", "scene.json", "-o", "out.exr", "--keep", "-", says=["--keep", "folder"])
        self.refuse("report", "scene.json", "-o", "-", says="folder")
        self.refuse("shaders", "--copy", "-", says="folder")
        os.mkfifo(self.path("fifo.json"))
        self.refuse("watch", "fifo.json", "-o", "out.exr", says="fifo.json")

    # --- inputs ---

    def test_a_scene_from_stdin_is_that_of_a_file(self):
        witness = self.rendered()
        run = self.feed(SPHERE, "render", "-", *QUICK, "-o", "out.exr")
        self.assertIn(b"scene: <stdin>", run.stdout)
        self.assertEqual(Exr(self.path("out.exr")).bits(), Exr(self.path("witness.exr")).bits())
        self.assertEqual(Exr(self.path("out.exr")).attributes["turner:scene"], b"stdin")
        self.assertEqual(self.shell(f'"$T" render - {" ".join(QUICK)} -o exr:- --quiet < scene.json | wc -c')[0],
                         f"{len(witness) + len('stdin') - len('scene')}\n".encode())

    def test_the_format_of_a_scene_from_stdin_is_told_by_its_beginning(self):
        self.write("scene.nff", NFF)
        self.do("render", "scene.nff", *QUICK, "-o", "witness.exr")
        for text in (NFF, "\n  " + NFF, NFF.removeprefix("# a ball on a floor\n")):
            self.feed(text, "render", "-", *QUICK, "-o", "out.exr")
            self.assertEqual(Exr(self.path("out.exr")).bits(), Exr(self.path("witness.exr")).bits())
        for text in ("\ufeff" + SPHERE, "// v is no view\n/* s 0 0 0 1 */\n" + SPHERE, "\n\n" + SPHERE):
            self.feed(text, "render", "-", *QUICK, "-o", "out.exr")

    def test_faults_of_a_scene_from_stdin_have_their_place(self):
        self.feed('{\n "width": -1 }', "render", "-", "-o", "out.exr", code=WRONG_INPUT, says="<stdin>:2:")
        self.feed("v\nfrom 0 0\n", "render", "-", "-o", "out.exr", code=WRONG_INPUT, says="<stdin>:2:")
        self.feed("", "render", "-", "-o", "out.exr", code=WRONG_INPUT, says="<stdin>")
        self.feed(SPHERE, "render", "-", code=WRONG_INPUT, says="-o")
        self.assertEqual(self.files(), ["scene.json"])

    def test_meshes_of_a_scene_from_stdin_are_looked_for_in_the_current_folder(self):
        self.write("shape.obj", OBJ)
        run = self.feed(MESH_SCENE, "render", "-", *QUICK, "-o", "out.exr")
        self.assertIn(b"1 triangle", run.stdout)
        for scene in ("<(cat mesh.json)", "/dev/stdin < mesh.json", "/dev/stdin < <(cat mesh.json)",
                      "/dev/fd/8 8< mesh.json"):  # fmt: skip
            with self.subTest(scene):
                self.write("mesh.json", MESH_SCENE)
                out, _ = self.shell(f'"$T" render {scene} {" ".join(QUICK)} -o out.exr')
                self.assertIn(b"1 triangle", out)
        # Nothing is written over them there either.
        os.symlink("shape.obj", self.path("link.exr"))
        self.feed(MESH_SCENE, "render", "-", *QUICK, "-o", "link.exr", code=WRONG_INPUT, says=["shape.obj", "is an input"])
        self.assertEqual(self.path("shape.obj").read_text(), OBJ)

    def test_pipes_are_scenes_meshes_and_pictures(self):
        self.rendered()
        self.shell(f'"$T" render <(cat scene.json) {" ".join(QUICK)} --quiet -o out.exr')
        self.assertEqual(Exr(self.path("out.exr")).bits(), Exr(self.path("witness.exr")).bits())
        out, _ = self.shell('"$T" compare <(cat out.exr) <(cat witness.exr) --json')
        self.assertEqual(json.loads(out)["max"], 0)
        out, _ = self.shell('cat out.exr | "$T" compare - witness.exr --json')
        self.assertEqual(json.loads(out)["max"], 0)
        out, _ = self.shell(f'"$T" compare - {" ".join(TINY)} --json < scene.json')
        self.assertEqual(json.loads(out)["width"], 8)
        self.write("mesh.json", MESH_SCENE)
        os.mkfifo(self.path("shape.obj"))
        self.write("shape", OBJ)
        out, _ = self.shell(f'cat shape > shape.obj & "$T" render mesh.json {" ".join(QUICK)} -o out.exr')
        self.assertIn(b"1 triangle", out)

    def test_a_report_of_a_scene_from_stdin_says_so_in_its_commands(self):
        options = ["--width", "8", "--max-samples", "1", "--repeats", "1", "-o", "out"]
        self.feed(SPHERE, "report", "-", *options)
        report = json.loads(self.path("out/report.json").read_text())
        self.assertTrue(report["command"].startswith("turner report - -o out"), report["command"])
        self.assertTrue(report["scenes"][0]["points"][0]["command"].startswith("turner render - -o stdin-"))

    def test_a_socket_is_both_stdin_and_stdout(self):
        """As of a server that starts a process for each of its clients."""
        witness = self.rendered()
        ours, theirs = socket.socketpair()
        with ours:
            with theirs:
                process = subprocess.Popen([str(PROGRAM), "render", "/dev/stdin", *QUICK, "--quiet", "-o", "-"],
                                           cwd=self.folder, stdin=theirs, stdout=theirs)
            ours.sendall(SPHERE.encode())
            ours.shutdown(socket.SHUT_WR)
            received = b"".join(iter(lambda: ours.recv(1 << 16), b""))
        self.assertEqual(process.wait(TIMEOUT), DONE)
        self.assertEqual(len(received), len(witness) - len("scene") + len("stdin"))
        self.write("out.exr", received)
        self.assertEqual(Exr(self.path("out.exr")).bits(), Exr(self.path("witness.exr")).bits())

    def test_one_pipe_cannot_be_read_twice(self):
        os.mkfifo(self.path("fifo.exr"))
        self.refuse("compare", "fifo.exr", "./fifo.exr", says=["fifo.exr", "read once"])
        self.refuse("report", "-", "-", "-o", "out", says=["<stdin>", "read once"], stdin=subprocess.PIPE)
        ours, theirs = socket.socketpair()
        with ours, theirs:
            for stdin in (subprocess.PIPE, theirs):
                self.refuse("compare", "-", "/dev/stdin", says=["<stdin>", "read once"], stdin=stdin)

    def test_what_has_no_end_is_refused(self):
        self.path("zero.json").symlink_to("/dev/zero")
        self.refuse("render", "zero.json", says=["zero.json", "device"])
        self.refuse("compare", "/dev/zero", "/dev/zero", says=["/dev/zero", "device"])

    def test_a_closed_stdin_is_an_error(self):
        _, err = self.shell('"$T" render - -o out.exr <&-', code=WRONG_INPUT)
        self.assertIn("<stdin>: error: cannot read: Bad file descriptor", err)

    # --- signals while one waits ---

    def end_waiting(self, *args, by=signal.SIGINT, code=INTERRUPTED, **options):
        """Starts what waits without an end; a signal ends it, and everything is as before."""
        before = self.snapshot()
        process = subprocess.Popen([str(PROGRAM), *map(str, args)], cwd=self.folder, env=self.environment(None),
                                   stderr=subprocess.PIPE, **{"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL} | options)
        try:
            with self.assertRaises(subprocess.TimeoutExpired, msg=f"it does not wait: {args}"):
                process.wait(1.5)
            process.send_signal(by)
            start = time.monotonic()
            _, err = process.communicate(timeout=TIMEOUT)
        finally:
            process.kill()
        run = Run([*map(str, args)], process.returncode, "", err.decode(), time.monotonic() - start)
        self.assertEqual(run.code, code, run)
        self.check_message(run, says="interrupted")
        self.check_takes(run.seconds, PROMPT, run)
        self.assertEqual(self.snapshot(), before, run)

    def test_signals_are_heard_while_one_waits_for_the_other_end_of_a_fifo(self):
        write_exr(self.path("a.exr"), 2, 2, [(0, 0, 0)] * 4)
        for name in ("fifo.json", "fifo.exr"):
            os.mkfifo(self.path(name))
        self.end_waiting("render", "fifo.json", "-o", "out.exr")
        self.end_waiting("render", "scene.json", *QUICK, "-o", "fifo.exr")
        self.end_waiting("compare", "a.exr", "fifo.exr", by=signal.SIGTERM, code=TERMINATED)

    def test_signals_are_heard_while_a_large_polygon_is_cut(self):
        """It takes half a minute: a warped one that is convex nowhere."""
        corners = 100_000
        angles = [2 * math.pi * i / corners for i in range(corners)]
        radii = [1 + 0.2 * math.sin(37 * angle) + 0.01 * (i % 2) for i, angle in enumerate(angles)]
        vertices = "".join(f"v {r * math.cos(a)!r} {r * math.sin(a)!r} {0.3 * math.cos(2 * a) + 0.5 * r * math.cos(a)!r}\n"
                           for r, a in zip(radii, angles))  # fmt: skip
        self.write("shape.obj", vertices + "f " + " ".join(str(i + 1) for i in range(corners)) + "\n")
        self.write("mesh.json", MESH_SCENE)
        self.end_waiting("render", "mesh.json", *QUICK, "-o", "out.exr")

    def test_signals_are_heard_while_a_pipe_stalls(self):
        held, full = os.pipe()
        try:
            os.set_blocking(full, False)
            while True:
                os.write(full, bytes(4096))
        except BlockingIOError:
            os.set_blocking(full, True)
        try:
            # The writer is ended by the same Ctrl-C: communicate() closes its end.
            self.end_waiting("render", "-", "-o", "out.exr", stdin=subprocess.PIPE)
            self.end_waiting("render", "scene.json", *QUICK, "--quiet", "-o", "-", stdout=full)
            self.end_waiting("render", "scene.json", *QUICK, "-o", "-", "--quiet", stdout=full, by=signal.SIGTERM,
                             code=TERMINATED)
        finally:
            os.close(held)
            os.close(full)

    def test_what_was_written_before_ctrl_c_is_named(self):
        os.mkfifo(self.path("fifo.exr"))
        args = ["render", "scene.json", *QUICK, "--quiet", "-o", "first.exr", "-o", "fifo.exr"]
        process = subprocess.Popen([str(PROGRAM), *args], cwd=self.folder, stderr=subprocess.PIPE, text=True)
        while not self.path("first.exr").exists():
            time.sleep(0.05)
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=TIMEOUT)
        self.assertEqual((process.returncode, err), (INTERRUPTED, "turner: error: interrupted; written were first.exr\n"))
