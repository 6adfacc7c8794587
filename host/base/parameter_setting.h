// A value that somebody gives to a parameter of the shaders, before it is known whether there is such a parameter.
#pragma once

#include <string>
#include <vector>

namespace turner {

struct ParameterSetting {
  std::string name;
  std::vector<double> values;
  bool isBoolean = false;  // true or false, as 1 or 0
  std::string place;       // what begins a message about it: "scene.json:5:17: error: params.softness"

  template <class Bytes>
  void fields(Bytes& b) {
    b(name, values, isBoolean, place);
  }
};

}  // namespace turner
