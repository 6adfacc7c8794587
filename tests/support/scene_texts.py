"""Small scenes as texts, in each format."""

import re

SPHERE = """{
  "width": 64, "height": 48, "background": [0.25, 0.5, 1],
  "camera": { "eye": [0, 0, 5], "target": [0, 0, 0], "fov": 40 },
  "lights": [ { "position": [3, 5, 4] } ],
  "materials": { "clay": { "diffuse": [0.7, 0.6, 0.5], "reflect": 0.2 } },
  "spheres": [ { "center": [0.1, 0.2, 0], "radius": 1.1, "material": "clay" } ]
}
"""

# A matte floor under a mirror ball.
NFF = """# a ball on a floor
v
from 0 1.5 5
at 0 0.6 0
up 0 1 0
angle 40
hither 1
resolution 64 48
b 0.1 0.2 0.3
l 3 5 4
f 0.8 0.7 0.6 0.5 0.5 20 0 1
s 0 1 0 1
f 0.3 0.5 0.2 1 0 1 0 1
p 4
-4 0 4
4 0 4
4 0 -4
-4 0 -4
"""

OBJ = """v 0 0 0
v 1 0 0
v 0 1 0
f 1 2 3
"""

MESH_SCENE = '{ "materials": { "m": {} }, "meshes": [ { "file": "shape.obj", "material": "m" } ] }\n'


def remove_comments(text):
    return re.sub(r'("(?:\\.|[^"\\])*")|//[^\n]*', lambda m: m[1] or "", text)
