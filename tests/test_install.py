"""Installs a build into an empty folder and uses it from there: the program must find its own shaders and scenes.

usage: test_install.py --build FOLDER
"""

import argparse
import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile


def watch_a_copy(program, folder, shaders):
    """Copies the installed shaders, edits the copy while it is watched, and ends by Ctrl-C."""
    copied = subprocess.run([program, "shaders", "--copy", "my"], cwd=folder, check=True, stdout=subprocess.PIPE,
                            text=True)
    assert shaders in copied.stdout, copied.stdout
    command = [program, "watch", "scenes/spheres.json", "--shaders", "my", "--width", "32", "--height", "18", "--json"]
    watching = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True)
    try:
        for version in (1, 2):
            told = next(e for e in map(json.loads, watching.stdout) if e["event"] in ("version", "refused"))
            assert told["event"] == "version" and told["version"] == version, told
            source = folder / "my" / "shade.glsl"
            source.write_text(source.read_text().replace("float q = 0.5", "float q = 0.1"))
        assert told["changed"] == ["shade.glsl"] and told["changed_pixels"] > 0, told
        watching.send_signal(signal.SIGINT)
        assert watching.wait(timeout=60) == 130, watching.returncode
    finally:
        watching.kill()
        watching.wait()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--build", type=pathlib.Path, required=True)
    arguments = parser.parse_args()

    folder = pathlib.Path(tempfile.mkdtemp())
    try:
        prefix, elsewhere = folder / "prefix", folder / "elsewhere"
        elsewhere.mkdir()
        subprocess.run(["cmake", "--install", arguments.build, "--prefix", prefix], check=True,
                       stdout=subprocess.DEVNULL)
        program = prefix / "bin" / "turner"
        done = subprocess.run([program, "render", "scenes/spheres.json", "--width", "32", "--height", "18"],
                              cwd=elsewhere, check=True, stdout=subprocess.PIPE, text=True, timeout=600)
        assert str(prefix / "share/turner/scenes/spheres.json") in done.stdout, done.stdout
        assert os.path.getsize(elsewhere / "spheres.exr") > 0
        json.loads((prefix / "share/turner/scenes/scene.schema.json").read_text())

        watch_a_copy(program, elsewhere, str(prefix / "share/turner/shaders"))

        # Without its own shaders it must not pass silently to others': it falls back to the source tree it was built
        # from, and says what is wrong when an explicit folder is empty.
        refused = subprocess.run([program, "render", "scenes/spheres.json", "--shaders", str(elsewhere)],
                                 cwd=elsewhere, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        assert refused.returncode == 2 and "whitted.comp" in refused.stderr, refused
    finally:
        shutil.rmtree(folder)
    print("installed, found its shaders and scenes, rendered, watched")


main()
