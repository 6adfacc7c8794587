// What is said of an OBJ file that is not quite right, and renders all the same.
#pragma once

#include "scene/counted_notes.h"

namespace turner::obj {

inline constexpr NoteKind kUnknown{"unknown statement was passed over", "unknown statements were passed over"};
inline constexpr NoteKind kMaterialLines{"line of a material library was passed over",
                                         "lines of a material library were passed over"};
inline constexpr NoteKind kUnusedVertices{"vertex is no place, but no face has it",
                                          "vertices are no places, but no face has them"};
inline constexpr NoteKind kVertexExtras{"vertex has something behind x y z that is neither a weight nor a colour",
                                        "vertices have something behind x y z that is neither a weight nor a colour"};
inline constexpr NoteKind kNoDirection{"normal has no direction; faces with it are flat",
                                       "normals have no direction; faces with them are flat"};
inline constexpr NoteKind kNormalExtras{"normal has something behind x y z", "normals have something behind x y z"};
inline constexpr NoteKind kNormalsMissing{"face lacks the normal of a corner and is flat",
                                          "faces lack the normal of a corner and are flat"};
inline constexpr NoteKind kFewCorners{"face of fewer than 3 corners was dropped",
                                      "faces of fewer than 3 corners were dropped"};
inline constexpr NoteKind kNoArea{"polygon without area was dropped", "polygons without area were dropped"};
inline constexpr NoteKind kCrossing{"face crosses or overlaps itself and was cut into triangles anyhow",
                                    "faces cross or overlap themselves and were cut into triangles anyhow"};

}  // namespace turner::obj
