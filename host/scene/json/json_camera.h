// The camera of a JSON scene.
#pragma once

#include <cstddef>

#include "scene/json/json_fields.h"
#include "scene/scene.h"

namespace turner {

// Reads the object at this place of the tree, and notes what is wrong: fields, and a view without a direction.
void readCamera(JsonFields& fields, size_t at, const Field& field, Camera& camera);

}  // namespace turner
