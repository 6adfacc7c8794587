// Tables, searched one by one: such lines are few beside those of vertices and faces.
#include "scene/obj/obj_words.h"

#include <algorithm>
#include <cctype>
#include <vector>

#include "base/diagnostics.h"

namespace turner::obj {

namespace {

const std::vector<std::string> kShape{"v", "vn", "f"};
const std::vector<std::string> kPassedOver{"vt",     "vp",       "o",        "g",   "s",          "mg",
                                           "usemtl", "mtllib",   "l",        "p",   "bevel",      "usemap",
                                           "maplib", "c_interp", "d_interp", "lod", "shadow_obj", "trace_obj"};
const std::vector<std::string> kMaterial{"newmtl", "Ka", "Kd",    "Ks",        "Ke",   "Tf",   "Tr",    "Ns",
                                         "Ni",     "d",  "illum", "sharpness", "bump", "disp", "decal", "refl",
                                         "norm",   "Pr", "Pm",    "Ps",        "Pc",   "Pcr",  "aniso", "anisor"};
// Free-form curves and surfaces, also in their older spelling, and calls of other files or programs.
const std::vector<std::string> kNotSupported{"cstype", "deg",  "bmat", "step", "curv", "curv2", "surf",
                                             "parm",   "trim", "hole", "scrv", "sp",   "end",   "con",
                                             "bzp",    "bsp",  "cdc",  "cdp",  "res",  "call",  "csh"};

bool contains(const std::vector<std::string>& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

}  // namespace

WordKind kindOf(std::string_view word) {
  if (contains(kPassedOver, word)) return WordKind::passedOver;
  if (contains(kNotSupported, word)) return WordKind::notSupported;
  if (contains(kMaterial, word) || word.starts_with("map_")) return WordKind::material;
  if (word.size() <= 2) {
    std::string lower(word);
    std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    if (contains(kShape, lower)) return WordKind::miswritten;
  }
  return WordKind::unknown;
}

std::string nearestWord(std::string_view word) {
  std::vector<std::string> known = kShape;
  known.insert(known.end(), kPassedOver.begin(), kPassedOver.end());
  return nearestName(word, known);
}

}  // namespace turner::obj
