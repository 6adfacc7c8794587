// What --price puts in the place of leaveSurface: a ray starts where the surface's point was rounded to.
Ray leaveSurface(const Surface surface, const uint primitive, const vec3 direction, const bool above) {
  bool inward = above != surface.outside;
  return Ray(surface.point, direction, primitive | (inward ? kLeavesInward : 0u));
}
