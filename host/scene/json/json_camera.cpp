// Eye and target must differ, and up must tell how the camera is turned.
#include "scene/json/json_camera.h"

#include <glm/geometric.hpp>

#include "scene/json/unit_box.h"

namespace turner {
namespace {

constexpr NumberRule kFieldOfView{[](double x) { return x > 0 && x < 180; },
                                  "a number of degrees greater than 0 and less than 180"};

// Nothing is seen when there is no direction to look in, or when it leaves open how the camera is turned about it.
const char* findCameraFault(const Camera& camera) {
  const glm::dvec3 view = camera.target - camera.eye;
  // Its square must not vanish, for its length is the unit that the scene is measured in.
  constexpr double kLeastDistance = 1e-30;
  if (glm::length(view) < kLeastDistance) return "eye and target are the same point; they must differ";
  if (camera.up == glm::dvec3(0)) return "up is [0, 0, 0]; it must have a direction";
  // The sine between the two: decimals may make what is meant to be parallel not quite so.
  constexpr double kLeastSine = 1e-9;
  const glm::dvec3 a = scaleToUnitBox(view), b = scaleToUnitBox(camera.up);
  if (glm::length(glm::cross(a, b)) <= kLeastSine * glm::length(a) * glm::length(b))
    return "up is parallel to the direction of view; it must point to a side of it";
  return nullptr;
}

}  // namespace

void readCamera(JsonFields& fields, size_t at, const Field& field, Camera& camera) {
  bool hasEye = false, hasTarget = false, hasUp = true;
  const auto vectorInto = [&](glm::dvec3& vector, bool& isGood) {
    return [&](size_t place, const Field& name) { isGood = fields.readVector(place, name, kAnyNumber, vector); };
  };
  fields.readObject(at, field,
                    {{"eye", true, vectorInto(camera.eye, hasEye)},
                     {"target", true, vectorInto(camera.target, hasTarget)},
                     {"up", false, vectorInto(camera.up, hasUp)},
                     {"fov", false, [&](size_t place, const Field& name) {
                        fields.readNumber(place, name, kFieldOfView, camera.fov);
                      }}});
  if (!hasEye || !hasTarget || !hasUp) return;
  if (const char* fault = findCameraFault(camera)) fields.addMessage(at, field, fault);
}

}  // namespace turner
