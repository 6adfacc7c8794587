// Where rays truly start, and which of them may use a light buffer's list: for edited kernels (edited.glsl), in which a ray
// may have been moved or turned after it was made. Checked, not assumed.
#ifdef EDITED

// How high a point is above a primitive, how much of that may be rounding, and the direction away from it.
struct Height {
  float value, bound;
  vec3 outward;
};

Height heightAbove(const vec3 point, const uint primitive) {
  Height height = Height(kNoHit, 0.0, vec3(0));
  uint type = typeOf(primitive), offset = primitive & kRefOffsetMask;
  if (SPHERES && type == kSpheres) {
    SphereData sphere = sphereOf(sphereAt(offset));
    height.outward = point - sphere.center;
    height.value = length(height.outward) - abs(sphere.radius);
    height.bound = 2.0 * kRounding * (largest(abs(sphere.center)) + abs(sphere.radius));
  }
  if (CONES && type == kCones) {
    Cone cone = coneAt(offset);
    vec3 f = point - cone.anchor;
    float s = dot(f, cone.axis), cosine = sqrt(cone.squaredCosine);
    vec3 y = f - s * cone.axis;
    height.outward = cosine * y - cone.slope * length(y) * cone.axis;
    height.value = cosine * length(y) - (cone.base + cone.slope * s);
    height.bound = coneErrorBound(cone);
  }
  if (TRIANGLES && type == kPairs) {
    Plane plane = planeAt(offset, uint((primitive & kRefSecond) != 0u), true);
    height.value = dot(plane.normal, point) - plane.offset;
    height.bound = planeErrorBound(plane.normal, plane.offset, point);
  }
  return height;
}

// A ray that says of the primitive on which it starts what is true: none, if it starts elsewhere; and of a sphere or a cone
// whether it goes inside. Within 16 bounds of the surface it is where leaveSurface() puts it, and nearer to grazing than a
// thousandth rounding decides, so that a ray as the kernel makes it stays as it is.
Ray trueStart(const Ray ray) {
  uint primitive = ray.originPrimitive & ~kStartsInward;
  Height height = heightAbove(ray.origin, primitive);
  float slope = dot(height.outward, ray.direction), grazing = 1e-3 * length(height.outward) * length(ray.direction);
  uint side = ray.originPrimitive & kStartsInward;
  if (abs(slope) > grazing) side = slope < 0.0 ? kStartsInward : 0u;
  bool startsThere = ray.originPrimitive != kRefNone && abs(height.value) <= 16.0 * height.bound;
  return Ray(ray.origin, ray.direction, startsThere ? primitive | side : kRefNone);
}

// Whether a direction from the eye is one of this invocation's pixel: the eye's lists have what such rays can hit. With
// room for the rounding of the pixel's place.
bool isThroughPixel(const vec3 direction) {
  // From memory: what is in registers may be edited.
  vec3 centre = frameInMemory.centreHi, right = frameInMemory.rightHi, down = frameInMemory.downHi;
  float depth = dot(direction, centre) / dot(centre, centre);
  vec2 place = vec2(dot(direction, right) / dot(right, right), dot(direction, down) / dot(down, down)) / depth;
  vec2 size = vec2(ivec2(int(frameInMemory.width), int(frameInMemory.height)));
  vec2 fromMiddle = abs(place + 0.5 * size - vec2(ivec2(pixel)) - 0.5);
  return depth > 0.0 && max(fromMiddle.x, fromMiddle.y) <= 0.5 + 1e-6 * max(size.x, size.y);
}

// Whether a ray ends at a light, as the rays do that its lists are made for: where the scene has it.
bool endsAt(const Ray ray, const uint light) {
  precise vec3 toward = xyz(WORD4(lights, kLightWords * light)) - ray.origin;
  return all(equal(toward, ray.direction));
}
#endif
