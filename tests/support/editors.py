"""Saves a file as editors do."""

import os


def write_in_place(path, data):
    """Two writes into the same file, as of a text that is longer than the editor's buffer."""
    with open(path, "wb", buffering=0) as file:
        file.write(data[: len(data) // 2])
        file.write(data[len(data) // 2 :])


def write_and_rename(path, data):
    new = path.with_name(f".{path.name}.swp")
    new.write_bytes(data)
    os.replace(new, path)


def move_away_and_write(path, data):
    backup = path.with_name(path.name + "~")
    if path.exists():
        os.replace(path, backup)
    path.write_bytes(data)
    backup.unlink(missing_ok=True)


def delete_and_write(path, data):
    path.unlink(missing_ok=True)
    path.write_bytes(data)


def overwrite_and_cut(path, data):
    with open(path, "r+b" if path.exists() else "w+b") as file:
        file.write(data)
        file.truncate()


EDITORS = [write_in_place, write_and_rename, move_away_and_write, delete_and_write, overwrite_and_cut]
