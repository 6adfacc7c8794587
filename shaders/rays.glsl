// Rays from the surface in hand, for whoever edits the kernel; ray() of ray.glsl is from elsewhere. Each is true from wherever it starts and wherever it goes: traverse() itself finds out
// whether a light buffer has a list for it, and takes the tree if not (checkedStart).

Surface here;  // the surface that is in hand: where currentRay has hit, which is hitPrimitive

// A ray from the surface in hand in a unit direction, to the side of the surface to which that leads.
Ray rayAlong(const vec3 direction) {
  return leaveSurface(here, hitPrimitive, direction, dot(direction, here.Ng) >= 0.0);
}

// A ray from the surface in hand to a point, where it ends: startShadowRay() looks for what is before that.
Ray rayToward(const vec3 point) {
  Ray toward = leaveSurface(here, hitPrimitive, vec3(0), dot(point - here.point, here.Ng) >= 0.0);
  toward.direction = point - toward.origin;
  return toward;
}

// The same to a light, wherever that was moved.
Ray rayToLight(const Light light) { return rayToward(light.position); }
